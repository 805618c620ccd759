"""For tests of other programs: pytest fixtures, and assertions on runs.

With the package installed, pytest finds the fixtures by itself; in a checkout, with `-p newtons_cradle.testing`:

    def test_my_controller(cradle):
        result = cradle(preset="desk").simulate(stop=10.0, control=my_controller)
        assert_energy_kept(result)
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

import newtons_cradle as nc  # imports its modules at first use: pytest loads this file in every session

if TYPE_CHECKING:
    from .pulses import Array


@pytest.fixture(scope="session")
def cradle() -> Iterator["Callable[..., nc.Fmu]"]:
    """A function that builds FMUs and takes the arguments of `newtons_cradle.build`, such as
    `cradle(balls=13, set={"contact.model": "hertz"})`; without arguments, the default FMU. Each is built once in a
    session, and closed at its end."""
    made: dict[str, nc.Fmu] = {}

    def cradle(**wanted: Any) -> nc.Fmu:
        key = repr(sorted(wanted.items()))
        if key not in made:
            made[key] = nc.build(**wanted) if wanted else nc.Fmu()
        return made[key]

    yield cradle
    for fmu in made.values():
        fmu.close()


def assert_energy_kept(result: "nc.Result", tolerance: float = 1e-12) -> None:
    """Asserts that |E_residual| is at most `tolerance` times the largest energy: no energy came from nowhere.
    E_residual and E_total must be recorded."""
    error = nc.energy_error(result)
    assert error <= tolerance, f"the energy is off by {error:.3g} of the largest; allowed: {tolerance:.3g}"


def assert_pulse_order(pulses: "Array", expected: list[list[int]], click: int = 0) -> None:
    """Asserts that the contacts of a click close in this order, simultaneous ones together: [[2], [1, 3], [2, 4], [3]].
    `click`: its number, from 0."""
    clicks = nc.impact_sequences(pulses)
    assert click < len(clicks), f"there are {len(clicks)} clicks; click {click} was expected (the first is 0)"
    order = nc.pulse_order(clicks[click])
    assert order == expected, f"the contacts close in the order {order}; expected: {expected}"
