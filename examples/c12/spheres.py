"""ARGESIM's benchmark C12, "Collision Processes in Rows of Spheres", with rigid contacts and with compliant ones.

    python examples/c12/spheres.py [--fmu FILE] [--out FOLDER] [--runs NUMBER]

Four equal spheres at distances a; sphere 1 starts with v0, and each collision has the coefficient of restitution e.
docs/c12.md tells which sentences of the benchmark are public and what stands in for the others. Each result is
compared with one that does not come from the FMU. Writes report.md with its plots into the folder (out/c12).
"""

import math
import sys
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import COLOURS, diagrams
from support import command_line, nc, parsed, tracked

TIMES = np.linspace(0.0, 15.0, 301)  # s
FREE = {"gravity": 0.0, "contact.deadBand": 0.0, "contact.gap": [1.0] * 3, "x_start": [0.0] * 4}
LIMIT = 3 - 2 * math.sqrt(2)  # of e, below which collisions of four spheres can accumulate
MEAN, DEVIATION = 0.5, 0.1  # of e in task 4, within 0 and 1
DURATIONS = 10.0 ** np.arange(-1, -7, -1)  # s, of a compliant contact
SPEEDS = ["v1", "v2", "v3", "v4"]


def start(e: float = 1.0, v0: float = 1.0) -> dict:
    """Start values of the rigid row."""
    return FREE | {"contact.model": "rigid", "contact.restitution": e, "v_start": [v0, 0.0, 0.0, 0.0]}


def collide(e, v0, stop=math.inf) -> tuple[list, list]:
    """The same without the FMU, exact if it is given fractions. `e()` returns the restitution of each collision.
    Returns time, pair and velocities of each collision, and the positions at `stop`."""
    t, x, v, rows = 0 * v0, [0, 1, 2, 3], [v0, 0 * v0, 0 * v0, 0 * v0], []
    while True:
        due = [(t + (x[i + 1] - x[i]) / (v[i] - v[i + 1]), i) for i in range(3) if v[i] > v[i + 1]]
        when, i = min(due, default=(stop, 0))
        if min(when, stop) < math.inf:
            x = [a + b * (min(when, stop) - t) for a, b in zip(x, v, strict=True)]
        if when >= stop:
            return rows, x
        t, x[i + 1], change = when, x[i], (1 + e()) * (v[i] - v[i + 1]) / 2
        v = [*v[:i], v[i] - change, v[i + 1] + change, *v[i + 2 :]]
        rows.append((t, i + 1, *v))


def to_the_end(run: nc.Run, e=None) -> np.ndarray:
    """Steps from collision to collision until none is due; returns the velocities. `e()`: as above."""
    seen = -1
    while (onset := run["t_next"]) < nc.NEVER:
        if e is not None and run["pulses"].sum() > seen:
            seen, run["contact.restitution"] = run["pulses"].sum(), e()
        run.step_to(max(onset, math.nextafter(run.time, math.inf)))
    return run["v"]


def distances(fmu: nc.Fmu, values: dict) -> np.ndarray:
    """y1, y2, y3 (m) over time: the spheres' distances from surface to surface."""
    return -fmu.simulate(values, times=TIMES, record=["overlap"]).stack("overlap")


def task_1(fmu: nc.Fmu, out: Path, tell) -> None:
    """Distances over time, elastic and nearly plastic, and the list of collisions."""
    tell("## 1 Distances over time", "![Distances over time](distances.png)")
    with diagrams(out / "distances.png", 3.4, sharey=True) as axes:
        for e, axis in zip((Fraction(1), Fraction(1, 5)), axes, strict=True):
            rows, x = collide(lambda e=e: e, Fraction(1), Fraction(15))
            y, exact = distances(fmu, start(float(e))), [float(b - a) for a, b in pairwise(x)]
            for i in range(3):
                axis.plot(TIMES, y[:, i], color=COLOURS[i], label=f"y{i + 1}")
            axis.set(title=f"e = {float(e):g}", xlabel="t, s", ylabel="distance, m")
            axis.legend()
            shown = ", ".join(f"{value:.12f}" for value in exact)
            tell(
                f"e = {float(e):g}: {len(rows)} collisions; at 15 s the distances are {shown} m. The FMU differs "
                f"from exact fractions by {np.abs(y[-1] - exact).max():.0e} m."
            )
    table(
        [("t, s", "spheres", *SPEEDS), *((f"{float(t):.9f}", f"{i}-{i + 1}", *v) for t, i, *v in rows)], tell
    )


def task_2(fmu: nc.Fmu, out: Path, tell) -> None:
    """Number of collisions and final velocities over the coefficient of restitution."""
    found, error, others = [], 0.0, 0
    for e in tracked("restitutions", np.linspace(0.0, 1.0, 101)):
        with fmu.start(start(e)) as run:
            v = to_the_end(run)
            found.append((e, run["pulses"].sum(), *v))
        if e > LIMIT:
            rows, _ = collide(lambda e=e: e, 1.0)
            error, others = max(error, np.abs(v - rows[-1][2:]).max()), others + (found[-1][1] != len(rows))
    values = np.array(found)
    with diagrams(out / "restitution.png", 3.4) as (left, right):
        left.semilogy(values[:, 0], values[:, 1], ".", color=COLOURS[0])
        left.set(xlabel="e", ylabel="collisions until none is due")
        for i, name in enumerate(SPEEDS):
            right.plot(values[:, 0], values[:, 2 + i], color=COLOURS[i], label=name)
        right.set(xlabel="e", ylabel="final velocity / v0")
        right.legend()
    tell("## 2 Collisions and final velocities over e", "![Collisions and velocities](restitution.png)")
    shown = [(f"{e:.2f}", count, *(f"{v:.9f}" for v in vs)) for e, count, *vs in found[20::10]]
    table([("e", "collisions", *SPEEDS), *shown], tell)
    tell(
        f"Above e = 3 - 2 sqrt(2) = {LIMIT:.4f} a simulation without the FMU has another number of collisions in "
        f"{others} cases, and its velocities differ by at most {error:.0e}. Below, collisions can accumulate: the "
        "FMU lets such spheres stay together."
    )


def task_3(fmu: nc.Fmu, tell) -> None:
    """Two boundary value problems, solved with the FMU alone."""

    def last(e: float) -> float:
        with fmu.start(start(e)) as run:
            return to_the_end(run)[3] - 0.5

    def first_hit(v0: float) -> float:
        with fmu.start(start(0.2, v0)) as run:
            while not run["pulses"][2]:
                run.step_to(run["t_next"])
            return 5.0 - run.time

    e, v0 = zero(last, 0.3, 0.9), zero(first_hit, 0.5, 2.0)
    tell(
        "## 3 Boundary value problems",
        f"Sphere 4 leaves with v0 / 2 for e = {e:.12f}; exact: 2^(2/3) - 1, difference {e - 2 ** (2 / 3) + 1:.0e}. "
        f"With e = 0.2 it is hit first at 5 s for v0 = {v0:.12f} m/s; exact: 49/45, difference {v0 - 49 / 45:.0e}.",
    )


def zero(function, low: float, high: float) -> float:
    """Where a function that rises is 0, by bisection to the last digit."""
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return low


def task_4(fmu: nc.Fmu, axis, tell, runs: int) -> None:
    """Final velocities if each collision has a restitution of its own, drawn at random."""
    found, error = [], 0.0
    for seed in tracked("random restitutions", range(runs)):
        drawn = np.random.default_rng(seed).normal(MEAN, DEVIATION, 1000).clip(0, 1).tolist()
        with fmu.start(start()) as run:
            found.append(to_the_end(run, iter(drawn).__next__))
        rows, _ = collide(iter(drawn).__next__, 1.0)
        error = max(error, np.abs(found[-1] - rows[-1][2:]).max())
    for i, name in enumerate(SPEEDS):
        axis.hist(np.array(found)[:, i], 40, color=COLOURS[i], alpha=0.6, label=name)
    axis.set(xlabel="final velocity / v0", ylabel="runs")
    axis.legend()
    tell(
        "## 4 Random restitution",
        f"{runs} runs; each collision draws its e from a normal distribution, {MEAN} ± {DEVIATION}, within 0 and 1. "
        f"A simulation without the FMU, with the same numbers, differs by at most {error:.0e}. Left: their "
        "distribution. Right: the next section.",
        "![Distribution of the final velocities; compliant contacts](random.png)",
    )
    columns = zip(SPEEDS, np.mean(found, axis=0), np.std(found, axis=0, ddof=1), strict=True)
    rows = [(name, f"{m:.5f}", f"{s:.5f}", f"± {1.96 * s / math.sqrt(runs):.5f}") for name, m, s in columns]
    table([("", "mean", "standard deviation", "95 % interval of the mean"), *rows], tell)


def compliant(fmu: nc.Fmu, axis, tell) -> None:
    """Task 1 with springs and dampers of the same restitution, and with Hertz contacts, the stiffer the shorter."""
    damped = -math.log(0.2) / math.hypot(math.pi, math.log(0.2))  # ratio of critical damping for e = 0.2
    tell("## Compliant contacts approach the rigid ones")
    for law, e, p, ratio in (("Kelvin-Voigt", 0.2, 1, damped), ("linear", 1, 1, 0), ("Hertz", 1, 1.5, 0)):
        errors, rigid = [], distances(fmu, start(e))
        for t in tracked(law, DURATIONS):
            # Two spheres of 1 kg at 1 m/s; a contact of Hertz lasts 2.94326 times overlap / speed.
            k = 0.5 * (math.pi / t) ** 2 / (1 - ratio**2) if p == 1 else 0.625 / (t / 2.94326) ** 2.5
            values = {"v_start": [1.0, 0, 0, 0], "contact.damping": 2 * ratio * math.sqrt(0.5 * k)}
            errors.append(np.abs(distances(fmu, FREE | nc.power_law(k, p) | values) - rigid).max())
        axis.loglog(DURATIONS, errors, ".-", label=f"{law}, e = {e}")
        tell(f"{law}, e = {e}: contacts of 0.1 s differ by {errors[0]:.1e} m, of 1 µs by {errors[-1]:.1e} m.")
    axis.set(xlabel="duration of a contact, s", ylabel="largest difference in y, m")
    axis.legend()


def table(rows, tell) -> None:
    """Tells a table; its first row is the head."""
    texts = [f"| {' | '.join(map(str, row))} |" for row in rows]
    tell("\n".join([texts[0], "| --- " * len(rows[0]) + "|", *texts[1:]]))


def main() -> int:
    """Runs all tasks."""
    parser = command_line(__doc__.splitlines()[0], "c12")
    parser.add_argument("--runs", type=int, default=1000, help="of task 4")
    options = parsed(parser)
    if options.runs < 2:
        parser.error(f"--runs {options.runs}: at least 2 are needed")
    said = ["# C12 Collision Processes in Rows of Spheres", "Solved with the FMU NewtonsCradle through FMPy."]

    def tell(*paragraphs: str) -> None:
        said.extend(paragraphs)
        print("\n".join(text for text in paragraphs if not text.startswith("![")))

    with nc.build(balls=4, binaries=options.fmu) as fmu:
        task_1(fmu, options.out, tell)
        task_2(fmu, options.out, tell)
        task_3(fmu, tell)
        with diagrams(options.out / "random.png", 3.4) as (left, right):
            task_4(fmu, left, tell, options.runs)
            compliant(fmu, right, tell)
    report = options.out / "report.md"
    report.write_text("\n\n".join(said) + "\n", encoding="utf-8")
    print(f"wrote {report}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
