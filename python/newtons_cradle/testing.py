"""For tests of other programs: pytest fixtures, and assertions on runs.

With the package installed, pytest knows the fixtures by themselves; in a checkout, by `-p newtons_cradle.testing`:

    def test_my_controller(cradle):
        result = cradle(preset="desk").simulate(stop=10.0, control=my_controller)
        assert_energy_kept(result)
"""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from .fmu import Fmu, build
from .pulses import Array, impact_sequences, pulse_order
from .run import Result
from .views import energy_error


@pytest.fixture(scope="session")
def cradle() -> Iterator[Callable[..., Fmu]]:
    """FMUs by what `newtons_cradle.build` takes, `cradle(balls=13, set={"contact.model": "hertz"})`; without anything
    the default one. Each is built once in a session, and closed at its end."""
    made: dict[str, Fmu] = {}

    def cradle(**wanted: Any) -> Fmu:
        key = repr(sorted(wanted.items()))
        if key not in made:
            made[key] = build(**wanted) if wanted else Fmu()
        return made[key]

    yield cradle
    for fmu in made.values():
        fmu.close()


def assert_energy_kept(result: Result, tolerance: float = 1e-12) -> None:
    """E_residual stays below this part of the largest energy: no energy came from nowhere. E_residual and E_total
    must be recorded."""
    error = energy_error(result)
    assert error <= tolerance, f"the energy is off by {error:.3g} of the largest; allowed: {tolerance:.3g}"


def assert_pulse_order(pulses: Array, expected: list[list[int]], click: int = 0) -> None:
    """The contacts of one click close in this order, simultaneous ones together: [[2], [1, 3], [2, 4], [3]]."""
    clicks = impact_sequences(pulses)
    assert click < len(clicks), f"there are {len(clicks)} clicks; click {click} was expected (the first is 0)"
    order = pulse_order(clicks[click])
    assert order == expected, f"the contacts close in the order {order}; expected: {expected}"
