"""What somebody types who has not read the code: it works, or the error says what to type instead."""

import copy
import pickle
from fractions import Fraction

import newtons_cradle as nc
import numpy as np
import pytest

NAMES = {"nc": nc, "np": np, "Fraction": Fraction, "copy": copy, "pickle": pickle}

#: Each is true.
WORKS = [
    'len(result) == len(list(result)) == len(result.keys()) and "time" in result',
    'list(result)[:2] == ["time", "x[1]"]',
    'result.time is not None and (result.time == result["time"]).all()',
    'dict(result)["x[1]"].shape == (101,)',
    'result.get("x[9]") is None and result.get("x[1]")[0] == -0.1',
    '[name for name, column in result.items() if column.dtype == bool][0] == "inContact[1]"',
    'result["x"][-1].shape == (5,)',
    'result["x[1]"].max() > result["x[1]"].min()',
    '"x" in result and "x[2]" in result and "nothing" not in result',
    'result.pulses["peak"].max() > 0 and len(result.pulses[result.pulses["contact"] == 2]) > 0',
    'result.pulses["release"] - result.pulses["onset"] is not None',
    '"<table>" in result._repr_html_() and "x[1] to [5]" in result._repr_html_()',
    '"<th>onset (s)</th>" in result.pulses._repr_html_()',
    '"contact.stiffness" in fmu.parameters._repr_html_()',
    '"x" in result._ipython_key_completions_() and "x[1]" in result._ipython_key_completions_()',
    'result.plot("x", ax=axes) is axes.figure and len(axes.lines) == 5',
    'len(result.plot("x", "v", ax=pair).axes) == 2',
    'result.plot().axes[0].get_ylabel() == "x"',
    "fmu.simulate(stop=1, step=np.float64(0.1)).time[-1] == 1.0",
    "fmu.simulate(stop=np.array(1.0), step=Fraction(1, 10)).time.shape == (11,)",
    "fmu.simulate(times=np.linspace(0, 1, 11)).time.shape == (11,)",
    "fmu.simulate(times=range(3)).time.tolist() == [0, 1, 2]",
    'fmu.simulate({"ball.mass": np.float32(0.5)}, stop=0.1).given["ball.mass"] == 0.5',
    'fmu.simulate({"ball.mass": np.array(2)}, stop=0.1).given["ball.mass"] == 2.0',
    'fmu.simulate({"x_start": np.array([-0.1, 0, 0, 0, 0])}, stop=0.1)["x"][0].tolist() == [-0.1, 0, 0, 0, 0]',
    'fmu.simulate({"x_start": (-0.1, 0, 0, 0, 0)}, stop=0.1)["x[2]"][0] == 0',
    'fmu.simulate({"x_start": ([-100, 0, 0, 0, 0], "mm")}, stop=0.1)["x[1]"][0] == -0.1',
    'fmu.simulate({"contact.deadBand": (2.6, "um")}, stop=0.1).given["contact.deadBand"] == 2.6e-6',
    'fmu.simulate({"contact.deadBand": (2.6e-6, "m")}, stop=0.1).given["contact.deadBand"] == 2.6e-6',
    'fmu.simulate({"contact.stiffness": (10, "N/um")}, stop=0.1).given["contact.stiffness"] == 1e7',
    'fmu.simulate({"contact.model": "hertz"}, stop=0.1).given["contact.model"] == 2',
    'fmu.simulate({"contact.model": 2}, stop=0.1).given["contact.model"] == 2',
    'fmu.simulate({"contact.model": np.int64(2)}, stop=0.1).given["contact.model"] == 2',
    "len(fmu.simulate(stop=0.1, control=lambda run: None)) > 1",
    "len(fmu.simulate(stop=0.1, inputs=lambda t: None)) > 1",
    'fmu.simulate(stop=0.1, control=lambda run: {"a_support": np.float64(run.time)}).given["a_support"] > 0',
    'fmu.simulate(stop=0.1, control=lambda run: run.set({"a_support": 1})).given["a_support"] == 1',
    'set(fmu.simulate(stop=0.1, record=fmu.variables)) == {"time", *fmu.variables}',
    'list(fmu.simulate(stop=0.1, record=("x", "E_total")))[-1] == "E_total"',
    'list(fmu.simulate(stop=0.1, record={"x[1]"})) == ["time", "x[1]"]',
    "len(list(fresh.until(0.3, 0.1))) == 3 and fresh.time == 0.3",
    "fresh.step(np.float64(0.1)) is None and fresh.time == 0.1",
    'fresh["x"].shape == (5,) and fresh["x[1]"] == -0.1 and fresh["contact.model"] == 1',
    'fresh.set({"F_ext": np.zeros(5)}) is None and fresh["F_ext"].tolist() == [0] * 5',
    '"F_ext" in fresh._ipython_key_completions_()',
    "pickle.loads(pickle.dumps(fmu)).simulate(stop=0.1) == fmu.simulate(stop=0.1)",
    "pickle.loads(pickle.dumps(result)) == result",
    'nc.sweep([{}, {"ball.mass": 2.0}], fmu=fmu, stop=0.1, record=["x"], workers=1)["x"].shape == (2, 11, 5)',
    'nc.lifted(np.int64(2))["x_start[2]"] == -0.1',
    'nc.build(set={"ball.mass": np.float64(0.5)}, binaries=fmu.path).built_with("ball.mass") == 0.5',
    'nc.build(set={"contact.model": 2}, binaries=fmu.path).parameters["contact.model"].default == "hertz"',
    'nc.build(set={"contact.deadBand": (2.6, "um")}, binaries=fmu.path).built_with("contact.deadBand") == 2.6e-6',
    'nc.build(balls=3, set={"x_start": np.array([-0.1, 0, 0])}, binaries=fmu.path).balls == 3',
    'nc.build(balls=3, set={"x_start": ([-20, 0, 0], "mm")}, binaries=fmu.path).built_with("x_start[1]") == -0.02',
    "nc.build(balls=np.int64(3), binaries=fmu.path).balls == 3",
    'fmu.parameters["contact.model"].range.startswith("powerLaw")',
    '"gravity" in fmu.parameters and "a_support" in fmu.inputs',
    'fmu.simulate(record=["time", "x"], stop=0.1)["x"].shape == (11, 5)',
    'result.units["x"] == result.units["x[1]"] == "m"',
    '"x" in fresh and "x[1]" in fresh and "mass" not in fresh',
    'nc.sweep({"ball.mass": np.linspace(1, 2, 3)}, fmu=fmu, stop=0.1, workers=1)["x[1]"].shape == (3, 11)',
    'nc.sweep({"contact.deadBand": ([0, 2.6], "um")}, fmu=fmu, stop=0.1, workers=1).cases[1]["contact.deadBand"][0] == 2.6',
    '"<th>ball.mass</th>" in nc.sweep({"ball.mass": [1.0]}, fmu=fmu, stop=0.1, workers=1)._repr_html_()',
    "copy.copy(result) == result and copy.copy(result).model is fmu",
    "fmu.start().pulses.to_dataframe().shape == (0, 6)",
    'set(dir(nc)) >= {"Fmu", "sweep", "fit", "__version__"} and nc.__version__',
]

#: Each raises an error of this type, whose message says this.
SAYS = [
    ('fmu.simulate({"mass": 1})', nc.UnknownName, "did you mean ball.mass?"),
    ('fmu.simulate({"ball.mass": "1 kg"})', nc.InvalidValue, "or as (1.0, 'kg')"),
    ('fmu.simulate({"ball.mass": (1, "g")})', nc.InvalidValue, "ball.mass = (1, 'g') is refused; allowed: kg"),
    ('fmu.simulate({"contact.exponent": (1.5, "m")})', nc.InvalidValue, "allowed: a number alone"),
    ('fmu.simulate({"contact.model": "herz"})', nc.InvalidValue, "did you mean hertz?"),
    ('fmu.simulate({"ball.mass": -1})', nc.InvalidValue, "allowed: finite and > 0"),
    ('fmu.simulate({"gravity": 10**400})', nc.InvalidValue, "allowed: numbers up to 1.8e308"),
    ('fmu.simulate({"gravity": 10**5000})', nc.InvalidValue, "thousands of digits is refused"),
    ('fmu.simulate({"ball.mass": 1j})', nc.InvalidValue, "ball.mass = 1j is not a number"),
    ('fmu.simulate({"x_start": [[1], [2, 3]]})', nc.InvalidValue, "has 5 elements; allowed: x_start[i], or a list"),
    ('fmu.simulate({"x": [0] * 5})', nc.InvalidValue, "did you mean x_start[i]?"),
    ("fmu.simulate(stop=10**400)", nc.InvalidValue, "allowed: a positive number (s)"),
    ('fmu.simulate(record="x")', nc.InvalidValue, "a list of names such as ['x[1]'] is needed"),
    ("fmu.simulate(control=lambda run: 5)", nc.InvalidValue, "a returned dict of inputs"),
    ('result["energy"]', nc.UnknownName, "recorded: time, x, F, v"),
    ('result.plot("x", "v", ax=axes)', nc.InvalidValue, "ax: 1 axes for 2 signals"),
    ('fresh.gradient("E_total", ["nothing"])', nc.UnknownName, "has no variable 'nothing'"),
    ('fresh.gradient("x", ["gravity"])', nc.InvalidValue, "`derivative` takes several"),
    ('fresh.derivative("x", "gravity", over="all")', nc.InvalidValue, "allowed: 'run', 'step'"),
    ("fresh.until(1.0, 1e-300)", nc.InvalidValue, "up to 1.0 s that makes 1e+300 steps; allowed: 100000000"),
    ("fresh.until(1.0, 0)", nc.InvalidValue, "step = 0 is refused; allowed: a positive number (s)"),
    ('nc.build(set={"mass": 1}, binaries=fmu.path)', nc.UnknownName, "did you mean ball.mass?"),
    ('nc.build(set={"ball.mass": -1}, binaries=fmu.path)', nc.InvalidValue, "ball.mass = -1 kg is refused; allowed"),
    ('nc.build(set={"contact.model": "herz"}, binaries=fmu.path)', nc.InvalidValue, "did you mean hertz?"),
    ('nc.build(set={"x": [0] * 5}, binaries=fmu.path)', nc.InvalidValue, "did you mean x_start[i]?"),
    ('nc.build(preset="desc", binaries=fmu.path)', nc.InvalidValue, "did you mean desk?"),
    ('nc.sweep({"ball.mass": 1.0}, fmu=fmu)', nc.InvalidValue, "cases: ball.mass needs a list of values, not 1.0"),
    (
        'nc.sweep({"ball.mass": [1.0]}, fmu=fmu, record="x")',
        nc.InvalidValue,
        "a list of names such as ['x[1]'] is needed",
    ),
    (
        'nc.sweep({"ball.mass": [1.0]}, fmu=fmu, times=5)',
        nc.InvalidValue,
        "a list of communication points (s) is needed",
    ),
    (
        'nc.sweep({"ball.mass": [1.0]}, fmu=fmu, progress=True)',
        nc.InvalidValue,
        'such as `nc.Progress("Run")` is needed',
    ),
    ('nc.sweep({"ball.mass": [1.0]}, fmu=fmu, client=5)', nc.InvalidValue, "a client of dask is needed, not 5"),
    (
        'nc.sweep({"a": [1]}, lambda fmu, case: case, fmu=fmu, stop=1.0, record=["x"])',
        nc.InvalidValue,
        "stop, record: they act without `measure` only",
    ),
    ('result.pulses["force"]', nc.UnknownName, "allowed: contact, onset, release, peak, impulse, peak_time"),
    ('result.plot("x", ax=5)', nc.InvalidValue, "ax: axes of matplotlib are needed, not 5"),
    ('nc.build(binaries="none.fmu")', nc.FileMissing, "binaries: none.fmu: there is no such file"),
    ('nc.build(out="none/x.fmu", binaries=fmu.path)', nc.FileMissing, "out: there is no folder none"),
    ("fmu.simulate(progress=True)", nc.InvalidValue, 'progress: a function such as `nc.Progress("Run")` is needed'),
    ("nc.sweep([1, 2], fmu=fmu)", nc.InvalidValue, 'for each case a dict such as {"ball.mass": 0.5} is needed'),
    ("nc.simulate", AttributeError, "module 'newtons_cradle' has no attribute 'simulate'"),
]


@pytest.fixture(params=["fmu", "fmu3"])
def names(request):
    """What the lines use: an FMU of either standard, a result of it, a fresh run, axes to draw in."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    fmu = request.getfixturevalue(request.param)
    _, axes = pyplot.subplots()
    _, pair = pyplot.subplots(2)
    with fmu.start() as fresh:
        result = fmu.simulate(stop=1.0)
        yield NAMES | {"fmu": fmu, "fresh": fresh, "result": result, "axes": axes, "pair": pair}
    pyplot.close("all")


@pytest.mark.parametrize("line", WORKS)
def test_natural_lines_work(names, line):
    if "dataframe" in line:
        pytest.importorskip("pandas")
    assert eval(line, names)


@pytest.mark.parametrize(("line", "kind", "complaint"), SAYS, ids=[line for line, *_ in SAYS])
def test_natural_mistakes_are_told_what_to_type(names, line, kind, complaint):
    with pytest.raises(kind) as caught:
        eval(line, names)
    assert complaint in str(caught.value)


def test_natural_mistakes_are_one_error_in_run_and_build(fmu):
    """In words of Python: no option of the command line is named."""
    mistakes = ({"mass": 1}, {"ball.mass": -1}, {"ball.mass": "heavy"}, {"contact.model": "herz"}, {"x": [0] * 5})
    for mistake in mistakes:
        found = []
        for make in (fmu.start, lambda values: nc.build(set=values, binaries=fmu.path)):
            with pytest.raises(nc.CradleError) as caught:
                make(mistake)
            assert "--" not in str(caught.value)
            found.append((type(caught.value), str(caught.value).split(" kg is")[0].replace("NewtonsCradle.fmu", "")))
        assert found[0] == found[1]
    for wrong in ({"balls": 7, "preset": "desk"}, {"out": "/nowhere/x.fmu"}):
        with pytest.raises(nc.CradleError) as caught:
            nc.build(**wrong, binaries=fmu.path)
        assert "--" not in str(caught.value)
