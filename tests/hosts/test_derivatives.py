"""Derivatives of a run in Python: those that the FMU gives, which small differences of runs confirm."""

from importlib.util import find_spec

import newtons_cradle as nc
import numpy as np
import pytest

SOFT = {"contact.stiffness": 1e6, "contact.damping": 50.0, "pendulum.drag": 0.01}
TIMES = (0.5, 1.1, 1.7)


def moved(fmu, values, inputs=0.0):
    """A run of soft balls, with a constant force on the first."""
    run = fmu.start(SOFT | {"F_ext[1]": inputs, "derivatives.of": "run"} | values)
    for time in TIMES:
        run.step_to(time)
    return run


def difference(fmu, of, name, value, size):
    """How much a variable changes with a parameter, by two runs."""
    ends = []
    for sign in (1.0, -1.0):
        with moved(fmu, {name: value + sign * size}) as run:
            ends.append(run[of])
    return (ends[0] - ends[1]) / (2.0 * size)


def test_derivatives_of_the_run(fmu3):
    """Forwards, and backwards where there are more knowns than unknowns."""
    sizes = {"contact.stiffness": 10.0, "ball.mass": 1e-6, "x_start[1]": 1e-6, "pendulum.drag": 1e-6, "F_ext[1]": 1e-8}
    values = SOFT | {"ball.mass": 1.0, "x_start[1]": -0.1, "F_ext[1]": 0.0}
    with moved(fmu3, {}) as run:
        matrix = run.derivative(["x", "E_total"], list(sizes))
        gradient = run.gradient("E_total", list(sizes))
        assert matrix.shape == (6, 5)
        assert list(matrix[-1]) == pytest.approx(list(gradient.values()), rel=1e-10)
        assert run.derivative("x[2]", "ball.mass").shape == () and run.derivative("x", "x_start").shape == (5, 5)
        assert run.derivative("x", "x_start")[:, 0] == pytest.approx(matrix[:5, 2], rel=1e-10)
        whole = run.gradient("E_total", ["x_start", "ball.mass"])
        assert whole["x_start"].shape == (5,) and whole["x_start"][0] == pytest.approx(
            gradient["x_start[1]"], rel=1e-10
        )
        assert isinstance(whole["ball.mass"], float)
    for column, (name, size) in zip(matrix.T, sizes.items(), strict=True):
        by_runs = difference(fmu3, "x", name, values[name], size)
        assert column[:5] == pytest.approx(by_runs, abs=2e-6 * np.abs(by_runs).max()), name
        assert column[5] == pytest.approx(difference(fmu3, "E_total", name, values[name], size), rel=1e-4), name


def test_derivatives_of_the_last_step(fmu, fmu3):
    """By its inputs, in both versions the same."""
    found = []
    for each in (fmu, fmu3):
        selected = {} if each.fmi2 else {"derivatives.of": "lastStep"}
        with each.start(SOFT | selected) as run:
            for time in TIMES:
                run.step_to(time - 0.01)
                run.step_to(time)
            found.append(run.derivative(["x", "v", "F_support_mean"], ["F_ext", "a_support"], over="step"))
            assert run.gradient("v[1]", ["F_ext[1]"], over="step")["F_ext[1]"] == found[-1][5, 0]
    assert found[0].shape == (11, 6)
    assert found[0] == pytest.approx(found[1], rel=1e-13)
    assert np.diag(found[0][5:10, :5]) == pytest.approx(0.01 * np.ones(5), rel=1e-3)  # a force on 1 kg for 0.01 s


def test_derivatives_that_do_not_exist_are_refused_in_words(fmu, fmu3):
    with fmu.start() as run:
        run.step(0.1)
        with pytest.raises(nc.FmuError, match=r"over the run need FMI 3.0; `nc.build\(fmi=3\)` makes an FMU"):
            run.derivative("x", "ball.mass")
        with pytest.raises(nc.FmuError, match=r"ball\.mass"):
            run.derivative("x", "ball.mass", over="step")
    with fmu3.start() as run:
        run.step(0.1)
        run["F_ext[1]"] = 1.0
        run.step(0.1)
        with pytest.raises(nc.FmuError, match="must be set before an input or a tunable parameter changes"):
            run.gradient("E_total", ["ball.mass"])
        with pytest.raises(nc.InvalidValue, match="by: at least one name is needed"):
            run.derivative("x", [])


def test_fit_says_what_it_needs(fmu, fmu3):
    pytest.importorskip("scipy")
    track = {"time": [0.5, 1.0], "x": np.zeros((2, 5))}
    for call, complaint in (
        (lambda: nc.fit(track, by=["ball.mass"], fmu=fmu), "is of FMI 2.0; a fit needs FMI 3.0"),
        (lambda: nc.fit(5, by=["ball.mass"], fmu=fmu3), 'track: a dict such as {"time": \\[...\\]'),
        (lambda: nc.fit({"time": [1.0]}, by=["ball.mass"], fmu=fmu3), "track needs `time` and something else"),
        (lambda: nc.fit(track, by=["contact.damping"], fmu=fmu3), "with a guess that is not 0"),
        (lambda: nc.fit(track, by=[], fmu=fmu3), "by: at least one parameter is needed"),
        (lambda: nc.fit(track, by=["ball.mass"], fmu="cradle.fmu"), r"an FMU as `nc.build\(fmi=3\)` makes it"),
        (
            lambda: nc.fit(track | {"time": [1.0, 0.5]}, by=["ball.mass"], fmu=fmu3),
            r"its times \(s\) must rise, from 0",
        ),
        (
            lambda: nc.fit(track | {"time": [0.5, 0.5]}, by=["ball.mass"], fmu=fmu3),
            r"its times \(s\) must rise, from 0",
        ),
        (
            lambda: nc.fit(track | {"time": [-0.5, 0.5]}, by=["ball.mass"], fmu=fmu3),
            r"its times \(s\) must rise, from 0",
        ),
        (lambda: nc.fit(track | {"time": []}, by=["ball.mass"], fmu=fmu3), r"its times \(s\) must rise, from 0"),
        (lambda: nc.fit(track | {"time": 1.0}, by=["ball.mass"], fmu=fmu3), r"its times \(s\) must rise, from 0"),
        (lambda: nc.fit(track | {"time": [0.5, np.nan]}, by=["ball.mass"], fmu=fmu3), "time is not finite in row 1"),
        (
            lambda: nc.fit(track | {"x[1]": [np.nan, 1.0]}, by=["ball.mass"], fmu=fmu3),
            "1. is not finite in row 0; leave",
        ),
        (
            lambda: nc.fit(track | {"x[1]": [1.0]}, by=["ball.mass"], fmu=fmu3),
            r"x.1. has the shape \(1,\); needed: \(2,\)",
        ),
        (lambda: nc.fit(track | {"x": np.zeros((2, 3))}, by=["ball.mass"], fmu=fmu3), r"\(2, 3\); needed: \(2, 5\)"),
        (lambda: nc.fit(track | {"x": "here"}, by=["ball.mass"], fmu=fmu3), "x needs a list of numbers, not 'here'"),
        (lambda: nc.fit(track | {"y[9]": [0, 1]}, by=["ball.mass"], fmu=fmu3), r"y\[1\] to y\[5\] are in"),
        (
            lambda: nc.fit(track | {"pulses": 0}, by=["ball.mass"], fmu=fmu3),
            "track: pulses is no real number; record what",
        ),
        (lambda: nc.fit(track, by={"contact.model": "hertz"}, fmu=fmu3), "by: contact.model is no real number"),
        (lambda: nc.fit(track, by=5, fmu=fmu3), "by: names of parameters, such as .* is needed, not 5"),
        (lambda: nc.fit(track, by=[5], fmu=fmu3), "by: the name of a variable is needed, not 5"),
        (lambda: nc.fit(track, by=["ball.mass", "ball.mass"], fmu=fmu3), "by: ball.mass is named twice"),
        (lambda: nc.fit(track, by=["mass"], fmu=fmu3), "did you mean ball.mass"),
    ):
        with pytest.raises(nc.CradleError, match=complaint):
            call()


def test_fit_finds_what_results_were_made_with(fmu3):
    pytest.importorskip("scipy")
    film = fmu3.simulate(SOFT, stop=3.0, step=0.05, record=["x"])
    guess = {"contact.stiffness": 1.4e6, "contact.damping": 20.0}
    track = {name: column[1:] for name, column in film.items()}
    for other in (film, film.to_dataframe()) if find_spec("pandas") else (film,):
        whole = nc.fit(other, by=guess, fmu=fmu3, values=SOFT)
        assert whole.values == pytest.approx({name: SOFT[name] for name in guess}, rel=1e-5)
    found = nc.fit(track, by=guess, fmu=fmu3, values=SOFT)
    for name in guess:
        assert found.values[name] == pytest.approx(SOFT[name], rel=1e-5)
        assert found.course[0][name] == guess[name]
    assert found.rms < 1e-8 and found.runs < 15
    again = nc.fit(track, by=list(guess), fmu=fmu3, values=SOFT)
    assert again.values == pytest.approx({name: SOFT[name] for name in guess}, rel=1e-6) and len(again.course) <= 2
