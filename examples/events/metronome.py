"""A controller that acts at the very onset: event mode beside fixed grids, both against an exact answer.

    python examples/events/metronome.py [--fmu FILE] [--out FOLDER] [--stop SECONDS]

A metronome out of a cradle: while an outer ball swings outside, a constant force drives it back, so that the cradle
clicks faster than its pendulums would. The force is switched on when the ball leaves and off when it hits. Switched
exactly there, it does no work in all: on the way back it gives what it took on the way out. Switched a step late, it
does work at each click.

The balls are rigid and lose nothing, so the times of all clicks and the energy have closed forms. Prints a table and
writes it, with a plot of both errors, into the folder (out/events).
"""

import math
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import diagrams
from support import command_line, ended, nc, parsed, print_rows, write_rows

BALLS = 5
MASS, GRAVITY, LENGTH = 1.0, 9.81, 1.962  # kg, m/s2, m
AMPLITUDE, FORCE = 0.1, 0.1  # m, N
STEPS = [1e-2, 1e-3, 1e-4]  # s, of the fixed grids
VALUES = {
    "contact.model": "rigid",
    "contact.restitution": 1.0,
    "contact.deadBand": 0.0,
    "ball.mass": MASS,
    "gravity": GRAVITY,
    "pendulum.length": LENGTH,
    "x_start": [-AMPLITUDE, 0.0, 0.0, 0.0, 0.0],
    "F_ext[1]": FORCE,  # which drives ball 1 back from the start
}


def control(run: nc.Run) -> None:
    """The controller, called after a click: drives back the ball that leaves, and lets the other one go."""
    v, forces = run["v"], [0.0] * BALLS
    forces[0] = FORCE if v[0] < -1e-9 else 0.0
    forces[-1] = -FORCE if v[-1] > 1e-9 else 0.0
    run["F_ext"] = forces


def by_events(run: nc.Run, stop: float) -> tuple[list[float], int]:
    """A master with event mode: each step ends at a click, where the controller acts. Returns the times of the clicks
    (s), and the number of calls of fmi3DoStep and fmi3UpdateDiscreteStates."""
    cradle, clicks, calls, now = run.slave, [], 0, 0.0
    event = True  # initialization ends in event mode
    while event:
        again = True
        while again:
            if cradle.get("onset.clock") and clicks[-1:] != [now]:
                clicks.append(now)
            again, *_ = cradle.updateDiscreteStates()
            calls += 1
        if clicks:
            control(run)
            cradle.updateDiscreteStates()
            calls += 1
        cradle.enterStepMode()
        event = False
        while now < stop and not event:
            event, _, _, now = cradle.doStep(now, stop - now)
            calls += 1
        if event:
            cradle.enterEventMode()
    return clicks, calls


def by_grid(run: nc.Run, stop: float, step: float) -> tuple[list[float], int]:
    """A master with equal steps (s): it sees a click at the end of a step, and acts from then on. Returns the times at
    which it saw clicks (s), and the number of steps."""
    clicks, seen, steps = [], 0, round(stop / step)
    for i in range(1, steps + 1):
        run.step_to(i * step)
        if (count := run["pulses"].sum()) > seen:
            clicks.append(run.time)
            seen = count
            control(run)
    return clicks, steps


def exact() -> tuple[float, float, float]:
    """Exact results: time of the first click and time between clicks, s; energy at a click, J.

    The driven ball swings about `rest`, the position where the force holds it; a click is at the lowest point."""
    frequency = math.sqrt(GRAVITY / LENGTH)
    rest = FORCE / (MASS * frequency**2)
    half = math.acos(rest / (AMPLITUDE + rest)) / frequency
    speed = frequency * math.sqrt((AMPLITUDE + rest) ** 2 - rest**2)
    return half, 2 * half, MASS * speed**2 / 2


def compare(path: Path, stop: float) -> tuple[list[dict], list[np.ndarray]]:
    """All runs, and how late each of their clicks is, s."""
    first, period, energy = exact()
    rows, lates = [], []
    with nc.Fmu(path) as fmu:
        for step in [None, *STEPS]:
            options = {"eventModeUsed": True, "earlyReturnAllowed": True} if step is None else {}
            with fmu.start(VALUES, **options) as run:
                started = time.perf_counter()
                clicks, calls = by_events(run, stop) if step is None else by_grid(run, stop, step)
                seconds = time.perf_counter() - started
                # Only one ball moves: its energy at a click is the total less what it has stored against the force.
                total = run["E_total"] + FORCE * abs(sum(run["x"]))
            lates.append(np.array(clicks) - (first + period * np.arange(len(clicks))))
            row = {"way": "event mode" if step is None else f"grid of {step:g} s", "step": step, "calls": calls}
            row |= {"seconds": seconds, "clicks": len(clicks), "energy_error": abs(total / energy - 1)}
            rows.append(row | {"time_error": np.abs(lates[-1]).max()})
    return rows, lates


def save_plot(path: Path, rows: list[dict], lates: list[np.ndarray]) -> None:
    """The energy error over the cost, and how far off each click is."""
    with diagrams(path, 3.6) as (left, right):
        for row, late, colour in zip(rows, lates, ("#208030", "#c04000", "#0060a0", "#805080"), strict=True):
            left.loglog(row["calls"], max(row["energy_error"], 1e-16), "o", color=colour, label=row["way"])
            right.semilogy(range(1, len(late) + 1), np.maximum(np.abs(late), 1e-16), ".-", color=colour, linewidth=1)
        left.set(xlabel="steps and iterations of events", ylabel="energy error / energy")
        right.set(xlabel="click", ylabel="time error, s")
        left.legend(fontsize=8)


def main() -> None:
    """Runs all ways, and writes table and plot."""
    parser = command_line(__doc__.splitlines()[0], "events", fmu="NewtonsCradle.fmi3.fmu")
    parser.add_argument("--stop", type=float, default=10.0, help="s")
    options = parsed(parser)
    rows, lates = compare(options.fmu, options.stop)
    write_rows(options.out / "metronome.csv", rows)
    print_rows(rows)
    save_plot(options.out / "metronome.png", rows, lates)
    print(f"wrote {options.out / 'metronome.png'}")


if __name__ == "__main__":
    ended(main)
