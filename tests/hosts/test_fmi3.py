"""FMI 3.0 through FMPy: arrays, the same bits as FMI 2.0, states, derivatives, refusals, memory."""

import ctypes
import sys
from contextlib import contextmanager
from pathlib import Path

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ended, repacked
from fmi3_host import BOTH, MAPPED, RESOLVED, Cradle
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

NAMES = ["x", "v", "F", "impulse", "overlap", "a"]
NAMES += ["E_total", "p_total", "F_support", "E_dissipated", "E_residual"]


@pytest.mark.parametrize("step", [2.0**-10, 2.0**-3, 10.0])
@pytest.mark.parametrize("setup", [nc.figure5(), nc.steel()], ids=["figure5", "steel"])
def test_fmi3_has_the_bits_of_fmi_2(make3, fmu, step, setup):
    stop = 20.0 if step == 10.0 else 1.5
    run = fmu.simulate(setup, stop=stop, step=step, record=NAMES)
    reference = {family: run[family] for family in NAMES}
    times = np.arange(round(stop / step) + 1) * step
    for options in ({}, {"eventModeUsed": True}, BOTH):
        cradle = make3(setup, **options)
        for i, time in enumerate(times):
            if i:
                cradle.walk(times[i - 1], time)
            for family in NAMES:
                expected = np.atleast_1d(reference[family][i])
                values = np.atleast_1d(cradle.get(family))[: len(expected)]
                assert values.tobytes() == expected.tobytes(), (options, family, time)


@pytest.mark.parametrize("balls", [1, 13])
def test_fmi3_host_chooses_the_number_of_balls(make3, fmu_path, balls):
    cradle = make3(balls=balls)
    assert cradle.get("n") == balls and len(cradle.get("x")) == balls
    cradle.step(0.0, 1.0)
    with nc.build(balls=balls, binaries=fmu_path) as fmu:
        assert validate_fmu(str(fmu.path)) == []
        run = fmu.simulate(stop=1.0, step=1.0, record=["x", "E_total"])
    assert cradle.get("x").tobytes() == run["x"][-1].tobytes()
    assert cradle.get("E_total") == run["E_total"][-1]
    if balls == 1:
        assert cradle.get("overlap").tolist() == [-1e30] and cradle.get("inContact").tolist() == [False]


def test_fmi3_variables_are_those_of_fmi_2(fmu, fmu3):
    assert list(fmu.outputs) == list(fmu3.outputs) and fmu.balls == fmu3.balls
    assert set(fmu.variables) - set(fmu3.variables) == {"t_next_isOnset"}
    for name in set(fmu.variables) & set(fmu3.variables):
        one, other = fmu.variables[name], fmu3.variables[name]
        assert (fmu.unit(name), one.type, one.causality) == (fmu3.unit(name), other.type, other.causality)
        assert one.start is None or fmu.built_with(name) == fmu3.built_with(name), name
    assert fmu.items("contact.model") == fmu3.items("contact.model")


def test_fmi3_new_number_of_balls_keeps_the_scalars(make3):
    cradle = make3(initialize=False)
    cradle.set("pendulum.length", 0.5)
    cradle.resize(7)
    cradle.set("contact.gap", [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 0.25])
    cradle.enterInitializationMode()
    assert cradle.get("pendulum.length") == 0.5
    assert cradle.get("x_start").tolist() == [-0.1, -0.1, 0, 0, 0, 0, 0]
    assert cradle.get("contact.gap").tolist() == [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 0.25]


def test_fmi3_names_what_it_refuses(make3):
    @contextmanager
    def refused(status, *words):
        with pytest.raises(FMICallException) as error:
            yield
        assert error.value.status == status
        line, category = cradle.lines[-1], {2: "logStatusDiscard", 3: "logStatusError"}[status]
        assert (line.status, line.category) == (status, category)
        assert all(word in line.text for word in words), line

    cradle = make3(initialize=False)
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
    cradle.enterInitializationMode()
    cradle.exitInitializationMode()
    with refused(3, "currentCommunicationPoint"):
        cradle.step(1.0, 0.1)
    assert cradle.get("x")[0] == -0.1  # Terminated: the last values are there.


def test_fmi3_log_categories_are_switched_one_by_one(make3):
    def logged():
        cradle.lines.clear()
        with pytest.raises(FMICallException):
            cradle.set("ball.mass", -1.0)
        return [line.category for line in cradle.lines]

    cradle = make3(initialize=False, loggingOn=False)
    assert logged() == []
    for on, names, expected in (
        (True, ["logStatusDiscard", "logEvents"], ["logStatusDiscard"]),
        (False, ["logStatusDiscard"], []),
    ):
        cradle.setDebugLogging(on, names)
        assert logged() == expected


def test_fmi3_slopes_of_inputs_are_those_of_fmi_2(make3):
    cradle = make3({"gravity": 0.0, "x_start": np.zeros(5)})
    cradle.set("F_ext", [0.0, 0.0, 0.0, 0.0, 1.0])
    cradle.set("der(F_ext)", [0.0, 0.0, 0.0, 0.0, 2.0])
    assert cradle.get("der(F_ext)")[4] == 2.0
    cradle.step(0.0, 1.0)
    assert cradle.get("v")[4] == pytest.approx(1.0 + 1.0)  # The integral of 1 + 2 t.
    assert cradle.get("F_ext")[4] == pytest.approx(3.0)
    cradle.step(1.0, 1.0)
    assert cradle.get("v")[4] == pytest.approx(2.0 + 3.0 + 1.0)


@pytest.mark.parametrize("options", [{}, BOTH], ids=["steps", "events"])
def test_fmi3_state_goes_on_in_another_instance(make3, options):
    one, other = (make3(balls=balls, **options) for balls in (7, 3))
    one.walk(0.0, 0.5)
    other.go_to(one.to_bytes())
    other.run.slave.balls = 7
    told = [cradle.walk(0.5, 2.0) for cradle in (one, other)]
    assert told[0] == told[1] and bool(told[0]) == bool(options)
    for name in NAMES:
        assert np.array(one.get(name)).tobytes() == np.array(other.get(name)).tobytes()
    damaged = bytearray(one.to_bytes())
    damaged[-40] ^= 1
    with pytest.raises(FMICallException):
        one.go_to(bytes(damaged))


def test_fmi3_derivatives(make3):
    cradle = make3(initialize=False)
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
    other = make3()
    other.set("F_ext", [1e-6, 0, 0, 0, 0])
    other.step(0.0, 0.5)
    assert found == pytest.approx((other.get("x") - cradle.get("x")) / 1e-6, rel=1e-6, abs=1e-8)
    orders, values = (ctypes.c_int32 * 2)(1, 2), (ctypes.c_double * 10)()
    references = (ctypes.c_uint32 * 2)(*cradle.references("x", "v"))
    cradle.fmi3GetOutputDerivatives(cradle.component, references, 2, orders, values, 10)
    assert np.array(values[:5]).tobytes() == cradle.get("v").tobytes()


def test_fmi3_derivatives_of_the_run(make3):
    unknowns = ["x", "E_total"]
    knowns = ["x_start", "contact.stiffness", "pendulum.length", "F_ext", "pendulum.drag"]

    def run(changes, derivatives=3):
        cradle = make3({"derivatives.of": derivatives, "pendulum.drag": 0.1} | changes)
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
    restored = make3()
    restored.go_to(cradle.to_bytes())
    assert np.array_equal(restored.derivative("Adjoint", unknowns, knowns, weights, 13), sensitivity)
    for name, start, place in [("pendulum.length", 1.962, 6), ("pendulum.drag", 0.1, 12)]:
        sides = [run({name: start + sign * 1e-7}) for sign in (1, -1)]
        change = [np.array([*side.get("x"), side.get("E_total")]) for side in sides]
        assert weights @ (change[0] - change[1]) / 2e-7 == pytest.approx(sensitivity[place], rel=1e-6)
    # Before the first step they are those at the start.
    at_start, first = make3({"derivatives.of": 3}), [1.0, 0.0, 0.0, 0.0, 0.0]
    for kind in ("Directional", "Adjoint"):
        assert at_start.derivative(kind, ["x"], ["x_start"], first, 5) == pytest.approx(first)
    # The inputs have changed, and nobody kept them.
    late = run({}, derivatives=2)
    late.set("derivatives.of", 3)
    with pytest.raises(FMICallException) as refused:
        late.derivative("Directional", unknowns, knowns, direction, 6)
    assert refused.value.status == 2  # discarded: the run goes on
    assert any("derivatives.of = run must be set before an input" in line.text for line in late.lines)


@pytest.fixture
def packed(fmu_path, producer, tmp_path):
    """Packs an FMU of FMI 3.0 with options: a valid one, which is the same when it is packed again."""

    def packed(*options):
        path = repacked(producer, fmu_path, tmp_path / f"{len(options)}.fmu", "--fmi", "3", *options)
        again = repacked(producer, path, tmp_path / "again.fmu", "--fmi", "3", *options)
        assert again.read_bytes() == path.read_bytes() and validate_fmu(str(path)) == []
        ended(producer, "check", path)
        return path

    return packed


def test_fmi3_without_clocks(packed):
    paths = packed("--clocks", "none"), packed()
    names, others = ({v.name for v in fmpy.read_model_description(path).modelVariables} for path in paths)
    assert names < others and all(name.startswith(("onset.", "release.")) for name in others - names)
    options = {"output": ["x", "pulses"], "stop_time": 2.0, "use_event_mode": True}
    one, other = (fmpy.simulate_fmu(path, early_return_allowed=True, **options) for path in paths)
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("clocks", [[], ["--clocks", "none"]], ids=["clocks", "no clocks"])
def test_fmi3_without_arrays(packed, fmu_path, clocks):
    """It has the doubles of FMI 2.0 in both kinds."""
    path = packed("--scalars", *clocks)
    names = [f"{name}[{i}]" for name in ("x", "v", "F", "overlap", "pulses") for i in range(1, 5)]
    options = {"output": [*names, "E_total"], "stop_time": 2.0, "output_interval": 1 / 128}
    for kind, more in (("CoSimulation", {}), ("ModelExchange", {"relative_tolerance": 1e-8})):
        two, three = (fmpy.simulate_fmu(str(each), fmi_type=kind, **options, **more) for each in (fmu_path, path))
        assert all(np.array_equal(two[name], three[name]) for name in two.dtype.names)
    with nc.Fmu(path) as scalars:
        run = scalars.simulate({"x_start": [-0.2, 0, 0, 0, 0]}, stop=1.0)
        assert scalars.balls == 5 and run["x[1]"][0] == -0.2 and len(run.pulses) > 3


@pytest.mark.parametrize(("contacts", "tolerance"), [(MAPPED, 1e-8), (RESOLVED, 1e-10)])
def test_fmi3_exchange_in_cvode(fmu3, contacts, tolerance):
    """tests/rust/fmi3 and the crate `fmi-rs` compare model exchange with that of FMI 2.0, bit by bit."""
    result = fmpy.simulate_fmu(
        str(fmu3.path),
        fmi_type="ModelExchange",
        start_values={"exchange.contacts": contacts},
        output=["E_residual", "pulses", "onset.time", "release.impulse"],
        stop_time=10.0,
        output_interval=0.01,
        relative_tolerance=tolerance,
        record_events=False,
    )
    assert result["pulses"][-1].tolist() == [7, 14, 14, 7, 0]
    assert abs(result["E_residual"][-1]) < 1e4 * tolerance
    assert result["onset.time"][-1] > 9.0 and result["release.impulse"].max() > 0.1


@pytest.mark.parametrize("balls", [1, 2, 13])
def test_fmi3_exchange_states_for_any_number_of_balls(make3, balls):
    cradle = make3(balls=balls, exchange=True)
    states = cradle.getNumberOfContinuousStates()
    assert (states, cradle.getNumberOfEventIndicators()) == (3 * balls + 2, 2 * balls)
    values = cradle.vector("getContinuousStates", states)
    assert values[: 2 * balls].tolist() == [*cradle.get("q"), *cradle.get("v")]
    assert values[:balls].tolist() == [cradle.get("x")[0], *cradle.get("overlap")[:-1]]
    assert (cradle.vector("getNominalsOfContinuousStates", states) > 0).all()


def test_fmi3_exchange_derivatives_by_states_are_those_of_the_equations(make3):
    cradle = make3(exchange=True)
    unknowns, knowns = ["der(q)", "a", "E_total"], ["q", "v", "F_ext"]
    columns = [cradle.derivative("Directional", unknowns, knowns, seed, 11) for seed in np.eye(15)]
    rows = np.array([cradle.derivative("Adjoint", unknowns, knowns, seed, 15) for seed in np.eye(11)])
    assert np.array_equal(np.transpose(columns), rows)
    # x[i] is q[1] less the overlaps before it, plus constants; in flight a = -g/L x + F_ext/m.
    assert rows[[5, 9], 0] == pytest.approx(-5.0)
    assert rows[5, 1] == 0.0 and rows[9, 1] == pytest.approx(5.0)
    assert rows[[0, 1, 1], [5, 5, 6]].tolist() == [1.0, 1.0, -1.0]
    assert rows[5:10, 10:].tolist() == np.eye(5).tolist()


@pytest.mark.all
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_fmi3_instances_leave_no_memory_behind(fmu3):
    """FMPy loads the library for each and unloads it afterwards: what it keeps in statics is lost. What FMI 2.0 might
    keep besides, AddressSanitizer finds in tests/rust/ffi."""

    def once() -> None:
        exchange = Cradle(fmu3, balls=7, exchange=True)
        exchange.updateDiscreteStates()
        exchange.enterContinuousTimeMode()
        exchange.setTime(0.1)
        exchange.go_to(exchange.to_bytes())
        exchange.freeInstance()
        cradle = Cradle(fmu3, balls=7, eventModeUsed=True)
        cradle.walk(0.0, 1.0)
        cradle.go_to(cradle.to_bytes())
        cradle.terminate()
        cradle.freeInstance()

    def kept() -> float:
        """Bytes that each of a hundred calls has added to the resident memory of this process."""
        memory = Path("/proc/self/statm")
        before = int(memory.read_text().split()[1])
        for _ in range(100):
            once()
        return (int(memory.read_text().split()[1]) - before) * 4096 / 100

    # What a leak takes it takes again. A heap that other tests have used may grow for some hundred calls.
    assert any(kept() < 1000 for _ in range(10))
