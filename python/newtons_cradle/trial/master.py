"""A master for every kind of FMU of the cradle: co-simulation and model exchange, FMI 2.0 and 3.0. It can make the
mistakes that tools make, each by its name; `cases` says what they are."""

import math
from bisect import bisect_right
from collections.abc import Callable
from contextlib import suppress
from ctypes import POINTER, c_double
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException

from ..errors import FmuError
from ..fmu import Fmu
from ..run import Run
from ..runge_kutta import runge_kutta
from .cases import Case, Points

Table = dict[str, list[Any]]  #: A result: a column for each name, `time` (s) among them.
Record = Callable[[float], None]  #: Adds a row at a time (s).

EPSILON = 2e-3  # m: with the mistake `epsilon`, smaller indicators do not count
SOON = 1e-6  # s: with the mistake `soon`, time events so soon after an event are missed
LOCATED = 1e-14  # s, within which an event is located
ROUGHLY = 1e-6  # s, within which the mistake `rough` locates it


class Unit:
    """A run with what the master needs of it. Variables of clocks keep their values from the last tick, and are read at
    any time."""

    def __init__(self, run: Run):
        self.run, self.fmu, self.set, description = run, run.slave, run.set, run.fmu.description
        self.sizes = description.numberOfContinuousStates, description.numberOfEventIndicators

    def recorded(self, name: str, wrong: str | None) -> Any:
        """What the master records of a variable: for `der(x[1])` and so on a time derivative, for bytes hexadecimal
        digits."""
        order = name.count("der(")
        if order and name not in self.fmu.variables:
            order = {"order": order - 1}.get(wrong or "", order) or 1
            place = self.fmu.references(name.replace("der(", "").rstrip(")"))
            return self.fmu.getRealOutputDerivatives(place, [order])[0]
        value = self.fmu.get(name)
        return value.hex() if isinstance(value, bytes) else value

    def events(self, wrong: str | None) -> tuple[bool, float]:
        """Goes through Event Mode: whether states have changed, and when the next event is due (s)."""
        changed, again, due = False, True, math.inf
        update = self.fmu.newDiscreteStates if self.run.fmu.fmi2 else self.fmu.updateDiscreteStates
        while again:
            again, _, _, values, defined, time = update()
            changed, due = changed or bool(values), time if defined else math.inf
            again = again and wrong != "once"
        return changed, due

    def states(self) -> Any:
        return self.fmu.vector("getContinuousStates", self.sizes[0])

    def indicators(self, time: float, x: Any) -> Any:
        return self._at(time, x, "getEventIndicators", self.sizes[1])

    def slopes(self, time: float, x: Any) -> Any:
        what = "getDerivatives" if self.run.fmu.fmi2 else "getContinuousStateDerivatives"
        return self._at(time, x, what, self.sizes[0])

    def _at(self, time: float, x: Any, what: str, length: int) -> Any:
        """A vector of the FMU at a time (s) with these states."""
        self.fmu.setTime(time)
        self.fmu.setContinuousStates(np.ascontiguousarray(x).ctypes.data_as(POINTER(c_double)), len(x))
        return self.fmu.vector(what, length)


def interpolated(points: Points, time: float, wrong: str | None = None) -> float:
    """The value of an input at a time (s), linear between its points, at a jump the later value; with the mistake
    `row`, the value of the last point."""
    times, values = zip(*points, strict=True)
    if wrong == "row":
        return float(values[max(bisect_right(times, time) - 1, 0)])
    return float(np.interp(time, times, values))


def misplaced(name: str, wrong: str | None) -> tuple[str, float]:
    """The variable that is set for an input, and the sign that its value gets."""
    return name.replace("[1]", "[2]") if wrong == "element" else name, -1.0 if wrong == "sign" else 1.0


def run(fmu: Fmu, case: Case, wrong: str | None = None) -> Table:
    """Runs the case, correctly or with the mistake `wrong`. If the FMU refuses to go on, the rows end there."""

    def update(_environment: Any, time: float, *_: Any) -> None:
        if not calls and wrong != "after":
            unit.set(
                {place: sign * value for name, value in case.act.items() for place, sign in [misplaced(name, wrong)]}
            )
        calls.append(time)

    table: Table = {name: [] for name in ("time", *case.record)}
    calls: list[float] = []
    modes: dict[str, Any] = {"exchange": case.exchange}
    if case.fmi == 3 and not case.exchange:
        modes |= {"eventModeUsed": case.events, "earlyReturnAllowed": case.early}
        modes["intermediateUpdate"] = update if case.act and wrong != "never" else None

    def record(time: float) -> None:
        for name, values in table.items():
            values.append(time if name == "time" else unit.recorded(name, wrong))

    with fmu.start(initialize=False, **modes) as started, suppress(FMICallException, FmuError):
        unit = Unit(started)
        settings(unit, case, wrong)
        started.initialize()
        if case.exchange:
            integrate(unit, case, wrong, record, case.step / case.parts)
        else:
            steps(unit, case, wrong, record, calls)
    return spoiled(table, case, wrong)


def spoiled(table: Table, case: Case, wrong: str | None) -> Table:
    """The result, with the mistakes that are made when it is written."""
    for name in case.record:
        values = table[name]
        if wrong == "shifted":
            table[name] = [*values[:1], *values[:-1]]
        elif wrong == "next" and name in case.inputs:
            table[name] = [interpolated(case.inputs[name], time) for time in table["time"]]
        elif wrong == "tardy" and name.startswith(("onset.", "release.")):
            table[name] = [*values[:1], *values[:-1]]
        elif wrong == "clock" and name.startswith("release."):  # in the case, that clock never ticks alone
            table[name] = len(values) * values[:1]
        elif wrong == "cut":
            table[name] = [value[: len(values[0])] if isinstance(value, str) else value for value in values]
        elif wrong == "difference" and name.startswith("der("):
            inner = table[name[4:-1]]
            table[name] = [values[0], *(np.diff(inner) / case.step)]
    return table


def settings(unit: Unit, case: Case, wrong: str | None) -> None:
    """Sets the case's settings before initialization, the number of balls in Configuration Mode."""
    arrays = {name: value for name, value in case.settings.items() if name != "n"}
    if "n" in case.settings:
        unit.fmu.resize(case.settings["n"])
    for name, value in arrays.items() if wrong != "reset" else ():
        if wrong == "first":
            unit.set({f"{name}[1]": value[0]})
        else:
            unit.fmu.set(name, value)


def grid(case: Case, wrong: str | None) -> list[float]:
    """The communication points, s."""
    count = round(case.stop / case.step)
    if wrong == "nanoseconds":
        return [k * round(case.step * 1e9) / 1e9 for k in range(count + 1)]
    if wrong == "accumulated":
        return list(accumulate([0.0, *count * [case.step]]))
    return [k * case.step for k in range(count + 1)]


def steps(unit: Unit, case: Case, wrong: str | None, record: Record, calls: list[float]) -> None:
    """Co-simulation: steps from point to point, and records at each."""
    points = grid(case, wrong)

    def give(time: float, end: float) -> None:
        for name, values in case.inputs.items():
            shift = {"ahead": end - time, "behind": -case.step, "first": -time}.get(wrong or "", 0.0)
            value = interpolated(values, time + shift, wrong)
            name, sign = misplaced(name, wrong)
            unit.set({name: sign * value})
            if case.slopes and wrong not in ("held", "first"):
                of = (time - 1e-3, time) if wrong == "left" else (time, end)
                slope = (interpolated(values, of[1]) - interpolated(values, of[0])) / (of[1] - of[0])
                unit.fmu.setRealInputDerivatives(unit.fmu.references(name), [1], [sign * slope])

    def step(time: float, end: float) -> None:
        begin = time
        while time < end:
            if not (wrong == "stale" and time > begin):
                give(time, end)
            told = unit.fmu.doStep(time, case.step if wrong == "lengths" else end - time)
            needed, _, early, reached = told or (False, False, False, end)
            time = reached if early and wrong != "past" else end
            if needed and wrong != "ignored":
                unit.fmu.enterEventMode()
                unit.events(wrong)
                unit.fmu.enterStepMode()
            if calls and wrong == "after":
                unit.set(case.act)

    if case.events:
        unit.events(wrong)
        unit.fmu.enterStepMode()
    record(points[0])
    for time, end in pairwise(points):
        if case.trial and abs(time - case.trial[0]) < case.step / 2:
            saved = unit.run.save()
            unit.set(case.trial[1])
            step(time, end)
            if wrong == "anew":
                unit.fmu.reset()
                unit.run.initialize(time)
            elif wrong != "twice":
                unit.run.load(saved)
            if wrong == "kept":
                unit.set(case.trial[1])
            step(time, (time + end) / 2)
            time = (time + end) / 2
        step(time, end)
        record(end)


def integrate(unit: Unit, case: Case, wrong: str | None, record: Record, longest: float) -> None:
    """Model exchange by the Runge-Kutta method of order 4, with steps of `longest` (s), or at most so long if the case
    has a tolerance."""
    jumps = sorted({time for points in case.inputs.values() for time, _ in points})
    blind = wrong in ("late", "soon", "epsilon", "timed", "never")  # ignores what the FMU asks for after a step

    def inputs() -> None:
        for name, points in case.inputs.items():
            place, sign = misplaced(name, wrong)
            unit.set({place: sign * interpolated(points, 0.0 if wrong == "first" else time, "row")})

    def step(h: float) -> Any:
        return runge_kutta(unit.slopes, time, x, h)

    time, h, due, fresh = 0.0, longest, math.inf, False
    inputs()
    x = unit.states()
    if wrong != "before":
        _, due = unit.events(wrong)
    unit.fmu.enterContinuousTimeMode()
    record(time)
    x = x if wrong == "states" else unit.states()
    scale = np.ones(len(x)) if wrong == "ones" else unit.fmu.vector("getNominalsOfContinuousStates", len(x))
    z = unit.indicators(time, x)
    for end in grid(case, None)[1:]:
        anchor = x
        while time < end:
            dated = math.inf if wrong == "never" else min([due, *(jump for jump in jumps if jump > time)])
            stop = end if wrong == "late" else min(end, dated)
            h = min(4 * h, longest)
            if case.tolerance:
                h = controlled(unit.slopes, time, x, min(h, stop - time), scale * case.tolerance)
            taken = stop - time if time + h * (1 + 1e-9) > stop else h
            moved = step(taken)
            now = unit.indicators(time + taken, moved)
            if wrong == "epsilon":
                now = np.where(np.abs(now) < EPSILON, z, now)
            crossed = (z > 0) != (now > 0)
            seen = bool(crossed.any()) and not (wrong == "soon" and fresh) and wrong not in ("timed", "never")
            if seen and wrong != "late":
                low, high = 0.0, taken
                while (
                    high - low > (ROUGHLY if wrong == "rough" else LOCATED)
                    and low < (middle := (low + high) / 2) < high
                ):
                    part = (z > 0) != (unit.indicators(time + middle, step(middle)) > 0)
                    crosses = part[crossed].any() and wrong != "epsilon"
                    low, high = (low, middle) if crosses else (middle, high)
                taken, stop, moved = high, time + high, step(high)
            x = moved
            time = stop if taken == stop - time else time + taken
            unit.indicators(time, x)
            asked, _ = unit.fmu.completedIntegratorStep()
            last = wrong == "late" and time == end
            asked = (asked and not blind) or (last and (seen or due < time) if wrong == "late" else seen)
            if asked or (time >= dated and wrong != "late"):
                unit.fmu.enterEventMode()
                inputs()
                changed, due = unit.events(wrong)
                unit.fmu.enterContinuousTimeMode()
                if wrong == "lost" and not changed and time in jumps:
                    x = anchor
                elif wrong != "states":
                    x = unit.states()
                z, fresh, h = unit.indicators(time, x), True, longest
                if wrong == "soon" and due < time + SOON:
                    due = math.inf
            elif wrong != "late" or time == end:
                z, fresh = now, False
        record(time)


def controlled(f: Callable[[float, Any], Any], time: float, x: Any, h: float, allowed: Any) -> float:
    """The length (s), at most h, of a step whose error, estimated with two half steps, is at most `allowed` for each
    state."""
    while True:
        half = runge_kutta(f, time, x, h / 2)
        error = np.abs(runge_kutta(f, time, x, h) - runge_kutta(f, time + h / 2, half, h / 2)) / allowed
        if error.max() <= 1 or h < 1e-12:
            return h
        h *= max(0.2, 0.9 * float(error.max()) ** -0.2)
