"""A real cradle's losses, from a video of it.

Balls swing on arcs of radius L: angle'' = -(g/L) sin(angle) - (b/m) angle'. One ball is lifted and let go; the others
hang at rest. Its click passes through the chain ball by ball. Each hit passes on the share (1 + e)/2 of the speed
(equal masses, e the coefficient of restitution), and the last ball rises. The equation gives two speeds at the lowest
point: the first ball's on arrival, and the last ball's, which then rises as filmed. Their ratio, last over first, is
((1 + e)/2)^(n - 1).

After a few dozen clicks all balls swing together. By then the contacts lose nothing, and the amplitudes are small and
fall as exp(-delta t) with delta = b/(2 m), which gives the drag b.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from .errors import MOST_BALLS, InvalidValue, number, whole
from .fmu import Fmu
from .losses import damping
from .pulses import Array
from .run.model import Values
from .runge_kutta import runge_kutta

HALVINGS = 20  # bisections of the interval with the damping factor
SAMPLES = 301  # around the highest point


@dataclass(frozen=True)
class Calibration:
    """Results. `restitution`: e, 0 to 1; `drag`: b of every ball, kg/s; `speed`: of the first click, m/s."""

    restitution: float
    drag: float
    speed: float

    def rigid(self) -> dict[str, Any]:
        """Start values of rigid contacts with this restitution, for balls on arcs."""
        law = {"contact.model": "rigid", "contact.restitution": self.restitution}
        return law | {"pendulum.model": "circular", "pendulum.drag": self.drag}

    def pairs(self, fmu: Fmu, values: Values, law: str = "huntCrossley") -> dict[str, Any]:
        """Start values of a damping law, for balls that hang apart: two free balls of this cradle that meet at the
        speed of the first click part with this restitution. Raises InvalidValue."""
        lossy = damping(law, values, restitution=self.restitution, speed=self.speed, fmu=fmu)
        return {"pendulum.model": "circular", "pendulum.drag": self.drag, **lossy}

    def compliant(self, fmu: Fmu, values: Values) -> dict[str, Any]:
        """Start values of power-law or Hertz contacts with which the last ball rises as filmed, that is, as high as
        after separate impacts with this restitution.

        `values` describe the cradle and the lift, as `preset("desk")` does; balls swing on arcs. Touching balls do not
        collide one after the other, so no formula gives the Hunt-Crossley damping factor from e: trial runs find it.
        Raises InvalidValue, FmuError.
        """
        law = {"pendulum.model": "circular", "contact.dampingLaw": "huntCrossley"}
        base = {**values, **law, "pendulum.drag": self.drag}
        given = fmu.settings(values)
        length, mass, gravity = (
            float(given.get(name, fmu.built_with(name))) for name in ("pendulum.length", "ball.mass", "gravity")
        )
        left = self.speed * _passed_on(self.restitution, fmu.balls)
        height = length * (1.0 - math.cos(_highest(left / length, self.drag / (2.0 * mass), gravity / length)))
        # An upper bound: the factor by which a pair loses four fifths of its speed.
        most = damping("huntCrossley", values, restitution=0.2, speed=self.speed, fmu=fmu)["contact.huntCrossley"]
        low, high = 0.0, most  # s/m
        undamped = _rise(fmu, base | {"contact.huntCrossley": low})
        if undamped < height:
            raise InvalidValue(
                f"restitution = {self.restitution:.6g} is refused: the last ball would rise by {height:.4g} m, by these "
                f"contacts without damping {undamped:.4g} m"
            )
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            higher = _rise(fmu, base | {"contact.huntCrossley": middle}) > height
            low, high = (middle, high) if higher else (low, middle)
        return {"pendulum.drag": self.drag, **law, "contact.huntCrossley": 0.5 * (low + high)}


def _passed_on(restitution: float, balls: int) -> float:
    """The last ball's speed over the first ball's, after separate impacts."""
    return (0.5 * (1.0 + restitution)) ** (balls - 1)


def _rise(fmu: Fmu, values: Values) -> float:
    """How high the last ball rises after the first click, about half a period after the lift, m."""
    last = f"y[{fmu.balls}]"
    with fmu.start(values) as run:
        period = run["pendulum.period"]  # of small swings
        times = np.concatenate([[0.0], np.linspace(0.4, 0.7, SAMPLES) * period])
    return float(fmu.simulate(values, times=times, record=[last])[last].max())


def _swing(angle: float, speed: float, delta: float, rate: float) -> Iterator[tuple[Array, float]]:
    """Successive states (rad, rad/s) of a pendulum, each with its acceleration (rad/s2). `delta`: b/(2 m), 1/s; `rate`:
    g/L, 1/s2."""

    def slopes(_time: float, state: Array) -> Array:
        return np.array([state[1], -2.0 * delta * state[1] - rate * math.sin(state[0])])

    state, h = np.array([angle, speed]), 5e-3 / math.sqrt(rate)
    while True:
        yield state, float(slopes(0.0, state)[1])
        state = runge_kutta(slopes, 0.0, state, h)


def _arrival(angle: float, delta: float, rate: float) -> float:
    """The angular speed (rad/s) at the lowest point of a pendulum released at `angle` (rad). With `-delta` in place of
    `delta`: the angular speed there with which it rises to `angle`. `rate`: g/L, 1/s2."""
    for (before, _), (after, _) in pairwise(_swing(angle, 0.0, delta, rate)):
        if after[0] <= 0.0:
            # Near the lowest point the speed hardly changes.
            return float(-np.interp(0.0, [after[0], before[0]], [after[1], before[1]]))
    raise AssertionError("a pendulum falls for ever")


def _highest(speed: float, delta: float, rate: float) -> float:
    """The largest angle (rad) of a pendulum that leaves its lowest point at `speed` (rad/s)."""
    for ((angle, left), acceleration), (after, _) in pairwise(_swing(0.0, speed, delta, rate)):
        if after[1] <= 0.0:
            # Near the highest point the acceleration hardly changes.
            return float(angle - left * left / (2.0 * acceleration))
    raise AssertionError("a pendulum rises for ever")


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
        raise InvalidValue(f"amplitudes = {amplitudes} is refused: the second, {interval} s later, must not be larger")
    if lift >= length:
        raise InvalidValue(f"lift = {lift} is refused; allowed: less than the length, {length} m")
    delta = math.log(first / second) / interval
    if delta**2 >= gravity / length:
        shown = f"amplitudes = {amplitudes}, interval = {interval}"
        raise InvalidValue(f"{shown} are refused: such a pendulum does not swing")
    rate = gravity / length
    arrival = _arrival(math.asin(lift / length), delta, rate)

    def passed_on(rise: float) -> float:
        """The last ball's speed over `arrival`, if it rises by `rise` (m)."""
        return _arrival(math.acos(1.0 - rise / length), -delta, rate) / arrival

    def height_of(share: float) -> float:
        return length * (1.0 - math.cos(_highest(share * arrival, delta, rate)))

    share = passed_on(height) if height < length else math.inf
    restitution = 2.0 * share ** (1.0 / (balls - 1)) - 1.0
    if not 0.0 <= restitution <= 1.0:
        least, most = (height_of(_passed_on(e, balls)) for e in (0.0, 1.0))
        raise InvalidValue(f"height = {height} is refused; allowed here: {least:.3g} to {most:.3g} m")
    return Calibration(float(restitution), float(2.0 * mass * delta), float(length * arrival))
