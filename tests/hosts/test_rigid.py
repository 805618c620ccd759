"""Rigid contacts through FMPy: the classical model next to the compliant one."""

import newtons_cradle as nc
import numpy as np
import pytest

RIGID = {"contact.model": 3, "contact.deadBand": 0.0}


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_as_many_balls_leave_as_come(fmu, count):
    quarter = 0.5 * np.pi / np.sqrt(5)
    values = RIGID | {f"x_start[{i}]": -0.1 if i <= count else 0.0 for i in range(1, 6)}
    with fmu.start(values) as run:
        for click in range(1, 11):
            run.step_to(2 * click * quarter)
            x = np.array([run.get(f"x[{i}]") for i in range(1, 6)])
            expected = np.array([0.0] * (5 - count) + [0.1] * count)
            assert np.abs(x - (expected if click % 2 else -expected[::-1])).max() < 1e-13
        assert len(run.pulses) == 10 * count * (5 - count)
        assert np.all(run.pulses["onset"] == run.pulses["release"]) and np.all(run.pulses["peak"] == 0)


def test_the_order_is_that_of_the_papers_table_1(fmu):
    """With two balls lifted: 2-3, then 1-2 with 3-4, then 2-3 with 4-5, then 3-4."""
    with fmu.start(RIGID) as run:
        run.step_to(1.0)
        assert list(run.pulses["contact"]) == [2, 1, 3, 2, 4, 3]
        (click,) = nc.impact_sequences(run.pulses)
        assert len(click) == 6 and nc.overlapping_neighbours(click) == 0


def test_with_losses_all_swing_together_in_the_end(fmu):
    record = ["x[1]", "x[5]", "v[1]", "v[5]", "E_total", "E_dissipated", "E_residual"]
    result = fmu.simulate(RIGID | {"contact.restitution": 0.9}, stop=600.0, step=0.5, record=record)
    assert abs(result["x[1]"][-1] - result["x[5]"][-1]) < 1e-9
    assert abs(result["v[1]"][-1] - result["v[5]"][-1]) < 1e-9
    # Two of five momenta, shared: 2/5 of the energy.
    assert result["E_dissipated"][-1] == pytest.approx(0.6 * result["E_total"][0], rel=1e-9)
    assert nc.energy_error(result) <= 1e-12
    assert np.all(np.diff(result.pulses["onset"]) >= 0)


def test_balls_pressed_together_transmit_the_constraint_force(fmu):
    """A push of 5 N on the first of five balls at rest: 4, 3, 2 and 1 N pass the contacts."""
    values = RIGID | {f"x_start[{i}]": 0.0 for i in range(1, 6)}
    result = fmu.simulate(values, stop=0.1, step=0.01, inputs=lambda t: {"F_ext[1]": 5.0})
    assert np.abs(result.stack("F")[1:] - [4, 3, 2, 1]).max() < 1e-12
    assert np.abs(result.stack("F_mean")[1:] - [4, 3, 2, 1]).max() < 1e-12
    assert np.abs(result.stack("impulse")[-1] - [0.4, 0.3, 0.2, 0.1]).max() < 1e-12
    assert len(result.pulses) == 0 and result["pulses[4]"][-1] == 1
