"""The sources: no file of Rust imports one that imports it, directly or through others. The licences that travel in
every FMU, and with the program, are those of what is linked into them."""

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from conftest import ended

from checkout import ROOT, licences
from checkout.licences import FILES, OF_STD, STD, packages, texts


def modules(folder) -> dict:
    """The text of each module without its tests and comments, by the parts of its path."""
    found = {}
    for file in folder.rglob("*.rs"):
        parts = file.relative_to(folder).with_suffix("").parts
        text = file.read_text(encoding="utf-8").split("#[cfg(test)]")[0]
        found[parts[:-1] if parts[-1] in ("mod", "lib") else parts] = re.sub(r"//[^\n]*", "", text)
    return found


def paths(tree: str) -> list:
    """The paths in a tree of a `use` declaration, whose innermost braces are resolved one after the other."""
    while braces := re.search(r"([\w:]*){([^{}]*)}", tree):
        head, branches = braces.groups()
        tree = tree.replace(braces[0], ",".join(head + branch.strip() for branch in branches.split(",")))
    found = (path.split(" as ")[0].strip() for path in tree.split(","))
    return [path.split("::") for path in found if path and not path.endswith("::")]


def imports(texts: dict) -> dict:
    """The modules that each one imports; what is exported again counts for the module that has it."""
    uses = {
        module: [
            (bool(public), path)
            for public, tree in re.findall(r"(?m)^\s*(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);", text)
            for path in paths(tree)
        ]
        for module, text in texts.items()
    }

    def target(module, path):
        place, path = [] if path[0] == "crate" else list(module), list(path)
        while path and path[0] in ("crate", "self", "super"):
            if path.pop(0) == "super":
                place.pop()
        while path and (*place, path[0]) in texts:
            place.append(path.pop(0))
        for public, again in uses[tuple(place)] if path else ():
            if public and path[0] == again[-1] != again[0]:  # else the module of that name is exported
                return target(tuple(place), again)
        return tuple(place)  # The module itself, if the path is of another crate.

    return {
        module: {target(module, path) for public, path in used if not public} - {module}
        for module, used in uses.items()
    }


@pytest.mark.parametrize("folder", ["src", "packaging/src", "web/src"])
def test_sources_import_in_no_circle(folder):
    """If one does, graphlib names the modules."""
    texts = modules(ROOT / folder)
    graph = imports(texts)
    assert len(texts) == 1 or any(graph.values())
    TopologicalSorter(graph).prepare()


RUST = re.search(r'^version = "(.+)"', (STD / "Cargo.toml").read_text(), re.MULTILINE)[1]


@pytest.mark.parametrize("name", FILES)
def test_licences_are_those_of_what_is_linked_in(name):
    written = (ROOT / "packaging/assets" / name).read_text(encoding="utf-8")
    assert written == texts(*FILES[name]), f"out of date: {licences.__doc__}"


def test_licences_list_the_standard_librarys_packages(fmu):
    """The paths of panics in a library say which it has; their versions if it is that of releases."""
    libraries = (path.read_bytes() for path in (Path(fmu.folder) / "binaries").glob("*/NewtonsCradle.*"))
    paths = re.findall(rb"/rust/deps/([\w.-]+)", b"".join(libraries).replace(b"\\", b"/"))
    found = {path.decode() for path in paths}
    rustc = ended("rustc", "--version").stdout
    listed = {"-".join(key) for key in packages(STD, *OF_STD)}
    if RUST not in rustc:
        found, listed = ({name.rsplit("-", 1)[0] for name in names} for names in (found, listed))
    assert found and found <= listed


def test_licences_are_those_of_the_releases_rust():
    workflow = (ROOT / ".github/workflows/release.yml").read_text()
    assert f'RUSTUP_TOOLCHAIN: "{RUST}"' in workflow
