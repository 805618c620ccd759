"""What the documentation tells people to type works: its Python, the paper's figures."""

import re
import subprocess
import sys

import pytest
from conftest import ROOT

README = ROOT / "README.md"


def python_blocks(text: str) -> list[str]:
    """The ```python blocks of a Markdown text."""
    return re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)


EXAMPLES = [
    pytest.param(code, id=f"{name}-{number}")
    for name in ("README.md", "docs/calibration.md")
    for number, code in enumerate(python_blocks((ROOT / name).read_text(encoding="utf-8")))
]


@pytest.mark.parametrize("code", EXAMPLES)
def test_example(fmu_path, tmp_path, code):
    """Each example of the documentation, run as a script in an empty folder."""
    code = code.replace("target/fmu/NewtonsCradle.fmu", fmu_path.as_posix())
    code = code.replace("nc.Fmu()", f'nc.Fmu("{fmu_path.as_posix()}")')
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_readme_names_what_is_there():
    """Every file and folder that the README links to exists."""
    text = README.read_text(encoding="utf-8")
    links = [target for target in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in target]
    assert len(links) >= 5
    assert [target for target in links if not (ROOT / target).exists()] == []


def test_the_papers_experiments(paper):
    """All figures; every number of their table holds."""
    out, done = paper
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FAILS" not in done.stdout
    for name in [
        "figure3",
        "figure4",
        "figure5",
        "figure6",
        "overlap_order",
        "stiffness",
        "dead_band",
        "hertz",
    ]:
        assert (out / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    table = (out / "table1.csv").read_text().splitlines()
    assert table[0] == "state,ball 1,ball 2,ball 3,ball 4,ball 5"
    assert table[-1] == "end,stopped,stopped,stopped,moving,moving"


def test_figures_refuse_the_wrong_fmu(fmu_path, tmp_path):
    """Five balls where 13 are needed: a sentence, not a traceback."""
    script = ROOT / "examples/paper/figure3.py"
    command = [sys.executable, script, "--fmu", fmu_path, "--fmu13", fmu_path, "--out", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.strip().endswith("has 5 balls where 13 are needed")
