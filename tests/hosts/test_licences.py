"""The licences that travel in every FMU, and with the program, are those of what is linked into them."""

import re
from pathlib import Path

import licences
import pytest
from checkout import ROOT
from conftest import ended
from licences import FILES, OF_STD, STD, packages, texts

RUST = re.search(r'^version = "(.+)"', (STD / "Cargo.toml").read_text(), re.MULTILINE)[1]


@pytest.mark.parametrize("name", FILES)
def test_licences_are_those_of_what_is_linked_in(name):
    written = (ROOT / "packaging/assets" / name).read_text(encoding="utf-8")
    assert written == texts(*FILES[name]), f"out of date: {licences.__doc__}"


def test_packages_within_the_standard_library_are_listed(fmu):
    """The paths of panics in a library say which it has; their versions if it is that of releases."""
    libraries = (path.read_bytes() for path in (Path(fmu.folder) / "binaries").glob("*/NewtonsCradle.*"))
    paths = re.findall(rb"/rust/deps/([\w.-]+)", b"".join(libraries).replace(b"\\", b"/"))
    found = {path.decode() for path in paths}
    rustc = ended("rustc", "--version").stdout
    listed = {"-".join(key) for key in packages(STD, *OF_STD)}
    if RUST not in rustc:
        found, listed = ({name.rsplit("-", 1)[0] for name in names} for names in (found, listed))
    assert found and found <= listed


def test_releases_take_the_rust_whose_packages_are_listed():
    workflow = (ROOT / ".github/workflows/release.yml").read_text()
    assert f'RUSTUP_TOOLCHAIN: "{RUST}"' in workflow
