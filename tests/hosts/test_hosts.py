"""The default experiment in other hosts: the same numbers at the same times, to the last digit, as in FMPy.

The step is a power of two, so that every host, however it counts, arrives at the same doubles.
"""

import csv
import shutil
import sys

import fmpy
import numpy as np
import pytest
from conftest import ROOT, SCRIPTS, ended, repacked
from other_hosts import container

pytestmark = pytest.mark.all

STEP = 1 / 128  # s
STOP = 10.0  # s
STEPS = 1280


@pytest.fixture(scope="module")
def plain(fmu_path):
    """The experiment in FMPy, without anything special."""
    result = fmpy.simulate_fmu(str(fmu_path), stop_time=STOP, output_interval=STEP)
    assert result["time"].tolist() == [i * STEP for i in range(STEPS + 1)]
    assert sum(result[f"pulses[{i}]"][-1] for i in range(1, 5)) == 42
    return result


def same(theirs, plain) -> None:
    """Every output in every row; `theirs[name]` is a column."""
    for name in plain.dtype.names:
        column = np.asarray(theirs[name], dtype=plain[name].dtype)
        assert column.tobytes() == plain[name].tobytes(), name


def fmi_sim(kind, fmu_path, step, folder) -> list[dict]:
    """The rows of a run by the program of the fmi-rs project."""
    simulator = shutil.which("fmi-sim", path=ROOT / "target/hosts/debug")
    if not simulator:
        pytest.skip("fmi-sim is missing: tests/hosts/fmi-rs/Cargo.toml says how to make it")
    options = ["--model", fmu_path, "-o", "out.csv", kind, "-f", STOP, "--output-interval", step]
    ended(simulator, *options, cwd=folder)
    with (folder / "out.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_fmi_sim(fmu_path, plain, tmp_path):
    rows = fmi_sim("co-simulation", fmu_path, STEP, tmp_path)
    booleans = {"true": 1, "false": 0}
    same({name: [booleans.get(row[name], row[name]) for row in rows] for name in plain.dtype.names}, plain)


def test_fmi_sim_integrates(fmu_path, tmp_path):
    """The same program in model exchange, by Euler's method: as FMPy's Euler does."""
    last = fmi_sim("model-exchange", fmu_path, 1e-3, tmp_path)[-1]
    assert [int(last[f"pulses[{i}]"]) for i in range(1, 5)] == [7, 14, 14, 7]
    grown = float(last["E_total"]) / 0.05
    assert 1.0 < grown < (1 + 5e-6) ** 10000 * (1 + 1e-9)


@pytest.mark.parametrize("kind", ["co-simulation", "model-exchange"])
def test_fmi_sim_with_scalars_of_fmi_3(fmu_path, producer, tmp_path, kind):
    """What it writes is that of FMI 2.0, digit by digit."""
    scalars = repacked(producer, fmu_path, tmp_path / "s.fmu", "--fmi", "3", "--scalars", "--clocks", "none")
    two, three = (fmi_sim(kind, path, STEP, tmp_path) for path in (fmu_path, scalars))
    assert two == three and len(two) > STEPS


def test_fmutool_finds_nothing(fmu_path, tmp_path):
    """The checks of the FMU Manipulation Toolbox."""
    done = ended(SCRIPTS / "fmutool", "-input", fmu_path, "-check", cwd=tmp_path)
    said = done.stdout + done.stderr
    assert "compliant with FMI-2.0" in said and "No semantic error" in said, said
    assert "ERROR" not in said and "WARNING" not in said, said


def test_inside_a_container(fmu, fmu_path, plain, tmp_path):
    """An FMU around ours, made by the FMU Manipulation Toolbox and run by FMPy; its steps are the container's."""
    if not sys.platform.startswith("linux"):
        pytest.skip("the container's binary is tried on Linux only")
    shutil.copy(fmu_path, tmp_path / "inner.fmu")
    inputs = [v.name for v in fmu.description.modelVariables if v.causality == "input"]
    done = ended(*container(tmp_path, STEP, inputs, plain.dtype.names[1:]), cwd=tmp_path)
    assert "ERROR" not in done.stdout + done.stderr, done
    same(fmpy.simulate_fmu(str(tmp_path / "outer.fmu"), stop_time=STOP, output_interval=STEP), plain)
