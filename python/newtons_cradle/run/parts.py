"""Long steps in parts, so that Python can look for signals between them.

As long as inputs stay the same, the trajectory of the cradle does not depend on communication points, to the last bit.
Only what refers to the last step does: means and peaks. Those of the parts are put together here.
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

FIRST = 1.0  # s of a run of five balls, which the engine computes in less than a millisecond
PROMPT = 0.1  # s, that a call should not take much longer than
GROWTH = 4.0  # from one part to the next, while calls are short
METHOD, DRIVEN = "solver.method", 1  # of those, the one whose trajectory does not depend on communication points
SELECTED, LAST_STEP = "derivatives.of", ("lastStep", 2)  # in FMI 3.0
MEANS, PEAKS = ("F_mean", "F_support_mean"), ("F_peak",)
NONE = math.inf
NOTHING: Mapping[str, float] = {}


class Parts:
    """How long a part may be: `longest` (s). `means`: what the FMU's last step was not all of, by name."""

    def __init__(self, fmu: "Fmu", special: bool):
        """`special`: with event mode, in model exchange and so on, steps are as they are made."""
        self.means: Mapping[str, float] = NOTHING
        self.longest = NONE
        if not special and fmu.is_cradle and fmu.built_with(METHOD) == DRIVEN:
            self.longest = FIRST * min(1.0, (5.0 / max(fmu.balls, 1)) ** 2)

    def end(self) -> None:
        """From now on, steps are as they are made: somebody else sees them."""
        self.longest = NONE

    def note(self, values: Values) -> None:
        """These are set: other methods of solution start anew at communication points, slopes of inputs are changes,
        and derivatives may be asked for that refer to the last step."""
        of_step = values.get(SELECTED) in LAST_STEP
        if of_step or any(name == METHOD or name.startswith("der(") for name in values):
            self.end()

    def slow(self, h: float, seconds: float) -> None:
        """A step of `h` (s) took so many seconds, more than it should."""
        if self.longest < NONE:
            self.longest = h * PROMPT / seconds

    def step(self, run: "Run", end: float) -> None:
        """A step to `end` (s) in parts. Where it does not come to its end, means and peaks are of the last part."""
        self.means, begin = NOTHING, run.time
        names, peaks = run.fmu.of_last_step
        access: Access = run._calls.access(names)
        sums: Any = 0.0
        while run.time < end:
            before, rest = run.time, end - run.time
            # Not a last part that is tiny.
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
    """The length of a step that ends exactly there: begin + length == end."""
    h = end - begin
    while begin + h < end:
        h = math.nextafter(h, math.inf)
    while begin + h > end:
        h = math.nextafter(h, -math.inf)
    return h
