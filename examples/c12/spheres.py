"""ARGESIM's benchmark C12, "Collision Processes in Rows of Spheres", with rigid contacts and with compliant ones.

    python examples/c12/spheres.py [--fmu FILE] [--out FOLDER]

Four equal spheres at distances a; sphere 1 starts with v0, and each collision has the coefficient of restitution e.
docs/makers/c12.md tells which sentences of the benchmark are public and what stands in for the others. Each result is
compared with one that does not come from the FMU. Writes report.md with its plots into the folder (out/c12).
"""

import math
import sys
from contextlib import ExitStack
from fractions import Fraction
from itertools import chain
from pathlib import Path

import numpy as np

sys.path += [str(Path(__file__).resolve().parents[2] / name) for name in ("examples/paper", "exact-rows")]

from plots import diagrams
from rigid import impacts
from support import command_line, nc, parsed, tracked

TIMES = np.linspace(0.0, 15.0, 301)  # s
FREE = {"gravity": 0.0, "contact.deadBand": 0.0, "contact.gap": [1.0] * 3, "x_start": [0.0] * 4}
LIMIT = 3 - 2 * math.sqrt(2)  # of e, below which collisions of four spheres can accumulate
MEAN, DEVIATION, RUNS = 0.5, 0.1, 1000  # of e in task 4, within 0 and 1
DURATIONS = 10.0 ** np.arange(-1, -7, -1)  # s, of a compliant contact
SPEEDS = ["v1", "v2", "v3", "v4"]


def start(e=1.0, v0=1.0) -> dict:
    """Start values of the rigid row."""
    return FREE | {"contact.model": "rigid", "contact.restitution": float(e), "v_start": [v0, 0.0, 0.0, 0.0]}


def collisions(e, one=1.0) -> list[tuple]:
    """The collisions of the row for v0 = 1, computed without the FMU in numbers of the type of `one`: time, pair,
    places and velocities after each. `e()` returns the restitution of a collision."""
    return [*impacts([one] * 4, [0 * one] * 4, [one, 0 * one, 0 * one, 0 * one], [one] * 3, e)]


def to_the_end(fmu: nc.Fmu, values: dict, e=None) -> tuple[np.ndarray, int]:
    """Steps from collision to collision until none is due; returns the velocities and the number of collisions. `e()`:
    the restitution of the next collision; if None, as in `values`."""
    seen = -1
    with fmu.start(values) as run:
        while (onset := run["t_next"]) < nc.NEVER:
            if e is not None and run["pulses"].sum() > seen:
                seen, run["contact.restitution"] = run["pulses"].sum(), e()
            run.step_to(max(onset, math.nextafter(run.time, math.inf)))
        return run["v"], run["pulses"].sum()


def distances(fmu: nc.Fmu, values: dict) -> np.ndarray:
    """y1, y2, y3 (m) over time: the spheres' distances from surface to surface."""
    return -fmu.simulate(values, times=TIMES, record=["overlap"])["overlap"]


def table(*rows) -> str:
    """A table in Markdown; the first row is the head."""
    head, *texts = [[f"{cell:.9f}" if isinstance(cell, float) else str(cell) for cell in row] for row in rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *texts))


def task_1(fmu: nc.Fmu, axes):
    """Distances over time, elastic and nearly plastic, and the list of collisions."""
    yield "## 1 Distances over time\n\n![Distances over time](distances.png)"
    for e, axis in zip((Fraction(1), Fraction(1, 5)), axes, strict=True):
        rows, y = collisions(lambda e=e: e, Fraction(1)), distances(fmu, start(e))
        t, _, x, v = rows[-1]
        exact = (1 + np.diff(x + v * (15 - t))).astype(float)
        axis.plot(TIMES, y, label=["y1", "y2", "y3"])
        axis.set(title=f"e = {float(e):g}", xlabel="t, s", ylabel="distance, m")
        shown, error = ", ".join(f"{value:.12f}" for value in exact), np.abs(y[-1] - exact).max()
        yield f"""e = {float(e):g}: {len(rows)} collisions; at 15 s the distances are {shown} m.
The FMU differs from exact fractions by {error:.0e} m."""
    rows = [[float(t), f"{i}-{i + 1}", *map(float, v)] for t, i, _, v in rows]
    yield table(["t, s", "spheres", *SPEEDS], *rows)


def task_2(fmu: nc.Fmu, axes):
    """Number of collisions and final velocities over the coefficient of restitution."""
    restitutions = np.linspace(0.0, 1.0, 101)
    found = {e: to_the_end(fmu, start(e)) for e in tracked("restitutions", restitutions)}
    pairs = [(run, collisions(lambda e=e: e)) for e, run in found.items() if e > LIMIT]
    others = sum(count != len(rows) for (_, count), rows in pairs)
    error = max(np.abs(v - rows[-1][3]).max() for (v, _), rows in pairs)
    axes[0].semilogy(restitutions, [count for _, count in found.values()], ".")
    axes[0].set(xlabel="e", ylabel="collisions until none is due")
    axes[1].plot(restitutions, [v for v, _ in found.values()], label=SPEEDS)
    axes[1].set(xlabel="e", ylabel="final velocity / v0")
    yield "## 2 Collisions and final velocities over e\n\n![Collisions and velocities](restitution.png)"
    rows = ([f"{e:.2f}", count, *v] for e, (v, count) in [*found.items()][20::10])
    yield table(["e", "collisions", *SPEEDS], *rows)
    yield f"""Above e = 3 - 2 sqrt(2) = {LIMIT:.4f} a simulation without the FMU has another number of collisions
in {others} cases, and its velocities differ by at most {error:.0e}. Below, collisions can accumulate: the FMU lets
such spheres stay together."""


def task_3(fmu: nc.Fmu):
    """Two boundary value problems, solved with the FMU alone."""

    def first_hit(v0: float) -> float:
        pulses = fmu.simulate(start(0.2, v0), times=[0.0, 15.0], record=["v"]).pulses
        return pulses[pulses["contact"] == 3]["onset"][0]

    def zero(function, low: float, high: float) -> float:
        """The zero of a rising function, by bisection to the last digit."""
        while low < (middle := (low + high) / 2) < high:
            low, high = (middle, high) if function(middle) < 0 else (low, middle)
        return low

    e = zero(lambda e: to_the_end(fmu, start(e))[0][3] - 0.5, 0.3, 0.9)
    v0 = zero(lambda v0: 5.0 - first_hit(v0), 0.5, 2.0)
    yield f"""## 3 Boundary value problems

Sphere 4 leaves with v0 / 2 for e = {e:.12f}; exact: 2^(2/3) - 1, difference {e - 2 ** (2 / 3) + 1:.0e}.
With e = 0.2 it is hit first at 5 s for v0 = {v0:.12f} m/s; exact: 49/45, difference {v0 - 49 / 45:.0e}."""


def task_4(fmu: nc.Fmu, axis):
    """Final velocities if each collision has a restitution of its own, drawn at random."""
    found, errors = [], []
    for seed in tracked("random restitutions", range(RUNS)):
        drawn = np.random.default_rng(seed).normal(MEAN, DEVIATION, 1000).clip(0, 1).tolist()
        found.append(to_the_end(fmu, start(), iter(drawn).__next__)[0])
        errors.append(np.abs(found[-1] - collisions(iter(drawn).__next__)[-1][3]).max())
    axis.hist(np.array(found), 40, histtype="stepfilled", alpha=0.6, label=SPEEDS)
    axis.set(xlabel="final velocity / v0", ylabel="runs")
    yield f"""## 4 Random restitution

{RUNS} runs; each collision draws its e from a normal distribution, {MEAN} ± {DEVIATION}, within 0 and 1. A simulation
without the FMU, with the same numbers, differs by at most {max(errors):.0e}. Left: their distribution. Right: the next
section.

![Distribution of the final velocities; compliant contacts](random.png)"""
    deviation = np.std(found, axis=0, ddof=1)
    columns = zip(SPEEDS, np.mean(found, axis=0), deviation, 1.96 * deviation / math.sqrt(RUNS), strict=True)
    yield table(["", "mean", "standard deviation", "95 % interval of the mean, ±"], *columns)


def compliant(fmu: nc.Fmu, axis):
    """Task 1 with springs and dampers of the same restitution, and with Hertz contacts: the shorter the contacts, the
    closer to rigid ones."""
    damped = -math.log(0.2) / math.hypot(math.pi, math.log(0.2))  # ratio of critical damping for e = 0.2
    yield "## Compliant contacts approach the rigid ones"
    for law, e, p, ratio in (("Kelvin-Voigt", 0.2, 1, damped), ("linear", 1, 1, 0), ("Hertz", 1, 1.5, 0)):
        errors, rigid = [], distances(fmu, start(e))
        for t in tracked(law, DURATIONS):
            # Two spheres of 1 kg at 1 m/s; a contact of Hertz lasts 2.94326 times overlap / speed.
            k = 0.5 * (math.pi / t) ** 2 / (1 - ratio**2) if p == 1 else 0.625 / (t / 2.94326) ** 2.5
            values = {"v_start": [1.0, 0, 0, 0], "contact.damping": 2 * ratio * math.sqrt(0.5 * k)}
            errors.append(np.abs(distances(fmu, FREE | nc.power_law(k, p) | values) - rigid).max())
        axis.loglog(DURATIONS, errors, ".-", label=f"{law}, e = {e}")
        yield f"{law}, e = {e}: contacts of 0.1 s differ by {errors[0]:.1e} m, of 1 µs by {errors[-1]:.1e} m."
    axis.set(xlabel="duration of a contact, s", ylabel="largest difference in y, m")


def main() -> None:
    """Runs all tasks."""
    options = parsed(command_line(__doc__.splitlines()[0], "c12"))
    said = ["# C12 Collision Processes in Rows of Spheres", "Solved with the FMU NewtonsCradle through FMPy."]
    with ExitStack() as stack:
        fmu = stack.enter_context(nc.build(balls=4, binaries=options.fmu))
        paths = (options.out / f"{name}.png" for name in ("distances", "restitution", "random"))
        y, v, (left, right) = (stack.enter_context(diagrams(path, 3.4)) for path in paths)
        said += chain(task_1(fmu, y), task_2(fmu, v), task_3(fmu), task_4(fmu, left), compliant(fmu, right))
        for axis in (*y, v[1], left, right):
            axis.legend()
    report = options.out / "report.md"
    report.write_text("\n\n".join(said) + "\n", encoding="utf-8")
    print(f"wrote {report}")


if __name__ == "__main__":
    main()
