"""The wheel in a bare virtual environment: no checkout, no Rust, no compiler."""

import os
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import newtons_cradle as nc
import pytest
from conftest import ROOT, ended

pytestmark = pytest.mark.all

FIGURE_5 = """
import newtons_cradle as nc

with nc.Fmu() as fmu, fmu.start(nc.figure5()) as run:
    onset, micro = run.zoom(span=1.1e-6, step=1e-9, record=["F"], before=5e-8)
micro.plot("F", origin=onset).savefig("figure5.png")
print(nc.pulse_order(micro.pulses), fmu.path, nc.__version__, *nc.presets())
"""


@dataclass
class Bare:
    """A virtual environment with the wheel, and a folder to work in."""

    programs: Path
    folder: Path

    def run(self, *command) -> subprocess.CompletedProcess:
        """Runs a program of the environment, with nothing else on the path."""
        environment = {"PATH": str(self.programs), "HOME": str(self.folder), "LANG": "C.UTF-8"}
        if "SYSTEMROOT" in os.environ:
            environment["SYSTEMROOT"] = os.environ["SYSTEMROOT"]
        return ended(self.programs / command[0], *command[1:], cwd=self.folder, env=environment)


@pytest.fixture(scope="module")
def wheel() -> Path:
    """The wheel that `cradle.py wheel` has left."""
    found = list((ROOT / "target/wheel").glob("*.whl"))
    if not found:
        pytest.skip("there is no wheel: `python3 cradle.py wheel`")
    return found[0]


@pytest.fixture(scope="module")
def bare(wheel, tmp_path_factory) -> Bare:
    """The wheel with its extra `plot` in an empty environment; what it needs is downloaded first."""
    root = tmp_path_factory.mktemp("bare")
    folder, downloads, programs = root / "work", root / "downloads", root / "venv/bin"
    folder.mkdir()
    wanted = f"{wheel}[plot]"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    loaded = subprocess.run([*pip, "download", "-q", "-d", downloads, wanted], capture_output=True, text=True)
    if loaded.returncode != 0:
        pytest.skip(
            f"the packages that it needs cannot be downloaded: {loaded.stderr.strip().splitlines()[-1]}"
        )
    subprocess.run([sys.executable, "-m", "venv", root / "venv"], check=True)
    offline = ["install", "-q", "--no-index", "--find-links", downloads, wanted]
    subprocess.run([programs / "python", "-m", "pip", *offline], check=True)
    return Bare(programs, folder)


def test_from_install_to_figure_5(bare):
    bare.run("cradle-fmu", "build", "--balls", "13", "--out", "thirteen.fmu")
    drawn = bare.run("python", "-c", FIGURE_5)
    assert (bare.folder / "figure5.png").read_bytes().startswith(b"\x89PNG")
    order, path = drawn.stdout.split("]] ")[0], drawn.stdout.split("]] ")[1].split()[0]
    assert order == "[[2], [1, 3], [2, 4], [3"
    assert "site-packages" in path
    assert drawn.stdout.split()[-1 - len(nc.presets()) :] == [nc.__version__, *nc.presets()]
    with nc.Fmu(bare.folder / "thirteen.fmu") as fmu:
        fmu.require(balls=13)
        assert len(fmu.simulate(nc.preset("figure3"), stop=1.0).pulses) > 0


def test_a_page_needs_nothing_else(bare):
    """The template, the scripts and, where it has been built, the engine come along."""
    bare.run("cradle-fmu", "build", "--preset", "desk", "--out", "desk.fmu")
    bare.run("cradle-fmu", "page", "desk.fmu", "--stop", "1")
    text = (bare.folder / "desk.html").read_text(encoding="utf-8")
    assert '"title": "5 balls, 1 s"' in text and "#engine/recording.js" in text


def test_the_licences_come_along(wheel):
    """Of this project and of all that is linked in; and the marker for type checkers."""
    names = zipfile.ZipFile(wheel).namelist()
    for name in ("LICENSE-MIT", "LICENSE-APACHE", "third-party.txt"):
        assert any(entry.endswith(name) and ".dist-info/licenses/" in entry for entry in names)
    assert "newtons_cradle/py.typed" in names
