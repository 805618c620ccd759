"""The paper's figures, a master that takes part in events, a fit with derivatives of the run, C12, other engines, the
notebook."""

import csv
import json
import os
import re
import sys

import nbformat
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT, ended, repacked, table
from fmpy.fmi3 import FMU3Slave
from nbclient import NotebookClient
from newtons_cradle.fitting import seen
from pythonfmu.builder import FmuBuilder

pytestmark = pytest.mark.all

EXAMPLES = ROOT / "examples"
PAPER = EXAMPLES / "paper/run_all.py"
COUPLED = EXAMPLES / "mechatronics/couple.py"
PLANT = COUPLED.with_name("plant.py")
FIT = EXAMPLES / "fit/contacts.py"
STUDY = EXAMPLES / "study/study.py"
NOTEBOOK = EXAMPLES / "five_minutes.ipynb"


def test_example_paper(paper):
    """All figures; every number of their table holds."""
    out, done = paper
    assert "DIFFERS" not in done.stdout
    figures = [f"figure{i}" for i in (3, 4, 5, 6)]
    for name in [*figures, "stiffness", "dead_band", "hertz"]:
        assert (out / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    table = (out / "table1.csv").read_text().splitlines()
    assert table[0] == "state,ball 1,ball 2,ball 3,ball 4,ball 5"
    assert table[-1] == "end,stopped,stopped,stopped,moving,moving"


def test_example_controller_acts_at_the_onset(fmu3, tmp_path):
    """With event mode it keeps the exact energy and tempo; on a grid the errors shrink with the step only."""
    script = EXAMPLES / "events/metronome.py"
    ended(sys.executable, script, "--fmu", fmu3.path, "--out", tmp_path, "--stop", "4.5")
    assert (tmp_path / "metronome.png").read_bytes().startswith(b"\x89PNG")
    events, *grids = csv.DictReader((tmp_path / "metronome.csv").open())
    assert events["clicks"] == "4" and float(events["energy_error"]) < 1e-13
    assert float(events["time_error"]) < 1e-13 and int(events["calls"]) < 50
    for grid in grids:
        # Each of four clicks is seen late by up to a step; in 10 ms the force does 0.8 % of the energy.
        step = float(grid["step"])
        assert grid["clicks"] == "4" and float(grid["energy_error"]) < 9 * step
        assert float(grid["energy_error"]) > 1e-2 * step
        assert float(grid["time_error"]) == pytest.approx(2 * step, abs=2 * step)
        assert float(grid["time_error"]) > 1e-2 * step and int(grid["calls"]) == round(4.5 / step)


def test_example_losses_over_the_speed(fmu, tmp_path):
    """All have the same e at 1 m/s; the table of docs/loss-laws.md, and how 1 - e grows with slow speeds, for Hertz contacts
    and linear ones."""
    ended(sys.executable, EXAMPLES / "losses/laws.py", "--fmu", fmu.path, "--out", tmp_path)
    assert (tmp_path / "laws.png").read_bytes().startswith(b"\x89PNG")
    e = {}
    for row in csv.DictReader((tmp_path / "laws.csv").open()):
        e[row["contacts"].split()[0], row["law"], round(float(row["speed"]), 6)] = float(row["restitution"])
    shown = table("docs/loss-laws.md", "writes this plot and the numbers, `out/losses/laws.csv`. For Hertz contacts:")
    laws = ("kelvinVoigt", "kelvinVoigtNoPull", "huntCrossley", "viscoelastic", "constantRestitution", "rigid")
    for speed in (0.001, 0.01, 0.1, 1.0, 10.0):
        assert shown[f"{speed:g}"] == [f"{e['Hertz', law, speed]:.4f}" for law in laws[:5]]
        assert e["Hertz", "rigid", speed] == pytest.approx(e["Hertz", "constantRestitution", speed], abs=1e-12)
        for law in laws:
            assert e["linear", law, speed] == pytest.approx(0.9, abs=1e-9) or law == "huntCrossley"
    assert all(e[contacts, law, 1.0] == pytest.approx(0.9, abs=1e-9) for contacts, law, _ in e)
    for law, power in (("huntCrossley", 1.0), ("viscoelastic", 0.2)):
        slow, fast = (1.0 - e["Hertz", law, speed] for speed in (0.001, 0.01))
        assert np.log10(fast / slow) == pytest.approx(power, abs=0.01)


def test_example_fit_finds_stiffness_and_damping(fmu3, tmp_path):
    """Within the statistical error, which is small, and in no more runs than iterations need."""
    done = ended(sys.executable, FIT, "--fmu", fmu3.path, "--out", tmp_path)
    assert (tmp_path / "contacts.png").read_bytes().startswith(b"\x89PNG")
    for row in csv.reader((tmp_path / "contacts.csv").read_text().splitlines()[1:]):
        true, guess, fitted, error = map(float, row[2:])
        assert 0.0 < error < 0.01 * true
        assert abs(fitted - true) < 3 * error < abs(guess - true) / 10
    # With an exact Jacobian the fit converges fast: differences would take three runs for each iteration.
    iterations, runs = (int(done.stdout.split(word)[0].split()[-1]) for word in (" iterations", " runs"))
    assert iterations <= 6 and runs <= iterations + 2


def test_example_fit_uses_the_derivatives_of_the_run(fmu3, monkeypatch):
    """Its Jacobian is that of the positions, and without it there is no fit."""
    monkeypatch.syspath_prepend(FIT.parent)
    import contacts

    film, names = contacts.film(fmu3, contacts.TRUE), list(contacts.TRUE)
    track = {"time": np.arange(1, len(film) + 1) / contacts.RATE, "x": film}
    found, jacobian = seen(fmu3, contacts.LINEAR | contacts.TRUE, ["x"], track["time"].tolist(), names)
    assert np.array_equal(found, film)
    for i, (name, value) in enumerate(contacts.TRUE.items()):
        more, less = (contacts.film(fmu3, contacts.TRUE | {name: value * (1 + sign * 1e-5)}) for sign in (1, -1))
        difference = (more - less) / 2e-5
        assert np.abs(difference).max() > 5e-3  # m, for a parameter that changes by its own size
        assert np.abs(jacobian[:, :, i] * value - difference).max() < 1e-6 * np.abs(difference).max()
    true = FMU3Slave.getDirectionalDerivative
    for wrong, complaint in ((-1.0, "no step along the derivatives"), (0.0, "tell these parameters apart")):
        scaled = lambda *given, factor=wrong: [factor * value for value in true(*given)]  # noqa: E731
        monkeypatch.setattr(FMU3Slave, "getDirectionalDerivative", scaled)
        with pytest.raises(nc.FmuError, match=complaint):
            nc.fit(track, by=contacts.GUESS, fmu=fmu3, values=contacts.LINEAR)


def test_example_c12_agrees_with_independent_results(fmu_path, tmp_path):
    """In every task, to rounding; and compliant contacts approach rigid ones as they become short."""
    ended(sys.executable, EXAMPLES / "c12/spheres.py", "--fmu", fmu_path, "--out", tmp_path)
    rigid, _, compliant = (tmp_path / "report.md").read_text(encoding="utf-8").partition("## Compliant")
    differences = re.findall(r"differ[^.;|]* (-?[\d.]+e[+-]\d+)", rigid)
    assert len(differences) == 6 and max(abs(float(value)) for value in differences) < 1e-15
    assert "another number of collisions\nin 0 cases" in rigid
    limits = re.findall(r"differ by (\S+) m, of 1 µs by (\S+) m", compliant)
    assert len(limits) == 3
    for long, short in limits:
        assert float(short) == pytest.approx(1e-5 * float(long), rel=0.2) and float(short) > 0


def test_example_engines_results_are_those_of_the_document(monkeypatch):
    """Those that are committed, of cases of the benchmark, with the versions that are pinned."""
    monkeypatch.syspath_prepend(EXAMPLES / "engines")
    import compare

    results = json.loads((EXAMPLES / "engines/results.json").read_text(encoding="utf-8"))
    assert compare.table(results) in (ROOT / "docs/makers/engines.md").read_text(encoding="utf-8")
    cases = json.loads((ROOT / "exact-rows/cases.json").read_text(encoding="utf-8"))["cases"]
    assert {run["row"] for run in results["runs"]} == set(compare.ROWS) <= {case["name"] for case in cases}
    pinned = (EXAMPLES / "engines/requirements.txt").read_text(encoding="utf-8")
    assert all(f"=={version}\n" in pinned for version in results["versions"].values())


def test_example_engines_page_shows_what_the_fmu_predicts(fmu_path):
    """Velocities, the times of contacts, and the factors of a wave, but not how long the runs took."""
    printed = ended(sys.executable, EXAMPLES / "engines/experiments.py", "--fmu", fmu_path).stdout.split(
        "equal-5-hertz"
    )[0]
    page = (ROOT / "docs/makers/engines.md").read_text(encoding="utf-8")
    numbers = re.findall(r"-?\d\.\d{4,}", printed)
    assert len(numbers) > 20 and [number for number in numbers if number not in page] == []


@pytest.mark.parametrize(
    ("example", "given", "complaint"),
    [
        (PAPER, ["--balls", "4"], "has 4 balls where 5 are needed"),
        (COUPLED, ["--set", "contact.model=rigid"], "contact.model = rigid where powerLaw is needed"),
        (FIT, [], "is of FMI 2.0; a fit needs FMI 3.0"),
        (FIT, ["--fmi", "3", "--balls", "1"], "does not tell these parameters apart"),
        (FIT, ROOT / "none.fmu", "none.fmu is missing: build it with `cargo pack build --release --fmi 3`"),
        (FIT, FIT, "contacts.py is not an FMU that can be read"),
        (STUDY, ["--set", "contact.gap[2]=1e-6"], "contact.gap[2] = 1e-06 m where 0 m is needed"),
        (STUDY, ["--balls", "2"], "it has 2 balls where 3 or more are needed"),
        (STUDY, ROOT / "none.fmu", "none.fmu"),
        (STUDY, PLANT, "it is the model CartAndCoil; allowed: NewtonsCradle"),
    ],
)
def test_example_refuses_another_fmu(fmu_path, producer, tmp_path, example, given, complaint):
    """Before any run, in a sentence: no traceback, no table of checks that fail."""
    if isinstance(given, list):
        path = repacked(producer, fmu_path, tmp_path / "other.fmu", *given)
    else:
        path = FmuBuilder.build_FMU(given, tmp_path, [given.with_suffix(".xml")]) if given == PLANT else given
    more = ["--workers", "1", "--orders", "1", "2"] if example == STUDY else []
    out = tmp_path / "out"
    command = [sys.executable, example, "--fmu", path, "--out", out, *more]
    done = ended(*command, code=1)
    *before, said = done.stderr.splitlines()
    assert complaint in said and "Traceback" not in done.stderr
    assert said.startswith("error: ") or "is missing" in said
    assert (str(path) in said and not before) or example != FIT
    assert "DIFFERS" not in done.stdout and "runs" not in done.stdout
    assert not out.exists() or not list(out.iterdir())


def test_example_notebook_leads_to_figure_5(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python"), "IPYTHONDIR": str(tmp_path)}
    client = NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute(env=environment)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 4
    printed = "".join(output["text"] for output in outputs if output["output_type"] == "stream")
    assert "5 balls" in printed
    assert "in the order in which they close: [[2], [1, 3], [2, 4], [3]]" in printed
    assert not any(output.get("name") == "stderr" for output in outputs)


def test_example_notebook_is_kept_without_outputs():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells and all(cell.outputs == [] and cell.execution_count is None for cell in cells)
