"""Start values: the presets of the command line, the paper's experiments, and parts to combine.

Each function returns a dict of start values by variable name, in SI units. Merge and change them freely:
`figure5(dead_band=0) | {"pendulum.drag": 0.01}`. The numbers of the presets are in their parameter files.
"""

from collections.abc import Sequence
from typing import Any

from . import files
from .errors import MOST_BALLS, InvalidValue, did_you_mean, number, whole
from .run.model import Preset

Start = dict[str, Any]


def presets() -> list[str]:
    """Names of the presets, as `cradle-fmu build --preset` takes them."""
    return list(files.presets())


def preset(name: str) -> Preset:
    """Start values of a preset, `x_start[1]` and so on for arrays. Raises InvalidValue, which names the presets.

    The number of balls belongs to the FMU; the number of elements of `x_start` is the one that the preset needs. FMPy's
    `simulate_fmu` takes numbers only: give it `fmu.settings(preset("desk"))`.
    """
    known = files.presets()
    if name not in known:
        raise InvalidValue(f"there is no preset {name!r}; allowed: {', '.join(known)}{did_you_mean(str(name), known)}")
    values = Preset()
    for variable, value in known[name].items():
        values |= vector(variable, value) if isinstance(value, list) else {variable: value}
    del values["balls"]
    return values


def power_law(k: float, p: float = 1.0, dead_band: float = 0.0) -> Start:
    """Contacts F = k overlap^p, k in N/m^p, p from 1 to 10; `dead_band` in m, not negative. Raises InvalidValue."""
    return {
        "contact.model": "powerLaw",
        "contact.stiffness": number("k", k, "N/m^p", positive=True),
        "contact.overlapRef": 1.0,
        "contact.exponent": number("p", p, least=1.0, most=10.0),
        "contact.deadBand": number("dead_band", dead_band, "m", least=0.0),
    }


def lifted(left: int, right: int = 0, *, n: int = 5, amplitude: float = 0.1) -> Start:
    """`left` of `n` balls lifted to the left and `right` to the right by `amplitude` (m), at rest. Raises
    InvalidValue."""
    whole("left", left, 0, whole("n", n, 1, MOST_BALLS))
    whole("right", right, 0, n - left)
    number("amplitude", amplitude, "m", least=0.0)
    x = [-amplitude] * left + [0.0] * (n - left - right) + [amplitude] * right
    return vector("x_start", x) | vector("v_start", [0.0] * n)


def chain(p: float, strikers: int, *, n: int = 5) -> Start:
    """Free chain: no gravity, balls of 1 kg exactly in touch, F = overlap^p, strikers at 1 m/s. Raises InvalidValue."""
    whole("strikers", strikers, 0, whole("n", n, 1, MOST_BALLS))
    struck = vector("x_start", [0.0] * n) | vector("v_start", [1.0] * strikers + [0.0] * (n - strikers))
    return {"gravity": 0.0, "ball.mass": 1.0} | power_law(1.0, p) | struck


def figure5(dead_band: float | None = None) -> Start:
    """Figures 4 and 5, Table 1: two of five balls lifted; `dead_band` (m) instead of the paper's."""
    band = preset("figure5")["contact.deadBand"] if dead_band is None else dead_band
    return preset("figure5") | {"contact.deadBand": number("dead_band", band, "m", least=0.0)}


def steel(lifted_balls: int = 1, *, amplitude: float = 0.05) -> Start:
    """The preset `steel`, touching balls with Hertz contacts, with `lifted_balls` lifted by `amplitude` (m). Raises
    InvalidValue."""
    return preset("steel") | lifted(lifted_balls, amplitude=amplitude)


def vector(name: str, values: Sequence[float]) -> Start:
    """The elements of an array by their names, `name[1]` and so on."""
    return {f"{name}[{i}]": value for i, value in enumerate(values, start=1)}
