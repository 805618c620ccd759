"""The classical method of Runge and Kutta."""

from collections.abc import Callable
from typing import Any


def runge_kutta(f: Callable[[float, Any], Any], time: float, x: Any, h: float) -> Any:
    """A step of length h of the classical method of order 4."""
    k1 = f(time, x)
    k2 = f(time + h / 2, x + h / 2 * k1)
    k3 = f(time + h / 2, x + h / 2 * k2)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(time + h, x + h * k3))
