"""The default experiment in other hosts: the same numbers at the same times, to the last digit, as in FMPy.

The step is a power of two, so that every host, however it counts, arrives at the same doubles.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import ROOT, SCRIPTS, ended, repacked
from other_hosts import container

pytestmark = pytest.mark.all

HOSTS = Path(__file__).with_name("python_hosts.py")
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


def program(name) -> Path:
    """A host that is a program in Rust."""
    found = shutil.which(name, path=ROOT / "target/hosts/debug")
    if not found:
        pytest.skip(f"{name} is missing: tests/hosts/fmi-rs/Cargo.toml says how to make it")
    return Path(found)


@pytest.mark.parametrize("kind", ["co-simulation", "model-exchange"])
def test_host_fmi_sim(fmu_path, producer, plain, tmp_path, kind):
    """The program of the rust-fmi project: what it writes of an FMU of FMI 3.0 with scalars is that of FMI 2.0, digit
    by digit. In model exchange, by Euler's method, the energy grows as it does in FMPy's."""
    scalars = repacked(producer, fmu_path, tmp_path / "s.fmu", "--fmi", "3", "--scalars", "--clocks", "none")

    def rows(fmu) -> list[dict]:
        options = ["--model", fmu, "-o", "out.csv", kind, "-f", STOP, "--output-interval", STEP]
        ended(program("fmi-sim"), *options, cwd=tmp_path)
        with (tmp_path / "out.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    two = rows(fmu_path)
    assert two == rows(scalars) and len(two) > STEPS
    if kind == "co-simulation":
        booleans = {"true": 1, "false": 0}
        same({name: [booleans.get(row[name], row[name]) for row in two] for name in plain.dtype.names}, plain)
    else:
        assert [int(two[-1][f"pulses[{i}]"]) for i in range(1, 5)] == [7, 14, 14, 7]
        assert 1.0 < float(two[-1]["E_total"]) / 0.05 < (1 + 5 * STEP**2) ** STEPS * (1 + 1e-9)


# With the number of elements: in FMI 3.0 arrays over contacts have another one, which belongs to none.
FAMILIES = {"x": 5, "v": 5, "E_total": 1, "p_total": 1, "impulse": 4, "pulses": 4}


def by_fmi_rs(fmu, names, step, folder, *options) -> tuple[dict, str]:
    """The last row at each time of a run by the crate fmi-rs, and what it finds wrong with the description."""
    out = folder / "out.csv"
    said = ended(program("run"), fmu, out, "-", ";".join(names), step, STOP, *options).stdout
    table = fmpy.read_csv(out)
    rows = np.hstack([table[name].reshape(len(table), -1)[:, : FAMILIES.get(name)] for name in names])
    return {time: row.tobytes() for time, row in zip(table["time"].tolist(), rows, strict=True)}, said


@pytest.mark.parametrize("options", [(), ("events",), ("events", "early"), ("located",)])
def test_host_fmi_rs_gives_the_same_bits_in_both_versions(fmu, fmu3, tmp_path, options):
    """Early return adds every onset and release. In model exchange, by a method that ends steps at events, the energy
    grows by that method, less at each step that an event or a communication point cuts in two."""
    pulses = fmu.simulate(stop=STOP).pulses
    instants = {*pulses["onset"].tolist(), *pulses["release"].tolist()}
    assert len(instants) > len(pulses)
    names = fmu.names(FAMILIES)
    for step in (0.125,) if "located" in options else (1 / 1024, 0.125, 10.0):
        two, said = by_fmi_rs(fmu.path, names, step, tmp_path, *options)
        three, _ = by_fmi_rs(fmu3.path, FAMILIES, step, tmp_path, *options)
        assert said == "" and max(two) == STOP
        if "located" in options:
            assert len(two) > 81 and two == three
            last, growth = np.frombuffer(two[STOP]), 5 * (step / 512) ** 2
            assert last[-4:].tolist() == [7, 14, 14, 7]
            most = 0.05 * (1 + growth) ** (STOP / step * 512)
            assert 1 - len(two) * growth / 2 < last[10] / most < 1
        else:
            assert len(two) == STOP // step + 1
            assert {time: three[time] for time in two} == two
            assert three.keys() - two.keys() == (instants if "early" in options else set())


@pytest.mark.parametrize("balls", [1, 2, 5, 13, 1000])
def test_host_crate_fmi_steps_from_event_to_event(fmu3, fmu_path, cradle, balls):
    """The positions of a run in one step, and a tick of the clocks for each onset and release."""
    stop = 1.0 if balls == 1000 else STOP
    lines = ended(program("events"), fmu3.path, balls, stop).stdout.splitlines()
    with cradle(balls=balls, fmi=3, binaries=fmu_path).start() as run:
        run.step_to(stop)
        x, pulses = run["x"].tolist(), run.slave.get("pulses").tolist()
    assert [json.loads(line) for line in lines] == [x, pulses, pulses, pulses]
    assert balls == 1 or any(pulses)


def test_host_fmi_rs_validation_findings(fmu_path, fmu3, producer, tmp_path):
    """FMPy wants output clocks among the initial unknowns, this crate does not, and neither minds an FMU without."""
    without = repacked(producer, fmu_path, tmp_path / "no-clocks.fmu", "--fmi", "3", "--clocks", "none")
    with_clocks, none = (by_fmi_rs(fmu, ["x"], STOP, tmp_path)[1] for fmu in (fmu3.path, without))
    assert with_clocks.count("\n") == 1 and "initial unknowns" in with_clocks and none == ""


def test_host_fmutool_finds_nothing(fmu_path, tmp_path):
    """The checks of the FMU Manipulation Toolbox."""
    done = ended(SCRIPTS / "fmutool", "-input", fmu_path, "-check", cwd=tmp_path)
    said = done.stdout + done.stderr
    assert "compliant with FMI-2.0" in said and "No semantic error" in said, said
    assert "ERROR" not in said and "WARNING" not in said, said


def test_host_container_of_fmus(fmu, fmu_path, plain, tmp_path):
    """An FMU around ours, made by the FMU Manipulation Toolbox and run by FMPy; its steps are the container's."""
    if not sys.platform.startswith("linux"):
        pytest.skip("the container's binary is tried on Linux only")
    inputs = [v.name for v in fmu.description.modelVariables if v.causality == "input"]
    done = ended(*container(fmu_path, tmp_path, STEP, inputs, plain.dtype.names[1:]), cwd=tmp_path)
    assert "ERROR" not in done.stdout + done.stderr, done
    same(fmpy.simulate_fmu(str(tmp_path / "outer.fmu"), stop_time=STOP, output_interval=STEP), plain)


#: Hosts that are Python packages: which versions of FMI they run, and whether they read every output as a real number.
PACKAGES = {
    "pathsim": ((2, 3), True),
    "pathsim-exchange": ((2, 3), True),
    "cofmupy": ((2, 3), True),
    "gemseo": ((2,), False),
    "fmuloader": ((2, 3), False),
    "syssimx": ((2,), False),
}


@pytest.fixture(scope="module")
def scalars(fmu_path, producer, tmp_path_factory):
    """FMUs of scalars by the version of FMI and by whether all outputs are real."""
    folder = tmp_path_factory.mktemp("scalars")
    made = {}
    for fmi, real in ((2, False), (2, True), (3, False), (3, True)):
        options = ["--fmi", str(fmi), *(["--scalars", "--clocks", "none"] if fmi == 3 else [])]
        options += ["--real-outputs"] if real else []
        made[fmi, real] = repacked(producer, fmu_path, folder / f"{fmi}{real}.fmu", *options)
    return made


def by_package(host, fmu, names, code=0) -> list:
    """The rows of a run over two seconds in such a host; or what it says, if it is to end with a code."""
    environment = os.environ | {"PYTHONPATH": str(ROOT / "target/hosts/python")}
    request = json.dumps({"path": str(fmu), "step": STEP, "count": 256, "names": names})
    done = subprocess.run(
        [sys.executable, HOSTS, host, request], capture_output=True, text=True, timeout=300, env=environment
    )
    if done.returncode == 77:
        pytest.skip(f"{host} is missing: {done.stderr.strip()}")
    assert done.returncode == code, done.stderr[-3000:]
    return done.stderr if code else json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("host", PACKAGES)
def test_host_python_packages(host, scalars, plain):
    """The doubles of FMPy; in model exchange, by a method of order 5, nearly. Those that read every output as a real
    number stop where one is not."""
    versions, needs_real = PACKAGES[host]
    names = ["x[1]", "x[5]", "v[1]", "E_total", "impulse[4]"]
    of_time = {time: row for time, *row in plain[["time", *names]].tolist()}
    for fmi in versions:
        for real in (True,) if needs_real else (False, True):
            rows = by_package(host, scalars[fmi, real], names)
            assert 256 <= len(rows) <= 257 and rows[-1][0] == 2.0
            if host == "pathsim-exchange":
                expected = [of_time[time] for time, *_ in rows]
                assert np.allclose([row for _, *row in rows], expected, rtol=1e-9, atol=1e-9)
            else:
                assert all(row == of_time[time] for time, *row in rows)
        if needs_real:
            assert f"fmi{fmi}Get" in by_package(host, scalars[fmi, False], names, code=1)
