"""Damping from a coefficient of restitution: e of two free balls at a speed, for each compliant law.

In units of the impact, of overlap and time, the reduced mass, the speed and the elastic force are 1: the overlap x has
x'' = -x^p - D x', with D = c for Kelvin and Voigt and D = p A x^(p-1) for viscoelastic spheres. An impact turns the
point (u, z) about the origin, from (1, 0): u = x' and z = x^((p+1)/2) sqrt(2/(p+1)), so that (u^2 + z^2)/2 is the
energy. In polar coordinates

    d ln(r)/d angle = -q cos^2 / (1 + q sin cos),  q = D / (sqrt((p+1)/2) x^((p-1)/2)).

The force ends, by a law that does not pull, where x^p = D e with u = -e; otherwise at the angle pi. Both are known from
e, so that only r there has to agree, at the root of one function of the coefficient. Hunt and Crossley's law has an
integral for every exponent: with a = alpha v, ln((1 + a)/(1 - a e)) = a (1 + e).
"""

import math
from collections.abc import Callable
from typing import Any

from .building import build
from .errors import InvalidValue, needed, number, whole
from .fmu import Fmu
from .run.model import Values

#: The coefficient of each damping law.
COEFFICIENTS = {
    "kelvinVoigt": "contact.damping",
    "kelvinVoigtNoPull": "contact.damping",
    "huntCrossley": "contact.huntCrossley",
    "viscoelastic": "contact.relaxationTime",
}
STEPS = 60  # of the coarsest integration
LEVELS = 5  # each with twice as many steps, extrapolated
ENDS = 4.9  # of the variable of integration, beyond which there is nothing left, to the last digit, for p up to 10


def damping(
    law: str,
    values: Values | None = None,
    *,
    restitution: float,
    speed: float,
    contact: int = 1,
    fmu: Fmu | None = None,
) -> dict[str, Any]:
    """Start values of this damping law by which two balls, free and alone, that close at `speed` (m/s) part with
    `restitution` times that speed.

    `nc.damping("huntCrossley", nc.preset("steel"), restitution=0.9, speed=1.0)` is a dict with `contact.dampingLaw` and
    its coefficient, to be merged with the others. `values` describe the cradle, the rest is as built into `fmu`, or if
    None the defaults of five balls; `contact` chooses the two balls, from 1. Balls in touch with others lose more:
    each impact is then none of two balls alone. Raises InvalidValue, UnknownName.
    """
    needed("law", law, str, f"one of {', '.join(COEFFICIENTS)}")
    if law not in COEFFICIENTS:
        raise InvalidValue(f"law = {law!r} is refused; allowed: {', '.join(COEFFICIENTS)}")
    e, v = number("restitution", restitution, positive=True, most=1.0), number("speed", speed, "m/s", positive=True)
    if fmu is None:
        with build() as built:
            return damping(law, values, restitution=e, speed=v, contact=contact, fmu=built)
    needed("fmu", fmu, Fmu, "an FMU as `nc.build()` makes it")
    at = whole("contact", contact, 1, max(fmu.balls - 1, 1))
    fmu.require(balls=max(fmu.balls, 2))
    given = fmu.settings(values or {})

    def value(name: str) -> float:
        return float(given.get(name, fmu.built_with(name)))

    def reduced(name: str) -> float:
        left, right = (value(name) * value(f"{name}Ratio[{ball}]") for ball in (at, at + 1))
        return left / (left + right) * right

    model = fmu.items("contact.model")
    chosen = next(name for name, item in model.items() if item == value("contact.model"))
    if chosen == "rigid":
        raise InvalidValue("contact.model = rigid is refused: its coefficient is contact.restitution; allowed: others")
    if chosen == "hertz":
        p, modulus = 1.5, reduced("ball.youngModulus") / (1.0 - value("ball.poissonRatio") ** 2)
        stiffness = 4.0 / 3.0 * modulus * math.sqrt(reduced("ball.radius"))
    else:
        p = value("contact.exponent")
        stiffness = value("contact.stiffness") * value("contact.overlapRef") ** (1.0 - p)
    stiffness *= value(f"contact.stiffnessRatio[{at}]")
    mass = reduced("ball.mass")
    length = (mass / stiffness * v * v) ** (1.0 / (p + 1.0))  # of the impact, m
    unit = {"contact.damping": mass * v / length, "contact.huntCrossley": 1.0 / v, "contact.relaxationTime": length / v}
    name = COEFFICIENTS[law]
    return {"contact.dampingLaw": law, name: coefficient(law, p, e) * unit[name]}


def coefficient(law: str, p: float, e: float) -> float:
    """The coefficient of a law for e, 0 < e <= 1, and the exponent p, in units of the impact."""
    if e == 1.0:
        return 0.0
    if law == "huntCrossley":

        def lacking(a: float) -> float:  # at 1/e and above the balls would not part
            return math.log1p(a) - math.log1p(-a * e) - a * (1.0 + e) if a * e < 1.0 else math.inf

        return root(lambda a: -lacking(a), 1.5 * (1.0 - e), 1.0 / e)
    # An estimate that is right for small losses of a linear contact.
    return root(lambda damping: excess(law, p, e, damping), 2.0 / math.pi * (1.0 - e), math.inf)


def excess(law: str, p: float, e: float, damping: float) -> float:
    """By how much ln(r) at the end is above that of e: positive where the coefficient is too small for e."""
    half = math.sqrt(0.5 * (p + 1.0))
    viscous = law == "viscoelastic"
    if law == "kelvinVoigt":
        end, beyond, last = math.pi, 0.0, math.log(e)
    else:
        overlap = damping * p * e if viscous else (damping * e) ** (1.0 / p)
        z = overlap ** (0.5 * (p + 1.0)) / half
        beyond, last = math.atan2(z, e), math.log(math.hypot(e, z))
        end = math.pi - beyond
    power = (p - 1.0) / (p + 1.0)  # of z, in x^((p-1)/2)

    def slope(s: float, ln_r: float) -> float:
        # The ends, with their fractional powers, lie at infinite s.
        tail = math.exp(-math.pi * math.sinh(abs(s)))
        near, far = end * tail / (1.0 + tail), end / (1.0 + tail)
        angle, rest = (near, far) if s < 0.0 else (far, near)  # to the end
        rate = near * math.pi * math.cosh(s) / (1.0 + tail)
        if angle < 0.5 * math.pi:
            sin, cos = math.sin(angle), math.cos(angle)
        else:
            sin, cos = math.sin(rest + beyond), -math.cos(rest + beyond)
        root_of_x = (half * math.exp(ln_r) * sin) ** power
        over, under = (damping * p / half * root_of_x, 1.0) if viscous else (damping / half, root_of_x)
        divisor = under + over * sin * cos
        if divisor <= 0.0:
            raise OverflowError
        return -over * cos * cos / divisor * rate

    try:
        return extrapolated(slope) - last
    except OverflowError:
        # Without clipping the balls would not part. Viscoelastic spheres of too small a coefficient part before the end
        # that belongs to e, and only then would stick; by the other laws those of too large a one do.
        return math.inf if viscous else -math.inf


def extrapolated(slope: Callable[[float, float], float]) -> float:
    """The end of a solution from 0, by the classical method of Runge and Kutta with finer and finer steps."""
    rows: list[float] = []
    for level in range(LEVELS):
        count = STEPS << level
        h, y = 2.0 * ENDS / count, 0.0
        for step in range(count):
            y = runge_kutta(slope, -ENDS + step * h, y, h)
        row = [y]
        for order, coarser in enumerate(rows, start=4):
            row.append(row[-1] + (row[-1] - coarser) / (2.0**order - 1.0))
        rows = row
    return rows[-1]


def runge_kutta(f: Callable[[float, Any], Any], time: float, x: Any, h: float) -> Any:
    """A step of length h of the classical method of order 4."""
    k1 = f(time, x)
    k2 = f(time + h / 2, x + h / 2 * k1)
    k3 = f(time + h / 2, x + h / 2 * k2)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(time + h, x + h * k3))


def root(f: Callable[[float], float], guess: float, most: float) -> float:
    """The root of a function that falls from positive to negative values, above 0 and below `most`: by the secant
    between two points about it."""
    low, high = guess, guess
    at_low = at_high = f(guess)
    while at_low <= 0.0:
        high, at_high, low = low, at_low, 0.5 * low
        at_low = f(low)
    while at_high > 0.0:
        low, at_low = high, at_high
        high = min(2.0 * high, 0.5 * (high + most))
        at_high = f(high)
    for _ in range(100):
        if high - low <= 1e-14 * high:
            break
        finite = math.isfinite(at_low) and math.isfinite(at_high)
        middle = low + (high - low) * (at_low / (at_low - at_high) if finite else 0.5)
        value = f(middle)
        if value == 0.0 or not low < middle < high:
            return middle
        # The end that stays counts half, so that it moves next time (Illinois).
        if value > 0.0:
            low, at_low, at_high = middle, value, 0.5 * at_high
        else:
            high, at_high, at_low = middle, value, 0.5 * at_low
    return 0.5 * (low + high)
