"""README and docs: every command and program in them is run as it stands, but for what would take long, in a copy of
the checkout, and every link leads somewhere. The FMU that the first command compiles there has the same bytes.

A block that cannot be run here follows a comment with the reason: `<!-- not run here: REASON -->`.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT, SCRIPTS, ended, table
from markdown_it import MarkdownIt

from checkout import FMU, VENV, old_linux, rustc

pytestmark = pytest.mark.all

# The pictures, in docs/paper.md, show what the commands of the others leave.
LAST = "docs/paper.md"
DOCUMENTS = [path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").rglob("*.md")]
DOCUMENTS = ["README.md", *sorted(DOCUMENTS, key=lambda name: (name == LAST, name))]
# Their links are checked as well.
OTHERS = ["CONTRIBUTING.md", "CHANGELOG.md", ".github/SECURITY.md"]
PAPER = "python3 cradle.py paper\n"
# What would take long gets less to do: a build for the target that the first command has compiled for, fewer cases.
LESS = {
    "cargo pack build --release\n": " ".join(["cargo pack build --release", *old_linux()[0], "--out out/same.fmu\n"]),
    "/couple.py\n": "/couple.py --steps 2\n",
    "/study.py\n": "/study.py --orders 1 3 --dead-bands 0 1.6 --dampings 0 0.2 --lifted 1 2\n",
}
RAN: set[str] = set()  # the code that has been run: it is not run again where another document has it, too
NOT_RUN = re.compile(r"<!-- not run here: (.+?) -->", re.DOTALL)


def blocks(document: str) -> list:
    """What a document shows to be run: its code but for formulas and listings, and what is marked. The language,
    `info`, is empty for indented blocks, which are commands."""
    found, marked = [], False
    for token in MarkdownIt().parse((ROOT / document).read_text(encoding="utf-8")):
        code = token.type in ("fence", "code_block")
        if code and token.info != "text" and not marked:
            found.append(token)
        if code or token.content:  # the end of a paragraph has none
            marked = NOT_RUN.search(token.content) is not None
    return found


@pytest.fixture(scope="module")
def checkout(tmp_path_factory, fmu_path) -> Path:
    """A copy of the checkout with its FMU, whose commands may leave what they like. It has the packages of others as
    they are compiled here, so that Cargo compiles what is in the copy and no more."""
    folder = tmp_path_factory.mktemp("documents") / "newtons-cradle"
    shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns("target", "out", ".venv", ".git", "__pycache__"))
    (folder / ".venv").symlink_to(Path(sys.prefix), target_is_directory=True)
    (folder / "target").mkdir()
    (folder / "target/zig").symlink_to(ROOT / "target/zig", target_is_directory=True)
    for compiled in (Path("target/release"), Path("target", rustc("host-tuple"), "release")):
        if (ROOT / compiled).exists():
            shutil.copytree(ROOT / compiled, folder / compiled, ignore=shutil.ignore_patterns("*cradle*"))
    (folder / "target/fmu").mkdir()
    shutil.copy(fmu_path, folder / "target/fmu")
    return folder


@pytest.mark.skipif(os.name == "nt", reason="the documents' commands are those of a Unix shell")
@pytest.mark.skipif(Path(sys.prefix).resolve() != VENV.resolve(), reason="they need the .venv that cradle.py makes")
@pytest.mark.parametrize("document", [document for document in DOCUMENTS if blocks(document)])
def test_documents_commands_run(checkout, producer, fmu_path, document):
    path = f"{Path(sys.prefix) / 'bin'}{os.pathsep}{producer.parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path}
    for cache in ("ZIG_GLOBAL_CACHE_DIR", "CARGO_ZIGBUILD_CACHE_DIR"):
        environment[cache] = str(checkout / "target/zig")
    file = checkout / "out/cradle.toml"
    file.parent.mkdir(exist_ok=True)
    build = [producer, "build", "--from", fmu_path, "--parameters", file, "--out", file.with_suffix(".fmu")]
    commands = {"": ["bash", "-ec"], "python": [sys.executable, "-c"], "toml": build}
    for block in blocks(document):
        code, command = block.content, commands[block.info]
        if code in RAN:
            continue
        RAN.add(code)
        print(f"{document}:{block.map[0] + 1}\n{code}")  # shown if it fails
        if block.info == "toml":
            file.write_text(code, encoding="utf-8")
        else:
            for whole, less in LESS.items():
                code = code.replace(whole, less)
            command = [*command, code]
        ended(*command, cwd=checkout, env=environment)
        if block.content == PAPER and fmu_path == FMU:
            assert (checkout / FMU.relative_to(ROOT)).read_bytes() == FMU.read_bytes(), "not the same bytes"
    assert PAPER in RAN or document != DOCUMENTS[0]


def test_documents_links_lead_somewhere():
    """Also to a heading, but for links to the live page: the site has it, and test_live_page.py opens them."""
    command = [
        SCRIPTS / "rumdl",
        "check",
        "--no-cache",
        "--enable",
        "MD051,MD057",
        "README.md",
        "docs",
        "tests/README.md",
        *OTHERS,
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    wrong = [line for line in done.stdout.splitlines() if "[MD" in line and "'cradle.html'" not in line]
    assert done.returncode in (0, 1) and not wrong, done.stdout + done.stderr


def test_documents_readme_shows_the_measured_times():
    shown = table("README.md", "## How fast")
    measured = table("docs/performance.md", "## Ten minutes of Figure 6")
    for name, solver in (
        ("this FMU", "eventDriven"),
        ("SUNDIALS CVODE, Adams, rtol 1e-12", "CVODE Adams, rtol 1e-12"),
    ):
        time, *_, energy_error = measured[solver]
        assert shown[name] == [f"{1000 * float(time):.3g} ms", energy_error]
    _, _, pulses, energy_error = measured["eventDriven"]
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"({pulses} pulses)" in text and f"relative energy error is {energy_error}." in text
