"""FMI 3.0 through FMPy: description, arrays, the same bits as FMI 2.0, states, derivatives, refusals."""

import ctypes
import subprocess
from contextlib import contextmanager

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import repacked
from fmi3_host import walk
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

NAMES = (
    "x",
    "v",
    "F",
    "impulse",
    "E_total",
    "p_total",
    "F_support",
    "overlap",
    "a",
    "E_dissipated",
    "E_residual",
)


def scalars(name, n):
    """Names of an array's elements in FMI 2.0."""
    return [f"{name}[{i + 1}]" for i in range(n)]


def test_the_description_is_valid(fmu3_path, producer):
    assert validate_fmu(str(fmu3_path)) == []
    checked = subprocess.run([producer, "check", fmu3_path], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    told = subprocess.run([producer, "info", fmu3_path], capture_output=True, text=True, check=True).stdout
    assert "NewtonsCradle (FMI 3.0, ModelExchange, CoSimulation)" in told and "balls        5" in told, told


def test_names_are_those_of_fmi_2(fmu3_path, fmu):
    description = fmpy.read_model_description(str(fmu3_path))
    arrays = {variable.name for variable in description.modelVariables}
    families = {name.replace("[1]", "") for name in fmu.variables if "[" not in name or "[1]" in name}
    assert families - arrays == {"t_next_isOnset"}
    assert {"time", "n", "onset.clock", "release.clock", "der(F_ext)", "derivatives.of"} < arrays - families
    outputs = [variable.name for variable in description.modelVariables if variable.causality == "output"]
    assert outputs[:11] == [
        *[
            "x",
            "F",
            "v",
            "E_total",
            "p_total",
            "F_support",
            "t_next",
            "impulse",
            "F_mean",
            "F_peak",
            "F_support_mean",
        ]
    ]


@pytest.mark.parametrize("step", [2.0**-10, 2.0**-3, 10.0])
@pytest.mark.parametrize("preset", ["figure5", "steel"])
def test_the_same_bits_as_fmi_2(make3, fmu, step, preset):
    stop = 20.0 if step == 10.0 else 1.5
    parameters = nc.figure5() if preset == "figure5" else nc.steel()
    record = [name for family in NAMES for name in fmu_names(fmu, family)]
    reference = fmu.simulate(parameters, stop=stop, step=step, record=record)
    times = np.arange(round(stop / step) + 1) * step
    for options in ({}, {"eventModeUsed": True}, {"eventModeUsed": True, "earlyReturnAllowed": True}):
        cradle = make3().start(parameters, **options)
        if options:
            cradle.events()
        for i, time in enumerate(times):
            if i:
                walk(cradle, times[i - 1], time)
            for family in NAMES:
                values = np.atleast_1d(cradle.get(family))
                names = fmu_names(fmu, family)
                expected = np.array([reference[name][i] for name in names])
                assert values[: len(names)].tobytes() == expected.tobytes(), (options, family, time)


def fmu_names(fmu, family):
    """The variables of FMI 2.0 that an array stands for."""
    return [name for name in fmu.variables if name == family or name.startswith(f"{family}[")]


def test_fmpy_simulates_it_as_it_is(fmu3_path, fmu):
    reference = fmu.simulate(stop=10.0, step=2.0**-4, record=["x[1]", "impulse[3]"])
    for use_event_mode, early_return_allowed in ((False, False), (True, False), (True, True)):
        result = fmpy.simulate_fmu(
            str(fmu3_path),
            stop_time=10.0,
            output_interval=2.0**-4,
            use_event_mode=use_event_mode,
            early_return_allowed=early_return_allowed,
        )
        place = {time: i for i, time in enumerate(result["time"])}
        rows = [place[time] for time in reference["time"]]
        assert result["x"][rows, 0].tobytes() == reference["x[1]"].tobytes()
        assert result["impulse"][rows, 2].tobytes() == reference["impulse[3]"].tobytes()
        assert use_event_mode == bool(result["onset.closed"].any())


@pytest.mark.parametrize("balls", [1, 2, 13, pytest.param(1000, marks=pytest.mark.all)])
def test_the_host_chooses_the_number_of_balls(make3, fmu_path, producer, tmp_path, balls):
    cradle = make3().start(balls=balls)
    assert cradle.get("n") == balls and len(cradle.get("x")) == balls
    cradle.step(0.0, 1.0)
    built = repacked(producer, fmu_path, tmp_path / "built.fmu", "--balls", str(balls))
    with nc.Fmu(built) as fmu:
        run = fmu.simulate(stop=1.0, step=1.0, record=[*scalars("x", balls), "E_total"])
    assert cradle.get("x").tobytes() == np.array([run[name][-1] for name in scalars("x", balls)]).tobytes()
    assert cradle.get("E_total") == run["E_total"][-1]
    if balls == 1:
        assert cradle.get("overlap").tolist() == [-1e30] and cradle.get("inContact").tolist() == [False]


def test_a_new_number_of_balls_keeps_the_scalars(make3):
    cradle = make3().make()
    cradle.set("pendulum.length", 0.5)
    cradle.enterConfigurationMode()
    cradle.set("n", 7)
    cradle.exitConfigurationMode()
    cradle.n = 7
    cradle.set("contact.gap", [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 0.25])
    cradle.enterInitializationMode()
    assert cradle.get("pendulum.length") == 0.5
    assert cradle.get("x_start").tolist() == [-0.1, -0.1, 0, 0, 0, 0, 0]
    assert cradle.get("contact.gap").tolist() == [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 0.25]


def test_what_is_refused_is_named(make3):
    @contextmanager
    def refused(status, *words):
        with pytest.raises(FMICallException) as error:
            yield
        assert error.value.status == status
        assert cradle.lines[-1][:2] == (status, {2: "logStatusDiscard", 3: "logStatusError"}[status])
        assert all(word in cradle.lines[-1][2] for word in words), cradle.lines[-1]

    cradle = make3().make()
    cradle.enterConfigurationMode()
    with refused(2, "n = 0", "1 to 10000"):
        cradle.set("n", 0)
    with refused(2, "n = 10001"):
        cradle.set("n", 10001)
    cradle.exitConfigurationMode()
    with refused(2, "ball.mass = -1 kg", "> 0 kg"):
        cradle.set("ball.mass", -1.0)
    with refused(2, "contact.model = 1099511627776", "powerLaw (1)"):
        cradle.set("contact.model", 1 << 40)
    cradle.enterInitializationMode()  # The mode was kept, and nothing applied.
    assert cradle.get("ball.mass") == 1.0 and cradle.get("n") == 5
    with refused(3, "nValues = 3", "5", "x_start"):
        cradle.set("x_start", [0.0, 0.0, 0.0])
    with refused(3, "the terminated state"):
        cradle.exitInitializationMode()
    cradle.reset()
    cradle.enterInitializationMode()
    with refused(3, "n can only be set in Configuration Mode"):
        cradle.set("n", 6)
    cradle.reset()
    cradle.n = 5
    cradle.enterInitializationMode()
    cradle.exitInitializationMode()
    with refused(3, "currentCommunicationPoint"):
        cradle.step(1.0, 0.1)
    assert cradle.get("x")[0] == -0.1  # Terminated: the last values are there.
    with refused(3, "fmi3DoStep", "the terminated state"):
        cradle.step(0.0, 0.1)


def test_the_log_is_silent_unless_it_is_on(make3):
    cradle = make3().make(loggingOn=False)
    with pytest.raises(FMICallException):
        cradle.set("ball.mass", -1.0)
    assert cradle.lines == []


def test_categories_of_the_log_are_switched_one_by_one(make3):
    def switch(on, *names):
        texts = (ctypes.c_char_p * len(names))(*(name.encode() for name in names))
        cradle.fmi3SetDebugLogging(cradle.component, on, len(names), texts)

    def logged():
        cradle.lines.clear()
        with pytest.raises(FMICallException):
            cradle.set("ball.mass", -1.0)
        return [category for _, category, _ in cradle.lines]

    cradle = make3().make(loggingOn=False)
    assert logged() == []
    switch(True, "logStatusDiscard")
    switch(True, "logEvents")
    assert logged() == ["logStatusDiscard"]
    switch(False, "logStatusDiscard")
    assert logged() == []


def test_slopes_of_inputs_are_those_of_fmi_2(make3, fmu):
    cradle = make3().start({"gravity": 0.0, "x_start": np.zeros(5)})
    cradle.set("F_ext", [0.0, 0.0, 0.0, 0.0, 1.0])
    cradle.set("der(F_ext)", [0.0, 0.0, 0.0, 0.0, 2.0])
    assert cradle.get("der(F_ext)")[4] == 2.0
    cradle.step(0.0, 1.0)
    assert cradle.get("v")[4] == pytest.approx(1.0 + 1.0)  # The integral of 1 + 2 t.
    assert cradle.get("F_ext")[4] == pytest.approx(3.0)
    cradle.step(1.0, 1.0)
    assert cradle.get("v")[4] == pytest.approx(2.0 + 3.0 + 1.0)


@pytest.mark.parametrize("options", [{}, {"eventModeUsed": True, "earlyReturnAllowed": True}])
def test_a_state_goes_on_in_another_instance(make3, options):
    one, other = (make3().start(balls=balls, **options) for balls in (7, 3))
    for cradle in (one, other):
        if options:
            cradle.events()
    walk(one, 0.0, 0.5)
    other.go_back(one.state())
    other.n = 7
    told = [walk(cradle, 0.5, 2.0) for cradle in (one, other)]
    assert told[0] == told[1] and bool(told[0]) == bool(options)
    for name in NAMES:
        assert np.array(one.get(name)).tobytes() == np.array(other.get(name)).tobytes()
    damaged = bytearray(one.state())
    damaged[-40] ^= 1
    with pytest.raises(FMICallException):
        one.go_back(bytes(damaged))


def test_derivatives(make3, fmu):
    cradle = make3().make()
    cradle.enterInitializationMode()
    known, unknown = ["x_start", "ball.mass"], ["E_total", "F_support", "p_total"]
    rows = np.array([cradle.derivative("Adjoint", unknown, known, seed, 6) for seed in np.eye(3)])
    columns = np.array([cradle.derivative("Directional", unknown, known, seed, 3) for seed in np.eye(6)])
    assert np.array_equal(rows, columns.T) and rows.any()
    # m g/L x of ball 1.
    assert rows[0, 0] == pytest.approx(9.81 / 1.962 * -0.1)
    cradle.exitInitializationMode()
    cradle.step(0.0, 0.5)
    assert not cradle.derivative("Directional", ["x", "v"], ["F_ext"], [1.0, 0, 0, 0, 0], 10).any()
    cradle.set("derivatives.of", 2)
    found = cradle.derivative("Directional", ["x"], ["F_ext"], [1.0, 0, 0, 0, 0], 5)
    other = make3().start()
    other.set("F_ext", [1e-6, 0, 0, 0, 0])
    other.step(0.0, 0.5)
    assert found == pytest.approx((other.get("x") - cradle.get("x")) / 1e-6, rel=1e-6, abs=1e-8)
    orders, values = (ctypes.c_int32 * 2)(1, 2), (ctypes.c_double * 10)()
    references = (ctypes.c_uint32 * 2)(*cradle.reference("x", "v"))
    cradle.fmi3GetOutputDerivatives(cradle.component, references, 2, orders, values, 10)
    assert np.array(values[:5]).tobytes() == cradle.get("v").tobytes()


def test_derivatives_of_the_run(make3):
    unknowns, knowns = (
        ["x", "E_total"],
        ["x_start", "contact.stiffness", "pendulum.length", "F_ext", "pendulum.drag"],
    )

    def run(changes, derivatives=3):
        cradle = make3().start({"derivatives.of": derivatives, "pendulum.drag": 0.1} | changes)
        cradle.step(0.0, 0.7)
        cradle.set("F_ext", [-0.1, 0.0, 0.0, 0.0, 0.0])
        cradle.set("pendulum.drag", 0.2 + changes.get("pendulum.drag", 0.1) - 0.1)
        cradle.step(0.7, 2.3)
        assert cradle.get("pulses").sum() > 8
        return cradle

    cradle = run({})
    weights, direction = np.arange(1.0, 7.0), np.linspace(1.0, 2.0, 13) * ([1.0] * 5 + [1e10] + [1.0] * 7)
    sensitivity = cradle.derivative("Adjoint", unknowns, knowns, weights, 13)
    derivatives = cradle.derivative("Directional", unknowns, knowns, direction, 6)
    assert sensitivity @ direction == pytest.approx(weights @ derivatives, rel=1e-12)
    restored = make3().start()
    restored.go_back(cradle.state())
    assert np.array_equal(restored.derivative("Adjoint", unknowns, knowns, weights, 13), sensitivity)
    for name, place, step in [("pendulum.length", 6, 1e-7), ("pendulum.drag", 12, 1e-7)]:
        start = {"pendulum.length": 1.962, "pendulum.drag": 0.1}[name]
        sides = [run({name: start + sign * step}) for sign in (1, -1)]
        change = [np.array([*side.get("x"), side.get("E_total")]) for side in sides]
        assert weights @ (change[0] - change[1]) / 2 / step == pytest.approx(sensitivity[place], rel=1e-6)
    # The inputs have changed, and nobody kept them.
    late = run({}, derivatives=2)
    late.set("derivatives.of", 3)
    with pytest.raises(FMICallException) as refused:
        late.derivative("Directional", unknowns, knowns, direction, 6)
    assert refused.value.status == 2  # discarded: the run goes on
    assert any("derivatives.of = run must be set before an input" in line[2] for line in late.lines)


def test_both_directions_agree_through_a_hundred_clicks(make3):
    knowns = {
        "x_start": 0.01,
        "v_start": 0.01,
        "ball.mass": 1.0,
        "contact.stiffness": 1e10,
        "contact.gap": 1e-4,
        "F_ext": 1.0,
    }
    unknowns = ["x", "v", "E_total", "impulse"]
    cradle = make3().start({"derivatives.of": 3, "contact.model": 2})
    cradle.step(0.0, 141.0)
    assert cradle.get("pulses")[:4].min() >= 100
    sizes = np.repeat(list(knowns.values()), [np.size(cradle.get(known)) for known in knowns])
    count = sum(np.size(cradle.get(unknown)) for unknown in unknowns)
    rng = np.random.default_rng(1)
    for _ in range(3):
        weights, direction = rng.normal(size=count), rng.normal(size=sizes.size) * sizes
        sensitivity = cradle.derivative("Adjoint", unknowns, list(knowns), weights, sizes.size)
        derivatives = cradle.derivative("Directional", unknowns, list(knowns), direction, count)
        assert sensitivity @ direction == pytest.approx(weights @ derivatives, rel=1e-12)


def test_an_fmu_without_clocks(fmu3_path, fmu_path, producer, tmp_path):
    path = tmp_path / "no-clocks.fmu"
    command = [producer, "build", "--from", fmu_path, "--fmi", "3", "--clocks", "none", "--out", path]
    subprocess.run(command, check=True, capture_output=True)
    assert validate_fmu(path) == []
    checked = subprocess.run([producer, "check", path], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
    again = subprocess.run([*command[:3], path, *command[4:-1], tmp_path / "again.fmu"], capture_output=True)
    assert again.returncode == 0 and (tmp_path / "again.fmu").read_bytes() == path.read_bytes()
    names = {variable.name for variable in fmpy.read_model_description(path).modelVariables}
    others = {variable.name for variable in fmpy.read_model_description(fmu3_path).modelVariables}
    assert names < others and all(name.startswith(("onset.", "release.")) for name in others - names)
    options = {"output": ["x", "pulses"], "stop_time": 2.0, "use_event_mode": True}
    one, other = (fmpy.simulate_fmu(fmu, early_return_allowed=True, **options) for fmu in (path, fmu3_path))
    assert one.tobytes() == other.tobytes()
    refused = subprocess.run([*command[:4], *command[6:]], capture_output=True, text=True)
    assert refused.returncode == 2 and "together with --fmi 3" in refused.stderr
