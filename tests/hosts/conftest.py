"""Fixtures of the host tests: which FMU is tested.

The tests run against target/fmu/NewtonsCradle.fmu; another FMU is chosen by `pytest --fmu=FILE`.
"""

import re
import signal
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import newtons_cradle as nc
import pytest
from fmi3_host import Cradle
from newtons_cradle import files, testing
from newtons_cradle.page import PageError, save_page
from newtons_cradle.views import from_fmu

from checkout import FMU

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = Path(sys.executable).parent  # the virtual environment's programs
cradle = testing.cradle  # a fixture
# Where a shell has started the tests in the background, Ctrl-C is ignored, and by programs that they start as well.
signal.signal(signal.SIGINT, signal.default_int_handler)


def ended(*command, code: int = 0, **options) -> subprocess.CompletedProcess:
    """A program run to its end, with this exit code, and what it said."""
    command = [str(part) for part in command]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1800, **options)
    assert done.returncode == code, (done.stdout + done.stderr)[-3000:]
    return done


def repacked(producer: Path, fmu: Path, out: Path, *arguments) -> Path:
    """An FMU with the binaries of another one, packed anew with these arguments of `cradle-fmu build`."""
    ended(producer, "build", "--from", fmu, "--out", out, *arguments)
    return out


def table(document: str, heading: str) -> dict[str, list[str]]:
    """The first table below a heading, as the cells of each row by its first cell."""
    text = (ROOT / document).read_text(encoding="utf-8").split(f"\n{heading}\n")[1]
    rows = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE)[0].splitlines()
    cells = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]
    return {first: rest for first, *rest in cells}


def pytest_addoption(parser):
    parser.addoption("--fmu", type=Path, default=FMU, help="the FMU to test (default: %(default)s)")


def pytest_ignore_collect(collection_path, config):
    """The short test has not installed what the files import of which all tests are left out."""
    if config.option.markexpr == "not all" and collection_path.suffix == ".py":
        return "\npytestmark = pytest.mark.all\n" in collection_path.read_text(encoding="utf-8") or None
    return None


@pytest.fixture(scope="session")
def fmu_path(request) -> Path:
    """The FMU file under test."""
    path = request.config.getoption("--fmu")
    if not path.exists():
        pytest.exit(f"{path} is missing: build it with `cargo pack build --release`", returncode=2)
    return path.resolve()


@pytest.fixture(scope="session")
def fmu(fmu_path) -> nc.Fmu:
    """The FMU under test, unpacked once."""
    with nc.Fmu(fmu_path) as opened:
        yield opened


@pytest.fixture(scope="session")
def producer() -> Path:
    """The program cradle-fmu, newest first."""
    try:
        return files.producer()
    except nc.FileMissing as missing:
        pytest.skip(str(missing))


@pytest.fixture(scope="session")
def fmu3(cradle, fmu_path, producer) -> nc.Fmu:
    """The FMU under test as one of FMI 3.0, with the same binaries, unpacked once."""
    return cradle(fmi=3, binaries=fmu_path)


@pytest.fixture(params=["fmu", "fmu3"])
def either(request) -> nc.Fmu:
    """The FMU of either standard."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def make3(fmu3):
    """Makes instances of the FMU of FMI 3.0; see `Cradle`."""

    def make(*values, **options):
        made = Cradle(fmu3, *values, **options)
        runs.callback(made.run.close)
        return made

    with ExitStack() as runs:
        yield make


@pytest.fixture(scope="session")
def chromium():
    """Chromium, as browser.py starts it."""
    pytest.importorskip("selenium")
    from browser import Browser

    with Browser() as started:
        yield started


@pytest.fixture(scope="module")
def browser(chromium):
    """Chromium for the tests of a file. A page that moves takes a third of a core for as long as it is open, so none
    stays."""
    yield chromium
    chromium.get("about:blank")


@pytest.fixture(scope="session")
def axe() -> str:
    """The script of axe-core, as its package for Playwright has it; neither that nor npm is needed."""
    return pytest.importorskip("axe_playwright_python.base").AXE_SCRIPT


@pytest.fixture(scope="session")
def live_path(tmp_path_factory) -> Path:
    """The page without a recording."""
    path = tmp_path_factory.mktemp("live") / "cradle.html"
    try:
        save_page(path)
    except PageError as problem:
        pytest.skip(str(problem))
    return path


@pytest.fixture
def page(browser, live_path):
    """The live page, opened anew from disk, by a link, so that nothing moves by itself."""
    browser.open_cradle(live_path, "#preset=textbook", dark=True)
    yield browser
    browser.assert_quiet()


@pytest.fixture(scope="session")
def recorded_path(fmu_path, tmp_path_factory) -> Path:
    """The page of the default experiment."""
    path = tmp_path_factory.mktemp("recorded") / "cradle.html"
    save_page(path, from_fmu(fmu_path))
    return path


@pytest.fixture(scope="session")
def paper(fmu_path, producer, tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess]:
    """The paper's experiments, run as the main command runs them: their folder, and the finished process."""
    out = tmp_path_factory.mktemp("paper")
    script = ROOT / "examples/paper/run_all.py"
    return out, ended(sys.executable, script, "--fmu", fmu_path, "--out", out)
