"""Energy and momentum through FMPy, undamped: the default parameters and the paper's."""

import newtons_cradle as nc
import numpy as np
import pytest

CASES = {  # label: (start values, m v of one ball at impact, kg.m/s)
    "default": ({}, 0.1 * np.sqrt(5)),
    "figure 5, no dead band": (nc.figure5(0.0), np.sqrt(5)),
    "figure 5": (nc.figure5(), np.sqrt(5)),
    "figure 6": (nc.figure6(), np.sqrt(5)),
    "rigid": ({"contact.model": 3}, 0.1 * np.sqrt(5)),
}
FREE = {  # gravity = 0, unequal masses, gaps, every kind of contact
    "linear": nc.power_law(1e10, 1.0, 1e-6),
    "cubic": nc.power_law(1e16, 3.0),
    "hertz": {"contact.model": 2, "contact.deadBand": 0.0},
    "damped": nc.power_law(1e10, 1.0) | {"contact.damping": 2e3},
    "damped, no pull": nc.power_law(1e10, 1.0) | {"contact.damping": 2e3, "contact.dampingLaw": 2},
    "hunt-crossley": nc.power_law(1e12, 1.5) | {"contact.huntCrossley": 0.2, "contact.dampingLaw": 3},
    "viscoelastic": nc.power_law(1e12, 1.5) | {"contact.relaxationTime": 1e-7, "contact.dampingLaw": 4},
    "rigid": {"contact.model": 3, "contact.deadBand": 0.0, "contact.restitution": 0.6},
}
RATIOS = [1.0, 0.5, 2.0, 1.3, 0.7]


@pytest.fixture(scope="module", params=CASES)
def run_of_ten_seconds(request, fmu):
    """(result, m v) of each case, simulated once."""
    values, scale = CASES[request.param]
    return fmu.simulate(values, stop=10.0), scale


def test_energy(run_of_ten_seconds):
    result, _ = run_of_ten_seconds
    assert result["E_total"][0] > 0
    assert np.any(result["pulses[2]"] > 0)
    assert nc.energy_error(result) <= 1e-10


def test_momentum_over_each_impact_sequence(run_of_ten_seconds):
    result, scale = run_of_ten_seconds
    defects = nc.momentum_of_sequences(result)
    assert len(defects) == 7
    assert np.abs(defects).max() <= 1e-12 * scale


def test_momentum_over_all_steps_added_up(run_of_ten_seconds):
    """From the start to every communication point: the swings in between have to balance, too."""
    result, scale = run_of_ten_seconds
    assert np.abs(np.cumsum(nc.momentum_defect(result))).max() <= 1e-12 * scale


def test_momentum_over_the_microseconds_of_an_impact(fmu):
    """The same with steps that begin and end close to the impact, where rounding cannot hide."""
    scale = np.sqrt(5)
    for values in (nc.figure5(0.0), nc.figure5()):
        with fmu.start(values) as run:
            recorder = run.recorder(["p_total", "F_support_mean"])
            run.step_to_onset(before=1e-6)
            recorder.sample()
            for _ in range(10):
                run.step_to(run.time + 5e-7)
                recorder.sample()
            assert len(run.pulses) >= 4
        assert np.abs(nc.momentum_defect(recorder.result())).max() <= 1e-12 * scale


@pytest.mark.parametrize("case", FREE)
def test_impulse_is_the_momentum_that_crossed_the_contact(fmu, case):
    """Without gravity everything right of contact i has its momentum through contact i."""
    mass = np.array(RATIOS)
    values = {"gravity": 0.0, "ball.mass": 1.0} | FREE[case]
    values |= {f"ball.massRatio[{i}]": m for i, m in enumerate(RATIOS, 1)}
    values |= {f"x_start[{i}]": -1e-4 * (5 - i) for i in range(1, 6)}  # 0.1 mm between all neighbours
    values |= {f"v_start[{i}]": v for i, v in enumerate([1.0, 0.5, 0.0, 0.0, -0.8], 1)}
    result = fmu.simulate(values, stop=0.01, step=1e-4)
    momentum = mass * (result.stack("v") - result.stack("v")[0])
    crossed = momentum[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:]
    assert len(result.pulses) >= 4
    assert np.abs(result.stack("impulse") - crossed).max() <= 1e-12
    total = sum(result.pulses["impulse"][result.pulses["contact"] == 2])
    assert total == pytest.approx(result["impulse[2]"][-1], abs=1e-12)


def test_damped_run_accounts_for_its_losses(fmu):
    values = {"contact.damping": 1e3, "pendulum.drag": 0.05}
    record = ["E_total", "E_dissipated", "E_residual"]
    result = fmu.simulate(values, stop=5.0, record=record)
    assert result["E_dissipated"][-1] > 0.1 * result["E_total"][0]
    assert np.all(np.diff(result["E_dissipated"]) >= 0)
    assert nc.energy_error(result) <= 1e-10


def test_driven_run_accounts_for_outside_work(fmu):
    """A push on ball 5 and a shaken support, held over each step."""

    def inputs(t):
        return {"F_ext[5]": -0.5 if t < 1.0 else 0.0, "a_support": 0.3 * np.sin(3.0 * t)}

    record = ["E_total", "W_external", "E_residual"]
    result = fmu.simulate(stop=5.0, record=record, inputs=inputs)
    assert np.abs(result["W_external"]).max() > 0.1 * result["E_total"][0]
    assert nc.energy_error(result) <= 1e-10
