"""Balls on arcs, through FMPy: what is conserved, and the angle's outputs.

States against an integration in quadruple precision are checked in tests/rust/reference.rs.
"""

import math

import newtons_cradle as nc
import numpy as np
import pytest

ARCS = {"pendulum.model": "circular"}
LENGTH, RADIUS = 1.962, 0.0313  # m
UNEQUAL = {
    "pendulum.lengthRatio": [1.0, 1.25, 0.875, 1.125, 1.0],
    "ball.massRatio": [1.0, 1.5, 0.75, 1.25, 2.0],
}
INPUTS = {"F_ext[2]": 0.3, "a_support": -0.2}
STEEL = {"contact.model": "hertz", "contact.deadBand": 0.0}
SETUPS = {
    "Figure 6's contacts": nc.preset("figure6"),
    "touching steel": STEEL,
    "damped": STEEL
    | {"contact.dampingLaw": "huntCrossley", "contact.huntCrossley": 0.01, "pendulum.drag": 0.02},
    "unequal": STEEL | UNEQUAL | {"contact.deadBand": 2.6e-5},
}


def lifted(degrees, balls=2):
    """`balls` of five lifted by an angle, on arcs."""
    return nc.lifted(balls, amplitude=LENGTH * math.sin(math.radians(degrees))) | ARCS


@pytest.mark.parametrize("degrees", [30, 60])
@pytest.mark.parametrize("setup", SETUPS.values(), ids=SETUPS)
def test_energy_and_places(fmu, setup, degrees):
    """Energy, also that put in by forces and by a support that moves; places on the arcs and their rates."""
    record = ["x", "y", "v", "angle", "E_total", "E_dissipated", "W_external", "E_residual"]
    result = fmu.simulate(setup | lifted(degrees) | INPUTS, stop=10.0, step=0.025, record=record)
    energy = result["E_total"]
    balance = energy + result["E_dissipated"] - result["W_external"] - energy[0]
    assert abs(balance).max() <= 1e-13 * energy[0]
    assert result["E_residual"] == pytest.approx(balance, abs=1e-13 * energy[0])
    lengths = LENGTH * np.array(setup.get("pendulum.lengthRatio", [1.0] * 5))
    angle = result["angle"]
    assert result["x"] == pytest.approx(lengths * np.sin(angle), abs=1e-15)
    assert result["y"] == pytest.approx(2 * lengths * np.sin(angle / 2) ** 2, abs=1e-15)
    # The moments at which energies are known are those of the speeds along the arcs.
    masses = np.array(setup.get("ball.massRatio", [1.0] * 5))
    kinetic = (masses / 2 * (result["v"] / np.cos(angle)) ** 2).sum(axis=1)
    flying = energy - kinetic - 9.81 * (masses * result["y"]).sum(axis=1)
    assert abs(flying).min() <= 1e-13 * energy[0]


@pytest.mark.parametrize("setup", SETUPS.values(), ids=SETUPS)
def test_momentum_goes_into_the_support(fmu, setup):
    """sum m x'' = sum F_ext - F_support - m a_support, and the same upwards, in flight and inside a click: the
    accelerations are those of the equations of motion."""
    values = setup | lifted(60) | INPUTS
    masses = np.array(setup.get("ball.massRatio", [1.0] * 5))
    lengths = LENGTH * np.array(setup.get("pendulum.lengthRatio", [1.0] * 5))
    drag = setup.get("pendulum.drag", 0.0)
    push = np.array([0, 0.3, 0, 0, 0]) + 0.2 * masses
    names = ["x", "y", "v", "angle", "F", "F_support", "F_support_vertical"]
    with fmu.start(values) as run:
        _, inside = run.zoom(span=2e-4, step=1e-6, record=names, before=1e-5)
    assert inside["F"].max() > 0
    for result in (inside, fmu.simulate(values, stop=2.0, record=names)):
        x, y, angle, forces = (result[name] for name in ("x", "y", "angle", "F"))
        pivots = 2 * RADIUS * np.arange(5)
        line = np.stack([np.diff(x + pivots), np.diff(y)]) / np.hypot(np.diff(x + pivots), np.diff(y))
        pushed = [
            np.pad(forces * part, ((0, 0), (1, 0))) - np.pad(forces * part, ((0, 0), (0, 1))) for part in line
        ]
        sin, cos = np.sin(angle), np.cos(angle)
        speed = result["v"] / cos
        along = (pushed[0] * cos + pushed[1] * sin + push * cos - masses * 9.81 * sin - drag * speed) / masses
        inward = speed**2 / lengths
        changes = [
            (masses * (along * cos - inward * sin)).sum(axis=1),
            (masses * (along * sin + inward * cos)).sum(axis=1),
        ]
        from_outside = [push.sum(), -9.81 * masses.sum()]
        for change, outside, name in zip(
            changes, from_outside, ("F_support", "F_support_vertical"), strict=True
        ):
            scale = abs(forces).max() + 9.81 * masses.sum()
            assert change == pytest.approx(outside - result[name], abs=1e-12 * scale)
