"""A controller that acts at the very onset: event mode beside fixed grids, both against an exact answer.

    python examples/events/metronome.py [--fmu FILE] [--out FOLDER] [--stop SECONDS]

A metronome out of a cradle: while an outer ball swings outside, a constant force drives it back, so that the cradle
clicks faster than its pendulums would. The force is switched on when the ball leaves and off when it hits. Switched
exactly there, it does no work: it takes on the way out what it gives on the way back. What is late by a step does
work, at each click.

The balls are rigid and lose nothing, so the times of all clicks and the energy have closed forms. Prints a table and
writes it, with a plot of both errors, into the folder (out/events).
"""

import math
import sys
import time
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import diagrams
from support import command_line, parsed, write_rows

RIGID, BALLS = 3, 5
MASS, GRAVITY, LENGTH = 1.0, 9.81, 1.962  # kg, m/s2, m
AMPLITUDE, FORCE = 0.1, 0.1  # m, N
STEPS = [1e-2, 1e-3, 1e-4]  # s, of the fixed grids
VALUES = {
    "contact.model": RIGID,
    "contact.restitution": 1.0,
    "contact.deadBand": 0.0,
    "ball.mass": MASS,
    "gravity": GRAVITY,
    "pendulum.length": LENGTH,
    "x_start": [-AMPLITUDE, 0.0, 0.0, 0.0, 0.0],
}
COLUMNS = ["way", "step", "calls", "seconds", "clicks", "energy_error", "time_error"]


class Cradle(FMU3Slave):
    """One instance, with its variables by name."""

    def __init__(self, folder: str, description, **options) -> None:
        super().__init__(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="metronome",
        )
        self.places = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.calls = 0  # of fmi3DoStep and fmi3UpdateDiscreteStates
        self.instantiate(**options)
        for name, value in VALUES.items():
            if name == "contact.model":
                self.setInt64([self.places[name]], [value])
            else:
                self.setFloat64([self.places[name]], np.atleast_1d(value).tolist())

    def get(self, name: str, count: int = 1) -> list[float]:
        """Elements of a Float64 variable."""
        return self.getFloat64([self.places[name]], count)

    def step(self, begin: float, end: float) -> tuple[bool, float]:
        """A step: whether there is an event, and the time reached."""
        self.calls += 1
        event, _, _, reached = self.doStep(begin, end - begin)
        return event, reached

    def update(self) -> bool:
        """Goes on to the next tick: whether there is one now."""
        self.calls += 1
        return self.updateDiscreteStates()[0]

    def control(self) -> None:
        """The controller, after a click: the ball that leaves is driven back, the other one is let go."""
        v = self.get("v", BALLS)
        forces = [0.0] * BALLS
        forces[0] = FORCE if v[0] < -1e-9 else 0.0
        forces[-1] = -FORCE if v[-1] > 1e-9 else 0.0
        self.setFloat64([self.places["F_ext"]], forces)

    def begin(self) -> None:
        """Through initialization, with ball 1 driven back from the start."""
        self.enterInitializationMode(startTime=0.0)
        self.setFloat64([self.places["F_ext"]], [FORCE, *[0.0] * (BALLS - 1)])
        self.exitInitializationMode()


def by_events(cradle: Cradle, stop: float) -> list[float]:
    """A master with event mode: a step ends at the click, where the controller acts. The times of the clicks, s."""
    clicks, now = [], 0.0

    def events() -> None:
        again = True
        while again:
            if cradle.getClock([cradle.places["onset.clock"]])[0] and clicks[-1:] != [now]:
                clicks.append(now)
            again = cradle.update()
        if clicks:
            cradle.control()
            cradle.update()
        cradle.enterStepMode()

    cradle.begin()
    events()
    while now < stop:
        event, now = cradle.step(now, stop)
        if event:
            cradle.enterEventMode()
            events()
    return clicks


def by_grid(cradle: Cradle, stop: float, step: float) -> list[float]:
    """A master with steps of one length: it sees at the end of a step that there was a click, and acts from then on."""
    clicks, seen = [], 0
    cradle.begin()
    for i in range(round(stop / step)):
        now = (i + 1) * step
        cradle.step(i * step, now)
        count = sum(cradle.getUInt64([cradle.places["pulses"]], BALLS))
        if count > seen:
            clicks.append(now)
            seen = count
            cradle.control()
    return clicks


def exact() -> tuple[float, float, float]:
    """Time of the first click and time between clicks, s; energy in a click, J.

    The driven ball swings about the place `rest`, where the force holds it; a click is at the lowest point."""
    frequency = math.sqrt(GRAVITY / LENGTH)
    rest = FORCE / (MASS * frequency**2)
    half = math.acos(rest / (AMPLITUDE + rest)) / frequency
    speed = frequency * math.sqrt((AMPLITUDE + rest) ** 2 - rest**2)
    return half, 2 * half, MASS * speed**2 / 2


def compare(path: Path, stop: float) -> list[dict]:
    """All runs, each with its energy error and how far off each click is."""
    folder = extract(str(path))
    description = read_model_description(folder, validate=False)
    first, period, energy = exact()
    rows = []
    for step in [None, *STEPS]:
        options = {"eventModeUsed": True, "earlyReturnAllowed": True} if step is None else {}
        cradle = Cradle(folder, description, **options)
        started = time.perf_counter()
        clicks = by_events(cradle, stop) if step is None else by_grid(cradle, stop, step)
        seconds = time.perf_counter() - started
        # All that moves beside the force is one ball: its energy in a click is the total less what it has stored
        # against the force.
        total = cradle.get("E_total")[0] + FORCE * abs(sum(cradle.get("x", BALLS)))
        late = [told - (first + i * period) for i, told in enumerate(clicks)]
        row = {
            "way": "event mode" if step is None else f"grid of {step:g} s",
            "step": step,
            "calls": cradle.calls,
            "seconds": seconds,
            "clicks": len(clicks),
            "energy_error": abs(total / energy - 1),
            "time_error": max(map(abs, late)),
            "late": late,
        }
        rows.append(row)
        cradle.terminate()
        cradle.freeInstance()
    return rows


def save_plot(path: Path, rows: list[dict]) -> None:
    """The energy error over the cost, and how far off each click is."""
    with diagrams(path, 3.6) as (left, right):
        for row, colour in zip(rows, ("#208030", "#c04000", "#0060a0", "#805080"), strict=True):
            left.loglog(row["calls"], max(row["energy_error"], 1e-16), "o", color=colour, label=row["way"])
            numbers = range(1, len(row["late"]) + 1)
            right.semilogy(numbers, np.maximum(np.abs(row["late"]), 1e-16), ".-", color=colour, linewidth=1)
        left.set(xlabel="steps and iterations of events", ylabel="energy error / energy")
        right.set(xlabel="click", ylabel="time error, s")
        left.legend(fontsize=8)


def main() -> int:
    """Runs all of it."""
    parser = command_line(__doc__.splitlines()[0], "events", fmu="NewtonsCradle.fmi3.fmu")
    parser.add_argument("--stop", type=float, default=10.0, help="s")
    options = parsed(parser)
    rows = compare(options.fmu, options.stop)
    write_rows(options.out / "metronome.csv", [COLUMNS, *([row[name] for name in COLUMNS] for row in rows)])
    print(f"{'way':18} {'calls':>7} {'s':>6} {'clicks':>6} {'energy error':>12} {'time error, s':>13}")
    for row in rows:
        print(
            f"{row['way']:18} {row['calls']:7d} {row['seconds']:6.2f} {row['clicks']:6d} "
            f"{row['energy_error']:12.1e} {row['time_error']:13.1e}"
        )
    save_plot(options.out / "metronome.png", rows)
    print(f"wrote {options.out / 'metronome.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
