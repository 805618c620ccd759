"""The wheel in a bare virtual environment: no checkout, no Rust, no compiler."""

import re
import subprocess
import sys
import zipfile
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
case = nc.benchmark("equal-2-hertz")
assert case.judge(case.run()).within
"""


@pytest.fixture(scope="module")
def wheel() -> Path:
    """The wheel that `cradle.py wheel` has left."""
    found = list((ROOT / "target/wheel").glob("*.whl"))
    if not found:
        pytest.skip("there is no wheel: `python3 cradle.py wheel`")
    return found[0]


@pytest.fixture(scope="module")
def work(tmp_path_factory) -> Path:
    """The folder to work in."""
    return tmp_path_factory.mktemp("work")


@pytest.fixture(scope="module")
def bare(wheel, work, tmp_path_factory):
    """The wheel with its extra `plot` in an empty virtual environment, whose programs this runs in the folder `work`
    with nothing else on the path; what it needs is downloaded first."""
    root = tmp_path_factory.mktemp("bare")
    downloads, programs = root / "downloads", root / "venv/bin"
    wanted = f"{wheel}[plot]"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    loaded = subprocess.run([*pip, "download", "-q", "-d", downloads, wanted], capture_output=True, text=True)
    if loaded.returncode != 0:
        pytest.skip(f"the packages that it needs cannot be downloaded: {loaded.stderr.strip().splitlines()[-1]}")
    subprocess.run([sys.executable, "-m", "venv", root / "venv"], check=True)
    offline = ["install", "-q", "--no-compile", "--no-index", "--find-links", downloads, wanted]
    subprocess.run([programs / "python", "-m", "pip", *offline], check=True)
    environment = {"PATH": str(programs), "HOME": str(work), "LANG": "C.UTF-8"}
    return lambda program, *arguments: ended(programs / program, *arguments, cwd=work, env=environment)


def test_wheel_from_install_to_figure_5(bare, work):
    bare("cradle-fmu", "build", "--balls", "13", "--out", "thirteen.fmu")
    drawn = bare("python", "-c", FIGURE_5)
    assert (work / "figure5.png").read_bytes().startswith(b"\x89PNG")
    order, path = drawn.stdout.split("]] ")[0], drawn.stdout.split("]] ")[1].split()[0]
    assert order == "[[2], [1, 3], [2, 4], [3"
    assert "site-packages" in path
    assert drawn.stdout.split()[-1 - len(nc.presets()) :] == [nc.__version__, *nc.presets()]
    with nc.Fmu(work / "thirteen.fmu") as fmu:
        fmu.require(balls=13)
        assert len(fmu.simulate(nc.preset("figure3"), stop=1.0).pulses) > 0


def test_wheel_makes_pages_by_itself(bare, work):
    """The template, the scripts and, where it has been built, the engine come along."""
    bare("cradle-fmu", "build", "--preset", "desk", "--out", "desk.fmu")
    bare("cradle-fmu", "page", "desk.fmu", "--stop", "1")
    text = (work / "desk.html").read_text(encoding="utf-8")
    assert '"title": "5 balls, 1 s"' in text and "#engine/recording.js" in text


def test_wheel_page_in_a_registry_has_no_relative_links(wheel):
    archive = zipfile.ZipFile(wheel)
    (metadata,) = (archive.read(name).decode() for name in archive.namelist() if name.endswith("/METADATA"))
    urls = dict(re.findall(r"^Project-URL: (\w+), (https://\S+)$", metadata, re.MULTILINE))
    address, site = urls["Source"], urls["Documentation"]
    owner, name = address.split("/")[-2:]
    assert site == f"https://{owner}.github.io/{name}/"
    links = re.findall(r"\]\(([^)]*)", metadata)
    assert all(link.startswith("https://") for link in links)
    pages = {f"{site}tools.html", f"{site}makers/hosts.html", f"{address}/blob/HEAD/CONTRIBUTING.md"}
    assert pages | {f"{address}/raw/HEAD/docs/cradle.jpg"} <= set(links)


def test_wheel_brings_its_licences(wheel):
    """Of this project and of all that is linked in; and the marker for type checkers."""
    names = zipfile.ZipFile(wheel).namelist()
    for name in ("LICENSE-MIT", "LICENSE-APACHE", "third-party.txt"):
        assert any(entry.endswith(name) and ".dist-info/licenses/" in entry for entry in names)
    assert "newtons_cradle/py.typed" in names
