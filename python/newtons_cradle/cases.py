"""The benchmark for rows of balls: cases with exact results, and a judge that counts a code's correct digits.

    case = nc.benchmark("equal-5-hertz")
    print(case)                       # the row, and how it starts
    print(case.judge(case.run()))     # a result of the FMU; of another code: case.judge({"v": [...], "peak": [...]})

The cases, their model and units: docs/makers/exact-rows.md. The data is CC0.
"""

import functools
import itertools
import json
import math
import operator
from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from .building import build
from .errors import InvalidValue, UnknownName, did_you_mean
from .files import CASES
from .fmu import Fmu
from .materials import spheres
from .run import Result
from .setups import Start, power_law

#: Parameter of each damping law.
COEFFICIENT = dict.fromkeys(("kelvinVoigt", "kelvinVoigtNoPull"), "contact.damping")
COEFFICIENT |= {"huntCrossley": "contact.huntCrossley", "viscoelastic": "contact.relaxationTime"}
COEFFICIENT |= {"constantRestitution": "contact.restitution"}
QUANTITIES = dict.fromkeys(("v", "x"), "one for each ball")
QUANTITIES |= dict.fromkeys(("peak", "onset", "release"), "one for each contact")
QUANTITIES |= {"loss": "in all", "order": ""}
ROUNDING = 1e-13  # of a quantity's scale: within this, a result is exact
SEVERAL = 10.0  # sensitivities that an error may have: start values and results in between are rounded


@dataclass(frozen=True)
class Verdict:
    """How accurate one quantity is. `error`: the largest, in the quantity's unit; `digits`: correct digits relative to
    the scale, at most 16; `within`: each error is within 1e-13 of the scale, or ten times the sensitivity."""

    error: float
    digits: float
    within: bool


@dataclass(frozen=True, repr=False)
class Judgement:
    """Verdicts by quantity, printed as a table, for the quantities that both the result and the case have. `within`:
    there are verdicts, and all are within."""

    verdicts: dict[str, Verdict]

    @property
    def within(self) -> bool:
        return bool(self.verdicts) and all(verdict.within for verdict in self.verdicts.values())

    def __repr__(self) -> str:
        lines = [f"{'quantity':8} {'digits':>6} {'largest error':>14}  as exact as doubles allow"]
        for name, one in self.verdicts.items():
            numbers = " " * 21 if name == "order" else f"{one.digits:6.1f} {one.error:14.2g}"
            lines.append(f"{name:8} {numbers}  {'yes' if one.within else 'no'}")
        return "\n".join(lines)


class Case(SimpleNamespace):
    """One case, with the fields of exact-rows/cases.json. Units are SI; lists have an element for each ball or contact.

    `stiffness`: K of F = K overlap^`exponent`, N/m^p, both None for `restitution`; `law`: `elastic`, a damping law of
    the FMU, or `restitution`; `damping`: its coefficient; `g_over_length`: 1/s2, 0 for free balls; `stop`: s; `order`:
    contacts (from 1) by onset, those at the same time together, or None; `radius`, `material` and `published` may be
    empty. By quantity: `expected`, the exact results, NaN where nothing can be compared; `sensitivity` to a change of
    the start by 1e-16 of itself; `scale` that digits refer to; `agreement` of two independent computations.
    """

    def __repr__(self) -> str:
        return f"Case({self.name}: {self.text}; {self.n} balls, {self.law}, until {self.stop:g} s)"

    @property
    def values(self) -> Start:
        """Start values for an FMU of `n` balls, none of them rounded: masses and stiffnesses are ratios to 1."""
        start: Start = {"gravity": self.g_over_length, "pendulum.length": 1.0, "ball.mass": 1.0}
        start |= {"ball.massRatio": self.mass, "x_start": self.x, "v_start": self.v, "contact.gap": self.gap}
        if self.exponent is None:
            return start | {"contact.model": "rigid", "contact.restitution": self.damping, "contact.deadBand": 0.0}
        start |= power_law(1.0, self.exponent) | {"contact.stiffnessRatio": self.stiffness}
        return start | self._losses

    @property
    def _losses(self) -> Start:
        known = self.law in COEFFICIENT
        return {"contact.dampingLaw": self.law, COEFFICIENT[self.law]: self.damping} if known else {}

    @property
    def spheres(self) -> Start:
        """Start values by radii and material, from which the FMU computes masses and stiffnesses. Raises InvalidValue
        if the case has none."""
        if not self.material:
            raise InvalidValue(f"{self.name} has no radii; allowed: cases with a material")
        density, modulus, ratio = (self.material[name] for name in ("density", "youngModulus", "poissonRatio"))
        solid = spheres(self.radius, density=density, young_modulus=modulus, poisson_ratio=ratio)
        free = ("gravity", "pendulum.length", "x_start", "v_start", "contact.gap")
        return {name: self.values[name] for name in free} | solid | self._losses

    def run(self, fmu: Fmu | None = None) -> Result:
        """Runs the case in one step: in this FMU, or in one that is built for it. Raises FmuError."""
        if fmu is None:
            with build(balls=self.n, fmi=2 if self.n <= 100 else 3) as built:
                return self.run(built)
        return fmu.simulate(self.values, times=[0.0, self.stop], record=["x", "v", "F_peak", "E_total"])

    def judge(self, result: Result | Mapping[str, Any]) -> Judgement:
        """Counts the correct digits of a result. `result`: a `Result` of a run until `stop` with x, v, F_peak and
        E_total recorded; or, from another code, a dict with any of x, v, peak, onset, release and loss as flat lists,
        and `order`, flat or grouped by instant. Quantities that the case has no exact results of are left out. Raises
        InvalidValue, UnknownName."""
        given = self._measured(result) if isinstance(result, Result) else result
        if not isinstance(given, Mapping) or not given:
            raise InvalidValue(f'result: a Result is needed, or a dict as {{"v": [...]}}, not {result!r}')
        verdicts = {}
        for name, values in given.items():
            if name not in QUANTITIES:
                hint = did_you_mean(str(name), QUANTITIES)
                raise UnknownName(f"there is no {name!r}; allowed: {', '.join(QUANTITIES)}{hint}")
            if name in self.expected:
                verdicts[name] = self._verdict(name, values)
            elif name == "order" and self.order:
                right = _in_order(values, self.order)
                verdicts[name] = Verdict(1.0 - right, 16.0 * right, right)
        return Judgement(verdicts)

    def _verdict(self, name: str, values: Any) -> Verdict:
        expected, scale = self.expected[name], self.scale[name]
        try:
            got = np.atleast_1d(np.asarray(values, dtype=float))
        except (TypeError, ValueError):
            raise InvalidValue(f"{name}: a list of numbers is needed, not {values!r}") from None
        if got.shape != expected.shape:
            raise InvalidValue(f"{name}: shape {got.shape}; allowed: {len(expected)}, {QUANTITIES[name]}")
        counts = ~np.isnan(expected)
        if (bad := np.flatnonzero(counts & ~np.isfinite(got))).size:
            raise InvalidValue(f"{name}[{bad[0] + 1}] is {got[bad[0]]}; a finite number is needed")
        errors = np.abs(got - expected)[counts]
        allowed = np.maximum(ROUNDING * scale, SEVERAL * self.sensitivity[name][counts])
        error, within = float(errors.max(initial=0.0)), bool((errors <= allowed).all())
        return Verdict(error, max(0.0, -math.log10(max(error / scale, 1e-16))), within)

    def _measured(self, result: Result) -> dict[str, Any]:
        """The quantities of a run. Raises InvalidValue if it ends at another time, UnknownName."""
        end = float(result["time"][-1])
        if not math.isclose(end, self.stop, rel_tol=1e-12):
            raise InvalidValue(f"result: it ends at {end} s; allowed: {self.stop} s")
        pulses, energy = result.pulses, result["E_total"].ravel()
        of = [pulses[pulses["contact"] == contact] for contact in range(1, self.n)]
        found = {"x": result["x"][-1], "v": result["v"][-1], "peak": result["F_peak"].max(axis=0)}
        found |= {"onset": [own["onset"].min(initial=math.inf) for own in of]}
        found |= {"release": [own["release"].max(initial=-math.inf) for own in of]}
        return found | {"loss": energy[0] - energy[-1], "order": pulses["contact"].tolist()}


def _in_order(values: Any, groups: list[list[int]]) -> bool:
    """Whether contacts close in the order of these groups, within a group in any order. Contacts of no group do not
    count."""
    try:
        got = [operator.index(j) for group in values for j in (group if np.ndim(group) else [group])]
    except (TypeError, ValueError):
        raise InvalidValue(f"order: the form is [[1, 2], [1]] or [1, 2, 1], not {values!r}") from None
    left = iter([contact for contact in got if any(contact in group for group in groups)])
    return all(sorted(itertools.islice(left, len(group))) == group for group in groups) and not [*left]


@functools.cache
def _rows() -> dict[str, dict[str, Any]]:
    return {row["name"]: row for row in json.loads(CASES.read_text(encoding="utf-8"))["cases"]}


def benchmarks() -> list[str]:
    """The names of the benchmark's cases."""
    return list(_rows())


def benchmark(name: str) -> Case:
    """A case of the benchmark. Raises InvalidValue, which names similar ones."""
    rows = _rows()
    if not isinstance(name, str) or name not in rows:
        raise InvalidValue(f"there is no case {name!r}; `nc.benchmarks()` lists them{did_you_mean(str(name), rows)}")
    case = Case(**{"radius": [], "material": {}, "published": {}} | rows[name])
    parts = vars(case).pop("results").items()
    case.scale = {quantity: part["scale"] for quantity, part in parts}
    case.agreement = {quantity: part["agreement"] for quantity, part in parts}
    case.expected = {quantity: np.array(part["value"], dtype=float) for quantity, part in parts}
    case.sensitivity = {quantity: np.array(part["sensitivity"], dtype=float) for quantity, part in parts}
    return case
