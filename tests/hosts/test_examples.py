"""The paper's figures."""

import subprocess
import sys

from conftest import ROOT


def test_the_papers_experiments(paper):
    """All figures; every number of their table holds."""
    out, done = paper
    assert done.returncode == 0, done.stdout + done.stderr
    assert "DIFFERS" not in done.stdout
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
