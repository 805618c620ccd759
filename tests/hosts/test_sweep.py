"""Many runs side by side: cases, results with the cases in front, errors by case."""

import copy
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ended

AXES = {"contact.exponent": [1.0, 1.5, 20.0], "contact.deadBand": [0.0, 2.6e-6]}
SHORT = {"stop": 1.0, "record": ["x", "E_total"]}
PATIENCE = 60.0  # s, after which a process has not begun, or not ended


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """An empty folder for temporary files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def measured(fmu, case):
    """The largest force, or the end of the process."""
    if case["mass"] < 0.0:
        os._exit(1)
    return {"peak": fmu.simulate({"ball.mass": case["mass"]}, stop=1.0, record=[]).pulses["peak"].max()}


def odd(fmu, case):
    """Something that cannot be pickled, nothing, rows of several lengths, results of several lengths, other names."""
    kinds = {
        "lambda": lambda: {"found": lambda: None},
        "nothing": lambda: None,
        "rows": lambda: {"found": np.arange(case["number"])},
        "results": lambda: fmu.simulate(stop=float(case["number"]), record=["x"]),
        "names": lambda: {f"found {case['number']}": case["number"]},
        "truth": lambda: {"found": 1 if case["number"] == 1 else 0.5},
    }
    return kinds[case["kind"]]()


def many_odd(fmu, kind, workers):
    return nc.sweep([{"kind": kind, "number": number} for number in (1, 2)], odd, fmu=fmu, workers=workers)


@pytest.mark.parametrize("workers", [1, 2])
def test_sweep_of_axes_has_its_results_side_by_side(fmu, workers):
    told = []
    found = nc.sweep(AXES, fmu=fmu, workers=workers, progress=told.append, **SHORT)
    assert [tuple(case.values()) for case in found.cases] == [(p, d) for p in (1.0, 1.5, 20.0) for d in (0.0, 2.6e-6)]
    assert found["x"].shape == (6, 101, 5) and found["E_total"].shape == (6, 101) and found.time[-1] == 1.0
    assert list(found) == ["time", *(f"x[{i}]" for i in range(1, 6)), "E_total"] and len(found.seconds) == 6
    assert told == sorted(told) and told[-1] == 1.0
    alone = [fmu.simulate(case, **SHORT) for case in found.cases[:4]]
    assert all(np.array_equal(found["x"][i], one["x"]) for i, one in enumerate(alone))
    assert all(found.pulses[i].tobytes() == one.pulses.tobytes() for i, one in enumerate(alone))
    assert set(found.errors) == {4, 5} and np.isnan(found["x"][4:]).all() and len(found.pulses[5]) == 0
    assert "contact.exponent = 20 is refused; allowed: 1 to 10" in found.errors[4]
    assert repr(found).startswith("Sweep(6 cases, 2 failed; ")
    pytest.importorskip("pandas")
    frame = found.to_dataframe()
    assert list(frame["contact.exponent"]) == [1.0, 1.0, 1.5, 1.5, 20.0, 20.0]
    assert frame["x[5]"][0] == alone[0]["x[5]"][-1] and list(frame["error"] != "") == [False] * 4 + [True] * 2


def test_sweep_takes_dicts_or_rows(fmu, fmu_path):
    rows = [{"ball.mass": 1.0}, {"ball.mass": 2.0, "x_start": [-0.1, 0, 0, 0, 0]}]
    found = nc.sweep(rows, fmu=fmu_path, workers=1, **SHORT)
    assert found["x"][:, 0, 1].tolist() == [-0.1, 0.0] and not found.errors
    assert nc.sweep([], fmu=fmu).results == []
    pandas = pytest.importorskip("pandas")
    again = nc.sweep(pandas.DataFrame({"ball.mass": [1.0, 2.0]}), fmu=fmu, workers=1, **SHORT)
    assert np.array_equal(again["x"][0], found["x"][0])


def test_sweep_loses_only_the_case_of_a_dead_process(fmu):
    found = nc.sweep({"mass": [0.5, -1.0, 1.0, 2.0]}, measured, fmu=fmu, workers=2)
    assert found.errors == {1: "its process has died (exit code 1)"}
    assert np.isnan(found["peak"][1]) and (np.diff(found["peak"][[0, 2, 3]]) > 0).all()
    assert found.results[0] == measured(fmu, {"mass": 0.5})


def test_sweep_repeats_only_the_cases_of_a_dead_process(fmu, tmp_path, temporary):
    """Of 400 in parcels of 25, most run once; nothing stays behind in the folder for temporary files."""
    cases = [{"number": number, "log": str(tmp_path / "log")} for number in range(400)]
    found = nc.sweep(cases, logged, fmu=fmu, workers=2)
    assert found.errors == {30: "its process has died (exit code 1)"}
    assert found["number"].tolist()[:30] == list(range(30)) and np.isnan(found["number"][30])
    runs = (tmp_path / "log").read_text().split()
    assert set(map(int, runs)) == set(range(400)) and len(runs) <= 400 + 25
    assert os.listdir(temporary) == []


def ending(fmu, case):
    """Changes its case, doubts it, and ends as it says."""
    case["number"] += 1
    fmu.start({"x_start[1]": 0.001 * case["number"]}).close()
    if case["number"] == 2:
        sys.exit("two")
    return {"number": case["number"]}


@pytest.mark.parametrize("workers", [1, 2])
def test_sweep_case_is_the_same_in_any_process(fmu, workers):
    """What it changes in its case stays its own, an exit is its error, and doubts come to who has asked for it."""
    with pytest.warns(nc.DoubtfulStart) as told:
        found = nc.sweep({"number": [0, 1, 2]}, ending, fmu=fmu, workers=workers)
    assert [case["number"] for case in found.cases] == [0, 1, 2]
    assert found.errors == {1: "SystemExit: two"} and found["number"][[0, 2]].tolist() == [1, 3]
    assert len({str(warning.message) for warning in told}) == 3
    with pytest.warns(nc.DoubtfulStart) as told:
        nc.sweep({"x_start[1]": [0.001, 0.002]}, fmu=fmu, workers=workers, stop=0.1)
    assert {warning.filename for warning in told} == {__file__}
    with warnings.catch_warnings(action="error"):
        found = nc.sweep({"x_start[1]": [0.001, -0.1]}, fmu=fmu, workers=workers, stop=0.1)
    assert list(found.errors) == [0] and found.errors[0].startswith("DoubtfulStart: ")


@pytest.mark.parametrize("workers", [1, 2])
def test_sweep_tells_of_a_closed_fmu_once(fmu, workers):
    with nc.Fmu(fmu.path) as closed:
        pass
    with pytest.raises(nc.FmuError, match=r"NewtonsCradle.fmu is closed: its `with` block has ended"):
        nc.sweep({"gravity": [1.0, 9.81]}, fmu=closed, workers=workers)


def logged(fmu, case):
    """Says that it runs, and dies in one case."""
    with open(case["log"], "a") as log:
        log.write(f"{case['number']} ")
    if case["number"] == 30:
        os._exit(1)
    return {"number": case["number"]}


def slow(fmu, case):
    """Or a sweep of slow ones."""
    Path(case["folder"], f"began {os.getpid()}").touch()
    if case.get("outer"):
        nc.sweep([{"folder": case["folder"]}] * 2, slow, fmu=fmu, workers=2)
    time.sleep(600.0)


def waited(done) -> bool:
    """Whether this has become true."""
    begin = time.monotonic()
    while not done() and time.monotonic() - begin < PATIENCE:
        time.sleep(0.01)
    return done()


def gone(process: int) -> bool:
    """Whether this process has ended, and is no zombie of a parent that has not looked after it."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def began(folder: Path) -> list[int]:
    """The processes that run slow cases."""
    return [int(path.name.split()[1]) for path in folder.glob("began *")]


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers that send signals")
def test_sweep_ends_at_a_signal_at_any_time(fmu, temporary):
    """While its processes start, work or end; with them and their files. Some ring again while it ends."""
    moments, again = random.Random(7), 0
    handler = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        for _ in range(40):
            with suppress(KeyboardInterrupt):
                try:
                    signal.setitimer(signal.ITIMER_REAL, moments.uniform(1e-4, 0.1), moments.choice([0.0, 1e-3]))
                    nc.sweep({"number": [1, 2, 3]}, numbered, fmu=fmu, workers=2)
                    again += 1
                finally:
                    signal.setitimer(signal.ITIMER_REAL, 0.0)
            assert multiprocessing.active_children() == [] and os.listdir(temporary) == []
            assert signal.getsignal(signal.SIGALRM) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGALRM, handler)
    assert nc.sweep({"number": [1, 2]}, numbered, fmu=fmu, workers=2)["number"].tolist() == [1, 2]


def numbered(fmu, case):
    return case


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are not told")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_sweep_outlives_its_processes(fmu, tmp_path, number, method):
    """However that has ended, and those of a sweep within a case as little."""
    folder, script = tmp_path / "temporary", tmp_path / "script.py"
    folder.mkdir()
    script.write_text(f"""
import multiprocessing, sys
import newtons_cradle as nc
from test_sweep import slow

if __name__ == "__main__":
    multiprocessing.set_start_method("{method}")
    case = {{"folder": sys.argv[2], "outer": True}}
    nc.sweep([case, case], slow, fmu=sys.argv[1], workers=2)
""")
    known = {"PYTHONPATH": os.pathsep.join(sys.path), "TMPDIR": str(folder)}
    command = [sys.executable, script, fmu.path, tmp_path]
    with subprocess.Popen(command, env=os.environ | known, stderr=subprocess.PIPE, text=True) as program:
        assert waited(lambda: len(began(tmp_path)) == 6)
        program.send_signal(number)
        said = program.communicate()[1]
    assert program.returncode == -number and said.count("Traceback") == (number == signal.SIGINT)
    assert waited(lambda: all(map(gone, began(tmp_path))))
    assert [path for path in folder.glob("cradle-*") if number == signal.SIGINT] == []


@pytest.mark.parametrize("workers", [1, 2])
def test_sweep_takes_odd_measures_or_tells(fmu, workers):
    nothing = many_odd(fmu, "nothing", workers)
    assert "measure: a returned result, or a dict of numbers" in nothing.errors[0] and list(nothing) == []
    rows = many_odd(fmu, "rows", workers)
    with pytest.raises(nc.InvalidValue, match=r"found has the shapes \(1,\) in case 0 and \(2,\) in case 1"):
        rows["found"]
    results = many_odd(fmu, "results", workers)
    with pytest.raises(nc.InvalidValue, match=r"x has the shapes \(101, 5\) .*; `results` has each alone"):
        results["x"]
    assert results.results[1]["x"].shape == (201, 5)
    names = many_odd(fmu, "names", workers)
    assert list(names) == ["found 1", "found 2"] and np.isnan(names["found 2"][0]) and names["found 2"][1] == 2
    assert many_odd(fmu, "truth", workers)["found"].tolist() == [1.0, 0.5]
    assert rows == many_odd(fmu, "rows", workers) != results and names != many_odd(fmu, "truth", workers)
    pytest.importorskip("pandas")
    assert rows.to_dataframe()["found"][1].tolist() == [0, 1]
    assert results.to_dataframe()["time"].tolist() == [1.0, 2.0]
    assert names.to_dataframe()["found 1"].isna().tolist() == [False, True]


def test_sweep_tells_what_cannot_be_sent_to_a_process(fmu, tmp_path):
    assert nc.sweep({"a": [1, 2]}, lambda fmu, case: case, fmu=fmu, workers=1)["a"].tolist() == [1, 2]
    with pytest.raises(nc.InvalidValue, match=r"measure: it cannot be sent .*; define it by `def` in a module"):
        nc.sweep({"a": [1, 2]}, lambda fmu, case: case, fmu=fmu, workers=2)
    errors = many_odd(fmu, "lambda", 2).errors
    assert all("what was measured cannot be sent from a worker" in error for error in errors.values())
    found = nc.sweep([{"kind": "names", "number": lambda: 1}, {"kind": "names", "number": 2}], odd, fmu=fmu, workers=2)
    assert set(found.errors) == {0} and "the case cannot be sent to a worker" in found.errors[0]
    code = """
import multiprocessing, sys
import newtons_cradle as nc

multiprocessing.set_start_method("spawn", force=True)
try:
    nc.sweep({"ball.mass": [1.0, 2.0]}, fmu=sys.argv[1], stop=0.1, workers=2)
except nc.FmuError as problem:
    print(problem)
"""
    done = ended(sys.executable, "-c", code, fmu.path)
    assert done.stdout == ""  # a command has no file that other processes would run
    script = tmp_path / "script.py"
    script.write_text(code)
    said = ended(sys.executable, script, fmu.path).stdout.splitlines()
    assert said[-1].endswith("call `nc.sweep` below `if __name__ == '__main__':`, or take `workers=1`")


def test_sweep_axes_with_units_and_lists(fmu):
    """They, and names of values that are also recorded, are told apart."""
    axes = {"contact.deadBand": ([1.0, 2.6], "um"), "gravity": [9.81, 1.62], "contact.model": ("powerLaw", "hertz")}
    found = nc.sweep(axes, fmu=fmu, workers=1, stop=0.5, record=["x", "gravity", "contact.deadBand"])
    assert not found.errors and found.cases[-1]["contact.deadBand"] == (2.6, "um")
    assert found["contact.deadBand"][:, 0].tolist() == [1e-6] * 4 + [2.6e-6] * 4
    placed = [[-0.1, 0, 0, 0, 0], ([-100, -100, 0, 0, 0], "mm")]
    listed = nc.sweep({"x_start": placed}, fmu=fmu, workers=1, stop=0.1, record=["x"])
    assert listed["x"][:, 0, 1].tolist() == [0.0, -0.1] and listed == copy.deepcopy(listed)
    for wrong in (5.0, (2.6, "um"), "hertz", {"a": 1}):
        with pytest.raises(nc.InvalidValue, match="cases: gravity needs a list of values, not "):
            nc.sweep({"gravity": wrong}, fmu=fmu)
    pytest.importorskip("pandas")
    frame = found.to_dataframe()
    assert frame["contact.deadBand"].tolist() == [1.0] * 4 + [2.6] * 4
    assert (
        frame.attrs["units"] == {"contact.deadBand": "um"} and frame["gravity"].tolist() == [9.81, 9.81, 1.62, 1.62] * 2
    )
    assert frame["gravity (result)"].tolist() == frame["gravity"].tolist()
    assert frame["contact.deadBand (result)"][0] == 1e-6
    pytest.importorskip("xarray")
    data = found.to_xarray()
    assert data.x.dims == (*axes, "time", "ball") and data["contact.deadBand"].units == "um"
    assert (data.sel({"gravity": 1.62})["gravity (result)"] == 1.62).all()
    assert nc.sweep({"x_start": placed}, fmu=fmu, stop=0.1, record=["x"]).to_xarray().x.dims == (
        "x_start",
        "time",
        "ball",
    )
    with pytest.raises(nc.InvalidValue, match="cases: time is also a dimension of the results"):
        nc.sweep({"time": [1.0, 2.0]}, lambda fmu, case: fmu.simulate(stop=1.0), fmu=fmu, workers=1).to_xarray()


def test_sweep_copies_of_results_are_whole(fmu):
    result = fmu.simulate(stop=1.0)
    for made in (copy.copy(result), copy.deepcopy(result)):
        assert made == result and made.model is fmu and made.given == result.given and made.units == result.units
    made.units["x[1]"] = made.dims["x"] = "none"
    assert result.units["x[1]"] == "m" and result.dims["x"] == "ball"
    made.samples["x[1]"] = np.nan
    assert made == copy.deepcopy(made)
    odd = [nc.sweep([{}], lambda fmu, case: {"a": np.nan, "b": [np.nan]}, fmu=fmu, workers=1) for _ in range(2)]
    assert odd[0] == odd[1]
    made.pulses["peak"] = 0.0
    assert result["x[1]"][0] == -0.1 and made != result and result.pulses["peak"].min() > 0.0
    if find_spec("pandas"):
        few = fmu.simulate(stop=0.1, record=["x[1]"])
        units = few.to_dataframe().attrs["units"]
        assert set(units) - {"time"} == {"x[1]"} and units is not few.units
    for workers in (1, 2):
        found = nc.sweep([{}, {"gravity": 1.0}], fmu=fmu, stop=1.0, workers=workers)
        assert found.results[0] == result and found.results[0].model is fmu


def test_sweep_as_data_set_has_named_dimensions(fmu, cradle, fmu_path):
    """Of a run and of many; balls and contacts count from 1."""
    pytest.importorskip("xarray")
    result = fmu.simulate(nc.figure5(), stop=1.0)
    data = result.to_xarray()
    assert data.x.dims == ("time", "ball") and data.F.dims == ("time", "contact") and data.E_total.dims == ("time",)
    assert (
        data.x.sel(ball=5)[-1] == result["x[5]"][-1] and data.F_peak.sel(contact=2).max() == result["F_peak[2]"].max()
    )
    assert data.x.units == "m" and data.time.units == "s" and data.inContact.dtype == bool
    some = fmu.simulate(stop=0.1, record=["x[2]", "x[4]", "v"]).to_xarray()
    assert some.x.sel(ball=4)[0] == 0.0 and np.isnan(some.x.sel(ball=1)).all() and some.v.shape == (11, 5)
    many = nc.sweep(AXES, fmu=fmu, workers=1, **SHORT).to_xarray()
    assert many.x.dims[-2:] == ("time", "ball") and set(many.x.dims) == {*AXES, "time", "ball"}
    one = many.x.sel({"contact.exponent": 1.5, "contact.deadBand": 2.6e-6})
    alone = fmu.simulate({"contact.exponent": 1.5, "contact.deadBand": 2.6e-6}, **SHORT)
    assert np.array_equal(one.transpose("time", "ball"), alone["x"])
    listed = nc.sweep([{"ball.mass": 1.0}, {"ball.mass": 2.0}], fmu=fmu, workers=1, **SHORT).to_xarray()
    assert listed.x.dims == ("case", "time", "ball") and listed["ball.mass"].values.tolist() == [1.0, 2.0]
    assert cradle(balls=2, binaries=fmu_path).simulate(stop=0.1).to_xarray().F.dims == ("time", "contact")


def recorded(fmu, case):
    """A run of what the case says."""
    return fmu.simulate(stop=case.get("stop", 0.1), record=case["record"])


def test_sweep_keeps_what_only_some_cases_have(fmu):
    """Other variables, elements or times in each case."""
    pytest.importorskip("xarray")
    some = nc.sweep([{"record": ["x"]}, {"record": ["v", "x"]}, {"record": ["z"]}], recorded, fmu=fmu, workers=1)
    assert list(some.errors) == [2] and "v" in some and "x[2]" in some and "F" not in some and 5 not in some
    elements = nc.sweep([{"record": ["x[2]"]}, {"record": ["x[4]"]}], recorded, fmu=fmu, workers=1)
    for read in (lambda: elements["x"], elements.to_xarray):
        with pytest.raises(nc.InvalidValue, match=r"x has other elements in case 1 than in case 0; `results` has each"):
            read()
    assert elements["x[4]"][1, 0] == 0.0 and np.isnan(elements["x[4]"][0]).all()
    times = nc.sweep([{"record": ["x"], "stop": stop} for stop in (0.1, 0.2)], recorded, fmu=fmu, workers=1)
    for read in (lambda: times.time, times.to_xarray):
        with pytest.raises(nc.InvalidValue, match="the times of case 1 are others than those of case 0"):
            read()
    data = some.to_xarray()
    assert data.v.dims == ("case", "time", "ball") and np.isnan(data.v[0]).all() and (data.v[1] == some["v"][1]).all()
    pair = nc.sweep([{"record": ["x[2]", "v"]}], recorded, fmu=fmu, workers=1).to_xarray()
    assert pair.x.sel(ball=2)[0, 0] == -0.1 and np.isnan(pair.x.sel(ball=1)).all() and pair.v.shape == (1, 11, 5)


def failing(fmu, case):
    raise RuntimeError("boom")


def test_sweep_without_success_says_why(fmu):
    failed = nc.sweep([{}, {}], failing, fmu=fmu, workers=1)
    for read, kind in ((lambda: failed["peak"], nc.UnknownName), (lambda: failed.time, nc.InvalidValue)):
        with pytest.raises(kind, match="no case has succeeded; case 0: RuntimeError: boom"):
            read()


def test_sweep_sets_no_empty_cells_of_a_data_frame(fmu):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame([{"ball.mass": 0.5}, {"gravity": 1.62}])
    found = nc.sweep(frame, fmu=fmu, workers=1, stop=0.1, record=[])
    assert found.cases == [{"ball.mass": 0.5}, {"gravity": 1.62}] and not found.errors
