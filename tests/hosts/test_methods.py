"""The general-purpose solvers next to the event-driven method, through the host."""

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest

EVENT_DRIVEN, BDF, ADAMS, RK4 = 1, 2, 3, 4
# Contacts of about 0.2 ms with losses, and drag: what the solvers are given, and how close they come.
SETUP = {
    "contact.stiffness": 1e8,
    "contact.dampingLaw": 3,
    "contact.huntCrossley": 0.3,
    "pendulum.drag": 0.05,
}
METHODS = {
    "bdf": ({"solver.method": BDF, "solver.tolerance": 1e-12}, 1e-6),
    "adams": ({"solver.method": ADAMS, "solver.tolerance": 1e-12}, 1e-6),
    "rk4": ({"solver.method": RK4, "solver.fixedStep": 1e-6}, 1e-4),
}


@pytest.fixture(scope="module")
def truth(fmu):
    return fmu.simulate(SETUP, stop=3.0)


@pytest.mark.parametrize("method", METHODS)
def test_every_output_is_that_of_the_event_driven_method(fmu, truth, method):
    values, allowed = METHODS[method]
    result = fmu.simulate(SETUP | values, stop=3.0)
    assert len(result.pulses) == len(truth.pulses) > 8
    for name in fmu.outputs:
        got, expected = result[name].astype(float), truth[name].astype(float)
        if name == "t_next" and method == "rk4":
            # Its small steps do not lead a look ahead to the onset: there is none up to the time it tells.
            assert (got > result["time"]).all() and (got <= expected + allowed).all()
            continue
        assert np.abs(got - expected).max() <= allowed * max(np.abs(expected).max(), 1e-3), name
    for field in ("onset", "release", "peak", "impulse"):
        scale = np.abs(truth.pulses[field]).max()
        assert np.abs(result.pulses[field] - truth.pulses[field]).max() <= allowed * scale, field


@pytest.mark.parametrize("method", METHODS)
def test_communication_steps_do_not_matter(fmu, method):
    values = SETUP | METHODS[method][0]
    names = ["x[1]", "v[5]", "impulse[3]", "E_residual", "solver.steps"]
    with fmu.start(values) as coarse, fmu.start(values) as fine:
        for end in (0.7026, 1.5):
            coarse.step_to(end)
            while fine.time < end:
                fine.step_to(min(fine.time + 0.0137, end))
                fine.get("t_next")
            assert [coarse.get(name) for name in names] == [fine.get(name) for name in names]
            # How far a look ahead has come depends on the looks before, an onset does not.
            foreseen = [run.get("t_next_isOnset") and run.get("t_next") for run in (coarse, fine)]
            assert foreseen[0] == foreseen[1] or not all(foreseen)
        assert coarse.pulses.tobytes() == fine.pulses.tobytes()


def test_tolerance_pays(fmu):
    """Ten seconds of the paper's Figure 6: the energy error falls with the tolerance."""
    errors = []
    for tolerance in (1e-8, 1e-10, 1e-12):
        with fmu.start(nc.figure6() | {"solver.method": ADAMS, "solver.tolerance": tolerance}) as run:
            run.step_to(10.0)
            errors.append(abs(run.get("E_residual") / run.get("E_total")))
    assert errors[0] < 1e-5 and errors[1] < 1e-7 and errors[2] < 1e-8, errors


def test_simulate_fmu_takes_the_item_by_its_integer(fmu_path):
    result = fmpy.simulate_fmu(str(fmu_path), stop_time=2.0, start_values={"solver.method": ADAMS})
    assert [result[f"pulses[{i}]"][-1] for i in range(1, 5)] == [1, 2, 2, 1]
