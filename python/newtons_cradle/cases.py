"""The benchmark for rows of balls: cases with exact results, and how many digits of them a code has right.

    case = nc.benchmark("equal-5-hertz")
    print(case)                       # the row, and how it starts
    print(case.judge(case.run()))     # a result of the FMU; of another code: case.judge({"v": [...], "peak": [...]})

The cases, their model and units: docs/benchmark.md. The data is CC0.
"""

import functools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .errors import InvalidValue, UnknownName, did_you_mean
from .files import CASES
from .fmu import Fmu, build
from .pulses import Array
from .run import Result
from .setups import Start

#: Parameter of each law that has a coefficient.
COEFFICIENT = {
    "kelvinVoigt": "contact.damping",
    "kelvinVoigtNoPull": "contact.damping",
    "huntCrossley": "contact.huntCrossley",
    "viscoelastic": "contact.relaxationTime",
    "restitution": "contact.restitution",
}
PER_CONTACT = ("peak", "onset", "release")
ROUNDING = 1e-13  # of a quantity's scale: within this, a result is exact
SEVERAL = 10.0  # roundings of the start values, or of what is computed from them


@dataclass(frozen=True)
class Verdict:
    """How exact one quantity is. `error`: the largest, in the quantity's unit; `digits`: right ones, of the scale, up
    to 16; `within`: whether each value is within 1e-13 of the scale, or ten times its sensitivity."""

    quantity: str
    error: float
    digits: float
    within: bool


@dataclass(frozen=True, repr=False)
class Judgement:
    """Verdicts by quantity, as far as they were given; printed as a table. `within`: whether all are."""

    verdicts: dict[str, Verdict]

    @property
    def within(self) -> bool:
        return all(verdict.within for verdict in self.verdicts.values())

    def __repr__(self) -> str:
        lines = [f"{'quantity':8} {'digits':>6} {'largest error':>14}  as exact as doubles allow"]
        for one in self.verdicts.values():
            digits, error = ("", "") if one.quantity == "order" else (f"{one.digits:.1f}", f"{one.error:.2g}")
            lines.append(f"{one.quantity:8} {digits:>6} {error:>14}  {'yes' if one.within else 'no'}")
        return "\n".join(lines)


@dataclass(frozen=True, repr=False)
class Case:
    """One case. Units are SI; lists have an element for each ball (`mass`, `x`, `v`) or contact (`stiffness`, `gap`).

    `stiffness`: K of F = K overlap^`exponent`, N/m^p; `law`: `elastic`, a damping law of the FMU, or `restitution`;
    `damping`: its coefficient; `g_over_length`: 1/s2, 0 for free balls; `stop`: s; `expected`: the exact results, NaN
    where nothing can be compared; `sensitivity`: what a change of the start by 1e-16 of itself does to them;
    `scale`: what digits are counted from; `order`: contacts (from 1) by onset, those at the same time together, or
    None; `published`: results of others.
    """

    name: str
    family: str
    text: str
    n: int
    law: str
    exponent: float
    damping: float
    g_over_length: float
    stop: float
    mass: list[float]
    stiffness: list[float]
    gap: list[float]
    x: list[float]
    v: list[float]
    order: list[list[int]] | None
    expected: dict[str, Array] = field(default_factory=dict)
    sensitivity: dict[str, Array] = field(default_factory=dict)
    scale: dict[str, float] = field(default_factory=dict)
    published: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Case({self.name}: {self.text}; {self.n} balls, {self.law}, until {self.stop:g} s)"

    @property
    def values(self) -> Start:
        """Start values for an FMU of `n` balls, none of them rounded: masses and stiffnesses are ratios to 1."""
        start: Start = {"gravity": self.g_over_length, "pendulum.length": 1.0, "ball.mass": 1.0}
        start |= {"ball.massRatio": self.mass, "x_start": self.x, "v_start": self.v}
        start |= {"contact.deadBand": 0.0, "contact.gap": self.gap}
        if self.law == "restitution":
            return start | {"contact.model": "rigid", "contact.restitution": self.damping}
        start |= {"contact.model": "powerLaw", "contact.exponent": self.exponent, "contact.overlapRef": 1.0}
        start |= {"contact.stiffness": 1.0, "contact.stiffnessRatio": self.stiffness}
        if self.law == "elastic":
            return start
        return start | {"contact.dampingLaw": self.law, COEFFICIENT[self.law]: self.damping}

    def run(self, fmu: Fmu | None = None) -> Result:
        """Runs the case in one step: in this FMU, or in one that is built for it. Raises FmuError."""
        if fmu is None:
            with build(balls=self.n, fmi=2 if self.n <= 100 else 3) as built:
                return self.run(built)
        names = ["x", "v", "F_peak", "E_total"]
        return fmu.simulate(self.values, times=[0.0, self.stop], record=names)

    def judge(self, result: Result | Mapping[str, Any]) -> Judgement:
        """How many digits are right. `result`: of a run, until `stop`, with x, v, F_peak and E_total recorded; or what
        another code has, any of the quantities in `expected`, and `order`, as flat lists. Raises InvalidValue,
        UnknownName."""
        given = self._measured(result) if isinstance(result, Result) else result
        if not isinstance(given, Mapping) or not given:
            raise InvalidValue(
                f'result: a Result is needed, or a dict such as {{"v": [...]}}, not {result!r}'
            )
        known = [*self.expected, *(["order"] if self.order else [])]
        verdicts = {}
        for name, values in given.items():
            if name not in known:
                hint = did_you_mean(str(name), known)
                raise UnknownName(f"{self.name} has no {name!r}; allowed: {', '.join(known)}{hint}")
            verdicts[name] = self._in_order(values) if name == "order" else self._verdict(name, values)
        return Judgement(verdicts)

    def _verdict(self, name: str, values: Any) -> Verdict:
        expected, scale = self.expected[name], self.scale[name]
        try:
            got = np.atleast_1d(np.asarray(values, dtype=float))
        except (TypeError, ValueError):
            raise InvalidValue(f"{name}: a list of numbers is needed, not {values!r}") from None
        if got.shape != expected.shape:
            what = {"loss": "in all"}.get(
                name, f"one for each {'contact' if name in PER_CONTACT else 'ball'}"
            )
            allowed = f"allowed: {len(expected)}, {what}"
            raise InvalidValue(f"{name} has the shape {got.shape}; {allowed}")
        counts = ~np.isnan(expected)
        errors = np.abs(got - expected)[counts]
        errors = np.where(np.isnan(errors), math.inf, errors)
        allowed_errors = np.maximum(ROUNDING * scale, SEVERAL * self.sensitivity[name][counts])
        error = float(errors.max(initial=0.0))
        digits = max(0.0, -math.log10(max(error / scale, 1e-16)))
        return Verdict(name, error, digits, bool((errors <= allowed_errors).all()))

    def _in_order(self, values: Any) -> Verdict:
        """Whether the contacts come in order, in any order those that come together. Those in touch at the start do not
        count."""
        groups = self.order or []
        counts = {contact for group in groups for contact in group}
        try:
            got = [int(contact) for group in values for contact in (group if np.ndim(group) else [group])]
        except (TypeError, ValueError):
            raise InvalidValue(f"order: a list of contacts (from 1) is needed, not {values!r}") from None
        got = [contact for contact in got if contact in counts]
        right, place = True, 0
        for group in groups:
            right = right and sorted(got[place : place + len(group)]) == group
            place += len(group)
        right = right and place == len(got)
        return Verdict("order", 0.0 if right else 1.0, 16.0 * right, right)

    def _measured(self, result: Result) -> dict[str, Any]:
        """The quantities of a run. Raises InvalidValue if it ends at another time, UnknownName."""
        end = float(result["time"][-1])
        if not math.isclose(end, self.stop, rel_tol=1e-12):
            raise InvalidValue(f"result: it ends at {end} s; allowed: {self.stop} s")
        pulses, contacts = result.pulses, range(1, self.n)
        of = [pulses[pulses["contact"] == contact] for contact in contacts]
        energy = result["E_total"].ravel()
        found = {
            "x": result["x"][-1],
            "v": result["v"][-1],
            "peak": result["F_peak"].max(axis=0),
            "onset": [own["onset"].min(initial=math.inf) for own in of],
            "release": [own["release"].max(initial=-math.inf) for own in of],
            "loss": energy[0] - energy[-1],
            "order": pulses["contact"].tolist(),
        }
        return {name: found[name] for name in [*self.expected, *(["order"] if self.order else [])]}


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
        hint = did_you_mean(str(name), rows)
        raise InvalidValue(f"there is no case {name!r}; `nc.benchmarks()` lists them{hint}")
    row = rows[name]
    known = {key: row[key] for key in Case.__dataclass_fields__ if key in row}

    def numbers(key: str) -> dict[str, Array]:
        return {quantity: np.array(result[key], dtype=float) for quantity, result in row["results"].items()}

    scale = {quantity: float(result["scale"]) for quantity, result in row["results"].items()}
    return Case(**known, expected=numbers("value"), sensitivity=numbers("sensitivity"), scale=scale)
