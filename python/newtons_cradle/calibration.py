"""A real cradle's losses, from a video of it.

The pendulums are those of the FMU: x'' = -(g/L) x - (b/m) x'. One ball is lifted and let go; the others hang at rest.
Its click passes through the chain ball by ball. Each hit passes on the share (1 + e)/2 of the speed (equal
masses, e the coefficient of restitution), and the last ball rises. Between the lift and the highest point lies half a
period of a damped pendulum. The deflection of the last ball, divided by the lift, is then

    ((1 + e)/2)^(n - 1) exp(-pi delta/omega_d),   delta = b/(2 m),   omega_d^2 = g/L - delta^2.

After a few dozen clicks all balls swing together. Then nothing is lost in contacts, and the amplitudes fall as
exp(-delta t), which gives the drag b.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import InvalidValue, number, whole
from .fmu import Fmu
from .run.model import Values
from .setups import MOST_BALLS

HALVINGS = 20  # of the interval that the damping lies in
SAMPLES = 201  # around the highest point


@dataclass(frozen=True)
class Calibration:
    """Results. `restitution`: e, 0 to 1; `drag`: b of every ball, kg/s; `speed`: of the first click, m/s; `height`: as
    filmed, m."""

    restitution: float
    drag: float
    speed: float
    height: float

    def rigid(self) -> dict[str, Any]:
        """Start values of rigid contacts that lose as much."""
        return {"pendulum.drag": self.drag, "contact.model": "rigid", "contact.restitution": self.restitution}

    def compliant(self, fmu: Fmu, values: Values) -> dict[str, Any]:
        """Start values with which the last ball of this cradle rises as filmed, for power-law or Hertz contacts.

        `values` describe the cradle and the lift, as `preset("desk")` does. Runs find the Hunt-Crossley damping factor,
        because touching balls do not collide one after the other: no formula gives it from e. Raises InvalidValue,
        FmuError.
        """
        base = {**values, "pendulum.drag": self.drag, "contact.dampingLaw": "huntCrossley"}
        low, high = 0.0, 3.0 / self.speed  # s/m; the law passes on hardly anything at the upper end
        undamped = _rise(fmu, base | {"contact.huntCrossley": low})
        if undamped < self.height:
            raise InvalidValue(
                f"height = {self.height} m is refused: without damping these contacts reach {undamped:.4g} m"
            )
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            higher = _rise(fmu, base | {"contact.huntCrossley": middle}) > self.height
            low, high = (middle, high) if higher else (low, middle)
        found = {name: base[name] for name in ("pendulum.drag", "contact.dampingLaw")}
        return found | {"contact.huntCrossley": 0.5 * (low + high)}


def _rise(fmu: Fmu, values: Values) -> float:
    """How high the last ball rises after the first click, half a period after the lift, m."""
    last = f"x[{fmu.balls}]"
    with fmu.start(values) as run:
        period, length = run["pendulum.period"], run["pendulum.length"]
        times = np.concatenate([[0.0], np.linspace(0.4, 0.6, SAMPLES) * period])
    largest = float(fmu.simulate(values, times=times, record=[last])[last].max())
    return largest**2 / (2.0 * float(length))


def calibrate(
    *,
    lift: float,
    height: float,
    amplitudes: tuple[float, float],
    interval: float,
    length: float,
    mass: float,
    balls: int = 5,
    gravity: float = 9.81,
) -> Calibration:
    """Restitution and drag of a real cradle, from a video of it.

    `lift`: how far to the side the first ball is lifted, m; `height`: how high the last ball rises after the first
    click, m, above where it hung; `amplitudes`: two swings to the side, m, once all balls swing together, `interval`
    (s) apart; `length` of the pendulums, m; `mass` of a ball, kg; number of `balls`, at least 2; `gravity`, m/s2.
    Raises InvalidValue where a number is impossible.
    """
    given = {"lift": lift, "height": height, "interval": interval, "length": length, "mass": mass}
    if np.shape(amplitudes) != (2,):
        raise InvalidValue(f"amplitudes = {amplitudes!r} is refused; allowed: two of them (m)")
    first, second = amplitudes
    given |= {"gravity": gravity, "amplitudes[0]": first, "amplitudes[1]": second}
    for name, value in given.items():
        number(name, value, positive=True)
    whole("balls", balls, 2, MOST_BALLS)
    if second > first:
        rule = f"the second, {interval} s later, must not be larger"
        raise InvalidValue(f"amplitudes = {amplitudes} is refused: {rule}")
    if lift >= length:
        raise InvalidValue(f"lift = {lift} is refused; allowed: less than the length, {length} m")
    delta = math.log(first / second) / interval
    if delta**2 >= gravity / length:
        shown = f"amplitudes = {amplitudes}, interval = {interval}"
        raise InvalidValue(f"{shown} are refused: such a pendulum does not swing")
    omega = math.sqrt(gravity / length - delta**2)
    # A height is the square of a deflection, x^2/(2 L) for the FMU's linear pendulums.
    swing = math.exp(math.pi * delta / omega)
    passed = math.sqrt(2.0 * length * height) / lift * swing
    restitution = 2.0 * passed ** (1.0 / (balls - 1)) - 1.0
    if not 0.0 <= restitution <= 1.0:
        most = (lift / swing) ** 2 / (2.0 * length)
        least = most * 0.25 ** (balls - 1)
        raise InvalidValue(f"height = {height} is refused; allowed here: {least:.3g} to {most:.3g} m")
    # At x = 0, after a quarter of a period and a little more.
    phase = math.pi / 2.0 + math.asin(delta * math.sqrt(length / gravity))
    speed = lift * math.sqrt(gravity / length) * math.exp(-delta / omega * phase)
    return Calibration(float(restitution), float(2.0 * mass * delta), float(speed), float(height))
