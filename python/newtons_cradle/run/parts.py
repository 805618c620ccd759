"""Makes long steps in parts, so that Python can handle signals between them.

With constant inputs, the trajectory does not depend on communication points, to the last bit. Only means and peaks over
the last step do, which are therefore combined from the parts.
"""

import math
from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..pulses import Array
from .calls import Access
from .model import Values

if TYPE_CHECKING:
    from ..fmu import Fmu
    from .instance import Run

FIRST = 1.0  # s, the first part for five balls: less than a millisecond of computing
PROMPT = 0.1  # s, what a call may take
GROWTH = 4.0  # from one part to the next, while calls are short
METHOD, DRIVEN = "solver.method", 1  # the method whose trajectory does not depend on communication points
SELECTED, LAST_STEP = "derivatives.of", ("lastStep", 2)  # in FMI 3.0
MEANS, PEAKS = ("F_mean", "F_support_mean"), ("F_peak",)
NONE = math.inf
NOTHING: Mapping[str, float] = {}


class Parts:
    """`longest`: how long a part may be, s. `means`: means and peaks over a last step that was made in parts, by
    name."""

    def __init__(self, fmu: "Fmu", special: bool):
        """`special`: event mode, model exchange and so on, where steps are never made in parts."""
        self.means: Mapping[str, float] = NOTHING
        self.longest = NONE
        if not special and fmu.is_cradle and fmu.built_with(METHOD) == DRIVEN:
            self.longest = FIRST * min(1.0, (5.0 / max(fmu.balls, 1)) ** 2)

    def end(self) -> None:
        """Makes no steps in parts from now on: something else depends on the steps."""
        self.longest = NONE

    def note(self, values: Values) -> None:
        """Ends the parts if one of these values makes results depend on them: another solution method, which starts
        anew at communication points; the slope of an input; derivatives over the last step."""
        of_step = values.get(SELECTED) in LAST_STEP
        if of_step or any(name == METHOD or name.startswith("der(") for name in values):
            self.end()

    def slow(self, h: float, seconds: float) -> None:
        """Shortens the parts after a step of `h` (s) that took this many seconds, too many."""
        if self.longest < NONE:
            self.longest = h * PROMPT / seconds

    def step(self, run: "Run", end: float) -> None:
        """Makes a step to `end` (s) in parts. If it is interrupted, means and peaks are those of the last part."""
        self.means, begin = NOTHING, run.time
        names, peaks = run.fmu.of_last_step
        access: Access = run._calls.access(names)
        sums: Any = 0.0
        while run.time < end:
            before, rest = run.time, end - run.time
            # Halves rather than leave a tiny last part.
            part = rest if rest <= self.longest else min(self.longest, rest / 2)
            after = end if part == rest or before + part == before else before + part
            began = perf_counter()
            run._single(length(before, after), after)
            if perf_counter() - began < PROMPT / GROWTH:
                self.longest = max(self.longest, GROWTH * part)
            run._done(access.read())
            values = np.array(access.values())
            # The sum of means times lengths, and the largest peak.
            found = np.where(peaks, values, values * (run.time - before))
            sums = np.where(peaks, np.maximum(sums, found), sums + found)
        self.means = dict(zip(names, np.where(peaks, sums, sums / (end - begin)).tolist(), strict=True))


def of_last_step(fmu: "Fmu") -> tuple[tuple[str, ...], Array]:
    """The means and peaks of a cradle over its last step, by name, and which of them are peaks."""
    known = [base for base in (*MEANS, *PEAKS) if base in fmu.arrays or base in fmu.variables]
    names = tuple(name for base in known for name in fmu.elements(base))
    return names, np.array([name.startswith(PEAKS) for name in names])


def length(begin: float, end: float) -> float:
    """The length (s) of a step that ends exactly at `end`: begin + length == end."""
    h = end - begin
    while begin + h < end:
        h = math.nextafter(h, math.inf)
    while begin + h > end:
        h = math.nextafter(h, -math.inf)
    return h
