"""Model exchange of FMI 3.0 in FMPy's CVODE and Euler: the trajectories of FMI 2.0, and another number of balls."""

import ctypes

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from fmi3_host import read, started_exchange

N = 5
RESOLVED, MAPPED = 1, 2  # exchange.contacts


def exchanged(path, values, **options):
    """A run in model exchange."""
    options = {"stop_time": 10.0, "output_interval": 0.01, "record_events": False} | options
    return fmpy.simulate_fmu(
        str(path), fmi_type="ModelExchange", start_values=dict(values), validate=False, **options
    )


@pytest.mark.parametrize(
    ("contacts", "options"),
    [
        (MAPPED, {"relative_tolerance": 1e-8}),
        (RESOLVED, {"relative_tolerance": 1e-10}),
        (MAPPED, {"solver": "Euler", "step_size": 1e-3, "output_interval": 1e-3}),
    ],
)
def test_trajectories_are_those_of_fmi_2(fmu3_path, fmu_path, contacts, options):
    """CVODE weighs one state more, so that its steps are a little other ones; Euler's are the same."""
    names = [f"x[{i}]" for i in range(1, N + 1)]
    counts = [f"pulses[{i}]" for i in range(1, N)]
    values = {"exchange.contacts": contacts}
    other = exchanged(fmu_path, values, output=["E_total", *names, *counts], **options)
    own = exchanged(
        fmu3_path, values, output=["E_total", "x", "pulses", "onset.time", "release.impulse"], **options
    )
    assert own["pulses"][-1].tolist() == [7, 14, 14, 7, 0] == [*(other[name][-1] for name in counts), 0]
    assert own["time"].tobytes() == other["time"].tobytes()
    positions = np.column_stack([other[name] for name in names])
    if "solver" in options:
        assert own["x"].tobytes() == positions.tobytes()
        assert own["E_total"].tobytes() == other["E_total"].tobytes()
    # About a swing: where balls hit, an error in time is one in position.
    assert np.abs(own["x"] - positions).max() < 1e3 * options.get("relative_tolerance", 1e-8)
    assert own["onset.time"][-1] > 9.0 and own["release.impulse"].max() > 0.1


@pytest.mark.parametrize("balls", [1, 2, 13])
def test_another_number_of_balls(fmu3_path, tmp_path, balls):
    with started_exchange(fmu3_path, tmp_path, balls) as cradle:
        states, indicators = ctypes.c_size_t(), ctypes.c_size_t()
        cradle.fmi3GetNumberOfContinuousStates(cradle.component, ctypes.byref(states))
        cradle.fmi3GetNumberOfEventIndicators(cradle.component, ctypes.byref(indicators))
        assert (states.value, indicators.value) == (3 * balls + 2, 2 * balls)
        values = np.zeros(states.value)
        place = values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        cradle.getContinuousStates(place, states.value)
        q = read(cradle, "q", balls)
        assert values[:balls].tolist() == q.tolist() and q[0] == read(cradle, "x", balls)[0]
        assert q[1:].tolist() == read(cradle, "overlap", balls)[:-1].tolist()
        assert values[balls : 2 * balls].tolist() == read(cradle, "v", balls).tolist()
        cradle.getNominalsOfContinuousStates(place, states.value)
        assert (values > 0).all()


def test_derivatives_by_states_are_those_of_the_equations(fmu3_path, tmp_path):
    with started_exchange(fmu3_path, tmp_path, N) as cradle:
        references = {variable.name: variable.valueReference for variable in cradle.variables}

        def derivative(kind, unknowns, knowns, seed, length):
            lists = [
                (ctypes.c_uint32 * len(names))(*[references[name] for name in names])
                for names in (unknowns, knowns)
            ]
            seed, found = (ctypes.c_double * len(seed))(*seed), (ctypes.c_double * length)()
            call = getattr(cradle, f"fmi3Get{kind}Derivative")
            arguments = [part for names in lists for part in (names, len(names))]
            call(cradle.component, *arguments, seed, len(seed), found, length)
            return np.array(found[:])

        knowns, unknowns = ["q", "v", "F_ext"], ["der(q)", "a", "E_total"]
        columns = np.array([derivative("Directional", unknowns, knowns, seed, 11) for seed in np.eye(15)])
        rows = np.array([derivative("Adjoint", unknowns, knowns, seed, 15) for seed in np.eye(11)])
        assert np.array_equal(columns.T, rows)
        # x[i] is q[1] less the overlaps before it, plus constants; in flight a = -g/L x + F_ext/m.
        assert rows[5, 0] == pytest.approx(-5.0) and rows[9, 0] == pytest.approx(-5.0)
        assert rows[5, 1] == 0.0 and rows[9, 1] == pytest.approx(5.0)
        assert rows[0, 5] == 1.0 and rows[1, 5] == 1.0 and rows[1, 6] == -1.0
        assert rows[5:10, 10:].tolist() == np.eye(5).tolist()


def test_a_state_goes_on(fmu3_path, tmp_path):
    with started_exchange(fmu3_path, tmp_path, N, nc.figure5()) as cradle:
        cradle.enterContinuousTimeMode()
        state = cradle.getFMUState()
        before = read(cradle, "q", N)
        values = np.zeros(3 * N + 2)
        place = values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        cradle.setContinuousStates(place, len(values))
        assert not read(cradle, "q", N).any()
        cradle.setFMUState(state)
        cradle.freeFMUState(state)
        assert read(cradle, "q", N).tobytes() == before.tobytes()
