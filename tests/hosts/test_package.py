"""The Python package as its users meet it: presets, wrong input, results, one's own controller, types."""

import re
import sys
import tempfile
from pathlib import Path
from textwrap import dedent

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT, ended
from newtons_cradle.errors import optional


def film(amplitudes=(0.006, 0.003), **wrong) -> nc.Calibration:
    """A calibration by an impossible film."""
    right = {"lift": 0.03, "height": 0.0026, "interval": 15.0, "length": 0.14, "mass": 0.044}
    return nc.calibrate(amplitudes=amplitudes, **right | wrong)


@pytest.mark.parametrize(
    ("call", "complaint"),
    [
        (lambda fmu: fmu.simulate(step=0), "step = 0 is refused; allowed: a positive number (s)"),
        (lambda fmu: fmu.simulate(stop="soon"), "stop = 'soon' is refused"),
        (lambda fmu: fmu.simulate(step=1e-300), "1e-300 is refused: up to 10.0 s that makes 1e+301 steps"),
        (lambda fmu: fmu.simulate(times=[0.0, 2.0, 1.0]), "is needed that begins at 0 and rises"),
        (lambda fmu: fmu.simulate(nc.preset("figure3")), "`nc.build(balls=13)` makes one of 13"),
        (lambda fmu: fmu.simulate({"x_start[7]": 0.1}), "x_start[7] is refused: x_start[1] to x_start[5]"),
        (lambda fmu: fmu.simulate({"x": 0.1}), "x is refused: it is an output, which the FMU computes"),
        (lambda fmu: fmu.simulate({"x[2]": 0.1}), "; did you mean x_start[2]?"),
        (lambda fmu: fmu.simulate({"x_start": [0.1, 0.2]}), "x_start takes 5 values"),
        (lambda fmu: fmu.simulate({"x_start": 0.1}), "has 5 elements; allowed: x_start[i], or a list"),
        (lambda fmu: fmu.simulate({"contact.stifness": 1e9}), "did you mean contact.stiffness"),
        (lambda fmu: fmu.simulate({"drag": 1e-3}), "did you mean pendulum.drag?"),
        (lambda fmu: fmu.simulate({"ball.mass": "1kg"}), "give it in kg, as one number"),
        (lambda fmu: fmu.simulate({"contact.deadBand": (2.6, "inch")}), "(2.6, 'inch') is refused; allowed: m, mm, um"),
        (lambda fmu: fmu.simulate({"ball.mass": -1}), "ball.mass = -1 kg is refused; allowed: finite and > 0"),
        (lambda fmu: fmu.simulate({"contact.model": "herz"}), "hertz, rigid; did you mean hertz?"),
        (lambda fmu: fmu.simulate([0.1]), "values: a dict"),
        (lambda fmu: fmu.simulate(record="x"), "record: a list of names such as ['x[1]'] is needed, not 'x'"),
        (lambda fmu: fmu.simulate(record=["F[5]"]), "F[1] to F[4]"),
        (lambda fmu: fmu.simulate(stop=0.1)["E_totl"], "E_totl was not recorded; did you mean E_total"),
        (lambda fmu: fmu.start({"contact.model": 1.7}), "model = 1.7 is refused; allowed: whole numbers"),
        (lambda fmu: fmu.start({}).get("x"), "x is an array: a single variable is x[i], i from 1 to 5"),
        (lambda fmu: nc.preset("desc"), "did you mean desk?"),
        (lambda fmu: nc.lifted(4, 2), "right = 2 is refused; allowed: a whole number from 0 to 1"),
        (lambda fmu: nc.Fmu("missing.fmu"), "missing.fmu: there is no such file"),
        (lambda fmu: nc.Fmu(ROOT / "README.md"), "README.md is not an FMU"),
        (lambda fmu: fmu.simulate(times=5), "a list of communication points (s) is needed"),
        (lambda fmu: fmu.simulate(inputs={"a_support": 1.0}), "inputs: a function `inputs(t)` that returns a dict is needed"),
        (lambda fmu: fmu.simulate(inputs=lambda t: 0.2), "inputs(t): a returned dict of inputs"),
        (lambda fmu: fmu.simulate(control=lambda run: [0.2]), "control(run): a returned dict of inputs"),
        (lambda fmu: fmu.simulate(record=[["x"]]), "record: a name such as 'x[1]' is needed, not ['x']"),
        (lambda fmu: fmu.simulate(stop=0.1)[0], "name: a variable's, such as 'x[1]', is needed, not 0"),
        (lambda fmu: fmu.simulate(stop=0.1).plot(["x", "v"]), "is needed, not ['x', 'v']"),
        (lambda fmu: fmu.simulate(stop=0.1, record=[]).plot(), "x was not recorded"),
        (lambda fmu: fmu.simulate(stop=0.1).plot(origin="a"), "origin = 'a' is refused"),
        (lambda fmu: fmu.simulate(stop=0.1, record=["x"]).to_parquet("none/x"), "there is no folder none"),
        (lambda fmu: nc.overlaps(fmu.simulate(stop=1.0)), "contact 2 has 0 in its pulse at 0.702493101 s"),
        (lambda fmu: nc.resolved(fmu, stop=1.0, per_pulse=0), "per_pulse = 0 is refused"),
        (lambda fmu: fmu.parameters["mass"], "'mass' is no name in this table; did you mean ball.mass?"),
        (lambda fmu: fmu.variable(5), "name: a variable's, such as 'x[1]', is needed, not 5"),
        (lambda fmu: fmu.start(initialize=False).step(0.1), "call `initialize` first"),
        (lambda fmu: fmu.start().step_to_onset(-1), "before = -1 is refused; allowed: a finite number (s), at least 0"),
        (lambda fmu: fmu.start().zoom(1e-6, 1e-3, ["F"]), "allowed: a positive number (s), at most 1e-06"),
        (lambda fmu: nc.Fmu(fmu.path, ROOT / "README.md"), "cannot be unpacked: "),
        (lambda fmu: nc.power_law(1e9, 11), "p = 11 is refused; allowed: a finite number, at least 1, at most 10"),
        (lambda fmu: nc.figure5(dead_band=-1), "dead_band = -1 is refused"),
        (lambda fmu: nc.lifted(1, amplitude=-1), "amplitude = -1 is refused"),
        (lambda fmu: fmu.start({5: 1.0}), "the name of a variable is needed, not 5"),
        (lambda fmu: fmu.start({"ball.mass": None}), "ball.mass = None is not a number"),
        (lambda fmu: fmu.start({"contact.model": 9}), "contact.model = 9 is refused; allowed: powerLaw (1)"),
        (lambda fmu: fmu.start().set({"ball.mass": 2.0}), "ball.mass cannot be set after initialization"),
        (lambda fmu: fmu.start().initialize(), "not allowed in step mode; allowed: "),
        (lambda fmu: fmu.start().step(-1.0), "h = -1.0 is refused; allowed: a positive number (s)"),
        (lambda fmu: fmu.start().step_to(0.0), "t = 0.0 s is refused; allowed: later than now, 0.0 s"),
        (lambda fmu: fmu.start().load(b"state"), "saved: what `save` returned is needed"),
        (lambda fmu: fmu.start().load(nc.Saved(0.0, b"state")), "the state is refused"),
        (lambda fmu: fmu.items("ball.mass"), "ball.mass is no enumeration"),
        (lambda fmu: nc.lifted(1.5), "left = 1.5 is refused; allowed: a whole number from 0 to 5"),
        (lambda fmu: nc.power_law(0), "k = 0 is refused; allowed: a positive number (N/m^p)"),
        (lambda fmu: nc.Fmu(5), "the path of an .fmu file is needed, not 5"),
        (lambda fmu: nc.energy_error(fmu.simulate(stop=0.1, record=["x"])), "E_residual was not recorded"),
        (lambda fmu: nc.impact_sequences([]), "a table such as `result.pulses` is needed"),
        (lambda fmu: fmu.require(balls=13), "has 5 balls where 13 are needed"),
        (lambda fmu: fmu.require(starts={"contact.model": "hertz"}), "= powerLaw where hertz is needed"),
        (lambda fmu: nc.build(set={"ball.mass": (5, "g")}, binaries=fmu.path), "(5, 'g') is refused; allowed: kg"),
        (lambda fmu: nc.build(balls=0, binaries=fmu.path), "balls = 0 is refused; allowed: a whole number from 1 to"),
        (lambda fmu: nc.build(balls="7", binaries=fmu.path), "balls = '7' is refused; allowed: a whole number from 1"),
        (lambda fmu: nc.build(balls=7, preset="desk", binaries=fmu.path), "preset desk is of 5 balls, not 7; leave"),
        (lambda fmu: nc.build(preset=nc.preset("desk"), binaries=fmu.path), "preset: a name such as 'desk' is needed"),
        (lambda fmu: nc.build(fmi=4, binaries=fmu.path), "fmi = 4 is refused; allowed: a whole number from 2 to 3"),
        (lambda fmu: film(height=0.004), "height = 0.004 is refused; allowed here: "),
        (lambda fmu: film(amplitudes=(0.003, 0.006)), "the second, 15.0 s later, must not be larger"),
        (lambda fmu: film(lift=-0.03), "lift = -0.03 is refused; allowed: a positive number"),
        (lambda fmu: film(amplitudes=0.003), "amplitudes = 0.003 is refused; allowed: two of them (m)"),
        (lambda fmu: film(lift=0.2), "allowed: less than the length, 0.14 m"),
        (lambda fmu: film(interval=0.0), "interval = 0.0 is refused"),
        (lambda fmu: film(balls=1), "balls = 1 is refused; allowed: a whole number from 2 to 10000"),
    ],
)  # fmt: skip
def test_package_refuses_wrong_input_in_words(either, call, complaint):
    """Each message names what was wrong and what is allowed; all are errors of one family, and of Python's kinds."""
    with pytest.raises(nc.CradleError) as caught:
        call(either)
    assert isinstance(caught.value, (KeyError, ValueError, RuntimeError, FileNotFoundError))
    assert complaint in str(caught.value)
    assert "failed with status" not in str(caught.value)


def test_package_prints_short_texts(fmu):
    result = fmu.simulate(stop=10.0)
    with fmu.start() as run:
        assert repr(run) == f"Run({fmu.path.name}, at 0 s; 0 pulses)"
    assert repr(fmu).startswith(f"Fmu({fmu.path.name}: 5 balls, FMI 2.0, ")
    assert re.fullmatch(r"Result\(1001 samples from 0 s to 10 s of x, F, .*; 42 pulses\)", repr(result))
    lines = str(result.pulses).splitlines()
    assert len(lines) == 12 and lines[-1] == "... 42 pulses in all"
    assert type(result.pulses["peak"].max()) is np.float64
    assert repr(result.pulses[:2] == result.pulses[:2]) == "array([ True,  True])"
    assert repr(result.pulses[:2] != result.pulses[:2]) == "array([False, False])"
    assert result.pulses[:2].reshape(2, 1).shape == (2, 1) and repr(result.pulses.reshape(2, -1))
    with fmu.start() as run:
        assert repr(run.save()) == "Saved(time=0.0)"
    assert result.pulses[0]["contact"] == 2 and float(lines[1].split()[1]) == pytest.approx(0.7024931006576)


def test_package_variables_are_tables(fmu):
    """Names as they come, and what is known of each; arrays in a line."""
    assert fmu.parameters["contact.exponent"].range == ">= 1, <= 10"
    assert fmu.parameters["contact.model"].range == "powerLaw, hertz, rigid"
    assert fmu.parameters["contact.model"].default == "powerLaw"
    assert list(fmu.inputs) == [*(f"F_ext[{i}]" for i in range(1, 6)), "a_support"]
    shown = str(fmu.outputs)
    assert re.search(r"^F\[1\] to \[4\] +N .* between balls i and i\+1 ", shown, re.MULTILINE), shown


def test_package_sets_arrays_by_lists(fmu):
    with fmu.start({"x_start": [-0.03, 0.0, 0.0, 0.0, 0.01]}) as run:
        assert run["x"] == pytest.approx([-0.03, 0.0, 0.0, 0.0, 0.01])


def test_package_builds_other_cradles(fmu, tmp_path):
    lift, hertz = [-0.1] + 12 * [0.0], {"contact.model": "hertz"}
    with (
        nc.build(balls=np.int64(13), set={"x_start": lift} | hertz, binaries=fmu.path) as other,
        other.start() as run,
    ):
        assert other.balls == 13 and run["x"].tolist() == lift and run["contact.model"] == 2
    with nc.build(preset="desk", fmi=3, out=tmp_path / "desk.fmu", binaries=fmu.path) as desk:
        assert desk.path == tmp_path / "desk.fmu" and desk.description.fmiVersion == "3.0"
        assert desk.parameters["ball.radius"].default == repr(nc.preset("desk")["ball.radius"])


@pytest.mark.parametrize("mass", [(5, "g"), -1.0])
def test_package_leaves_no_folder_of_a_refused_cradle(fmu, tmp_path, monkeypatch, mass):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises((nc.InvalidValue, nc.FmuError), match="is refused; allowed"):
        nc.build(set={"ball.mass": mass}, binaries=fmu.path)
    assert list(tmp_path.iterdir()) == []


def test_results_are_equal_if_their_contents_are(fmu):
    result, again, other = (fmu.simulate(stop=1.0, step=step) for step in (0.01, 0.01, 0.02))
    assert result == again and result != other and result != fmu.simulate(stop=1.0, record=["x"])
    assert "x" in result and "x[2]" in result and "a_support" not in result


def test_assertions_on_energy_of_cradles_at_rest(fmu):
    hanging = nc.lifted(0)
    assert nc.energy_error(fmu.simulate(hanging, stop=0.1)) == 0.0
    driven = fmu.simulate(hanging, stop=2.0, inputs=lambda t: {"F_ext[1]": -0.5})
    assert driven["E_total"].max() > 0.01 and nc.energy_error(driven) < 1e-12


@pytest.mark.all
def test_assertions_and_fixtures_for_tests_of_others(tmp_path):
    (tmp_path / "test_mine.py").write_text("""
import newtons_cradle as nc
import pytest
from newtons_cradle.testing import assert_energy_kept, assert_pulse_order

def test_three_balls(cradle):
    assert cradle(balls=3).balls == 3 and cradle(balls=3) is cradle(balls=3)

def test_right_and_wrong(cradle):
    result = cradle().simulate(nc.figure5(), stop=2.0)
    assert_energy_kept(result)
    assert_pulse_order(result.pulses, [[2], [1, 3], [2, 4], [3]])
    with pytest.raises(AssertionError, match="expected: \\[\\[1\\]\\]"):
        assert_pulse_order(result.pulses, [[1]])
    damped = cradle().simulate({"contact.damping": 1e4}, stop=2.0)
    damped.samples["E_residual"] += 1.0
    with pytest.raises(AssertionError, match="the energy is off by"):
        assert_energy_kept(damped)
""")
    source = Path(nc.__file__).with_name("testing.py").read_text(encoding="utf-8")
    doc = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    shown = [
        dedent(re.search(r"\n\n(    def test_.+?)\"\"\"", source, re.DOTALL)[1]),
        re.search(r"from newtons_cradle.testing.+?(?=```)", doc, re.DOTALL)[0],
        "def test_shown(cradle): " + re.search(r"`(cradle\(.+?\))`", source)[1],
    ]
    for i, code in enumerate(shown):
        mine = "from newtons_cradle.testing import *\ndef my_controller(run):\n    return {}\n"
        (tmp_path / f"test_shown_{i}.py").write_text(mine + code)
    ended(sys.executable, "-m", "pytest", "-q", "-p", "newtons_cradle.testing", tmp_path)


def test_package_says_what_is_closed(fmu_path):
    """Calls of a freed instance would end the process."""
    with nc.Fmu(fmu_path) as fmu, fmu.start() as run:
        pass
    with pytest.raises(nc.FmuError, match="the run is closed"):
        run.get("x[1]")
    with pytest.raises(nc.FmuError, match="is closed"):
        fmu.start()
    assert repr(fmu) == f"Fmu({fmu_path.name}, closed)"


def test_package_names_both_guids_where_they_differ(fmu):
    other = "{00000000-0000-0000-0000-000000000000}"
    with nc.Fmu(fmu.path) as copy:
        own, copy.described.token = copy.described.token, other
        with pytest.raises(nc.FmuError) as caught:
            copy.start()
    assert other in str(caught.value) and own in str(caught.value)


def test_package_finds_binaries_in_folders_of_fmi_2_0_4(fmu_path, tmp_path):
    """As Linux on ARM needs it: FMPy knows the older names only. The FMU is unpacked where told, and removed."""
    folder = tmp_path / "unpacked"
    with nc.Fmu(fmu_path, folder) as fmu:
        old, new = (folder / "binaries" / name for name in (fmpy.platform, fmpy.platform_tuple))
        old.rename(new)
        with fmu.start() as run:
            assert run["x[1]"] == -0.1
        new.rename(old)
    assert not folder.exists()


@pytest.mark.all
def test_results_as_data_frame_and_parquet(fmu, tmp_path):
    import pandas

    result = fmu.simulate(nc.figure5(), stop=1.0)
    table = fmu.outputs.to_dataframe()
    assert list(table.index) == list(fmu.outputs) and table.unit["v[2]"] == "m/s"
    result.to_parquet(tmp_path / "run.parquet")
    frame = pandas.read_parquet(tmp_path / "run.parquet")
    assert frame.index.name == "time" and frame.index[-1] == 1.0
    assert frame.attrs["units"]["x[1]"] == "m" and frame.attrs["units"]["E_total"] == "J"
    for name in list(result)[1:]:
        assert np.array_equal(frame[name], result[name])


def test_results_as_picture(fmu, tmp_path):
    result = fmu.simulate(nc.figure5(), stop=1.0)
    figure = result.plot("x", "F_peak", "E_total", origin=0.7)
    assert [axis.get_ylabel() for axis in figure.axes] == ["x", "F_peak", "E_total, J"]
    assert [len(axis.lines) for axis in figure.axes] == [5, 4, 1]
    assert np.array_equal(figure.axes[0].lines[2].get_ydata(), result["x[3]"])
    figure.savefig(tmp_path / "run.png")
    assert len(result.plot().axes) == 1
    counts, closed = result.plot("pulses", "inContact").axes
    assert counts.yaxis.get_major_formatter()(0.04) == "" and list(closed.get_yticks()) == [0, 1]
    with fmu.start(nc.figure5()) as run:
        onset, micro = run.zoom(span=1.1e-6, step=1e-9, record=["F"])
    (axis,) = micro.plot("F").axes
    assert axis.get_xlabel() == f"time after {onset:.12g} s" and axis.get_xlim()[1] < 2e-6


def test_package_names_missing_packages_with_their_extra(fmu, monkeypatch, tmp_path):
    result = fmu.simulate(stop=0.1)
    for package in ("pandas", "matplotlib"):
        monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=r"pandas is needed but missing: `pip install 'newtons-cradle\[data\]'`"):
        result.to_parquet(tmp_path / "run.parquet")
    with pytest.raises(ImportError, match=r"newtons-cradle\[plot\]"):
        result.plot()
    for package in ("scipy", "scipy.optimize"):
        monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=r"scipy is needed but missing: `.*\[fit\]'`, or `pip install scipy`"):
        optional("scipy.optimize", "fit")
    assert optional("json", "data") and optional("xml.etree", "data")


def filmed(fmu, values) -> dict:
    """What a film of this run would show: the rise after the first click, two late amplitudes and the time between."""
    run = fmu.simulate(values | {"pendulum.model": "circular"}, stop=52.0, step=0.002, record=["x", "y"])
    time, x = run["time"], run["x"]
    period = 2.0 * np.pi * np.sqrt(values["pendulum.length"] / 9.81)
    swings = (np.flatnonzero((time > begin) & (time < begin + period)) for begin in (40.0, 50.0))
    peaks = [swing[np.argmax(x[swing].mean(axis=1))] for swing in swings]
    return {
        "height": run["y"][time < period, -1].max(),
        "amplitudes": tuple(x[peaks].mean(axis=1)),
        "interval": np.ptp(time[peaks]),
    }


@pytest.mark.parametrize("lift", [0.03, 0.1])
@pytest.mark.parametrize("restitution", [0.85, 0.97])
def test_calibration_finds_restitution_and_drag(fmu, restitution, lift):
    """Of contacts with a dashpot, which lose the same share at any speed, one after the other."""
    desk = nc.preset("desk") | nc.power_law(1e9) | {"contact.gap": [2e-5] * 4, "pendulum.drag": 0.003}
    # e = exp(-pi zeta / sqrt(1 - zeta^2)), c = 2 zeta sqrt(k m / 2)
    decay = -np.log(restitution) / np.pi
    zeta = decay / np.sqrt(1.0 + decay**2)
    desk |= {"contact.dampingLaw": "kelvinVoigt", "x_start[1]": -lift}
    desk["contact.damping"] = 2.0 * zeta * np.sqrt(1e9 * 0.04377 / 2.0)
    show = filmed(fmu, desk)
    found = nc.calibrate(lift=lift, length=0.14, mass=0.04377, **show)
    assert found.restitution == pytest.approx(restitution, abs=2e-4)
    assert found.drag == pytest.approx(0.003, rel=1e-3)
    rigid = filmed(fmu, nc.preset("desk") | {"x_start[1]": -lift} | found.rigid())
    assert [rigid["height"], *rigid["amplitudes"]] == pytest.approx([show["height"], *show["amplitudes"]], rel=1e-2)
    first = fmu.simulate(desk | {"pendulum.model": "circular"}, stop=0.25, step=1e-4, record=["v[1]"])
    assert found.speed == pytest.approx(first["v[1]"].max(), rel=1e-4)


@pytest.mark.parametrize("gap", [0.0, 1e-4])
def test_calibration_finds_the_damping_of_hertz_contacts(fmu, gap):
    """Touching, when pulses overlap, and apart, when they do not."""
    desk = nc.preset("desk") | {"contact.gap": [gap] * 4, "contact.huntCrossley": 0.2, "pendulum.drag": 0.003}
    found = nc.calibrate(lift=0.03, length=0.14, mass=0.04377, **filmed(fmu, desk))
    unknown = desk | {"contact.huntCrossley": 0.0, "pendulum.drag": 0.0}
    values = found.compliant(fmu, unknown)
    assert values["contact.huntCrossley"] == pytest.approx(0.2, rel=2e-3)
    assert values["pendulum.drag"] == pytest.approx(0.003, rel=1e-3)


def test_calibration_follows_another_restitution(fmu):
    """The damping about in proportion to what is lost."""
    desk = nc.preset("desk") | {"contact.gap": [1e-4] * 4}
    found = [nc.Calibration(e, 0.001, 0.25) for e in (0.9, 0.95)]
    assert [one.rigid()["contact.restitution"] for one in found] == [0.9, 0.95]
    for law in (nc.Calibration.pairs, nc.Calibration.compliant):
        lossy, less = (law(one, fmu, desk)["contact.huntCrossley"] for one in found)
        assert 1.9 < lossy / less < 2.3
    exact = [one.pairs(fmu, desk, "constantRestitution")["contact.restitution"] for one in found]
    assert exact == [0.9, 0.95]
    with pytest.raises(nc.InvalidValue, match="restitution = 1 is refused: the last ball would rise by"):
        nc.Calibration(1.0, 0.0, 0.5).compliant(fmu, desk)


def test_package_event_mode_needs_fmi_3(fmu, fmu3):
    with pytest.raises(nc.FmuError, match="eventModeUsed is refused: only FMUs of FMI"):
        fmu.start(eventModeUsed=True)
    with fmu3.start(eventModeUsed=True) as run:
        run.slave.enterStepMode()


def test_package_step_that_returns_early_ends_there(fmu3):
    with fmu3.start(eventModeUsed=True, earlyReturnAllowed=True) as run:
        run.slave.enterStepMode()
        onset = run.get("t_next")
        run.step_to(1.0)
        assert run.time == onset < 1.0
        run.slave.enterEventMode()
        run.slave.enterStepMode()
        run.step(1e-6)
        assert run.time == onset + 1e-6


@pytest.mark.all
def test_package_types():
    """mypy --strict finds nothing in the package."""
    ended(sys.executable, "-m", "mypy", cwd=ROOT)
