"""How much do arcs matter? The rhythm, the speed and the break-up of a steel cradle over the lift, with linear
pendulums and on arcs.

    .venv/bin/python examples/arcs/lifts.py

writes out/arcs/lifts.csv, one row for each run, and out/arcs/lifts.png. A run in which a ball swings beyond 90 degrees
has no row.
"""

import contextlib
import itertools
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import COLOURS, plt
from support import command_line, ended, nc, parsed, write_rows

STEEL = nc.preset("steel")
LENGTH = STEEL["pendulum.length"]
SWING = math.pi * math.sqrt(LENGTH / STEEL["gravity"])  # half a period of the linear pendulum, s
CLICKS = 10
QUANTITIES = {
    "interval": "from click to click, in half periods\nof the linear pendulum",
    "speed": "speed at the first click (m/s)",
    "share": f"energy in the balls that should swing,\nmean over {CLICKS} clicks",
}


def one_run(fmu: nc.Fmu, lifted: int, degrees: float, model: str) -> dict:
    """Lifts balls as far to the side in either model, and lets go. Raises FmuError beyond 90 degrees."""
    start = STEEL | nc.lifted(lifted, amplitude=LENGTH * math.sin(math.radians(degrees)))
    with fmu.start(start | {"pendulum.model": model}) as run:
        run.step_to_onset(before=1e-9)
        first, speed = run.time, run["v[1]"]
        run.step_to(first + 1.5 * SWING)
        # The balls that were hit come back; the first of them strikes hard.
        back = run.pulses[(run.pulses["contact"] == 5 - lifted) & (run.pulses["onset"] > first + 0.5 * SWING)]
        interval = back["onset"][back["impulse"] > 0.5 * back["impulse"].max()][0] - first
    with fmu.start(start | {"pendulum.model": model}) as run:
        shares = []
        for click in range(1, CLICKS + 1):  # midway between clicks, where the swinging balls would be at rest
            run.step_to(first + (click - 0.5) * interval)
            energies = run["E_kinetic"] + run["E_gravity"]
            swinging = energies[-lifted:] if click % 2 else energies[:lifted]
            shares.append(swinging.sum() / run["E_total"])
    values = {"interval": interval / SWING, "speed": speed, "share": sum(shares) / CLICKS}
    return {"lifted": lifted, "degrees": degrees, "model": model} | values


def draw(rows: list[dict], path: Path) -> None:
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    for axis, (quantity, label) in zip(axes, QUANTITIES.items(), strict=True):
        for lifted in sorted({row["lifted"] for row in rows}):
            for model, style in (("linear", "--"), ("circular", "-")):
                points = [row for row in rows if (row["lifted"], row["model"]) == (lifted, model)]
                x, y = ([row[key] for row in points] for key in ("degrees", quantity))
                axis.plot(x, y, style, color=COLOURS[lifted - 1], label=f"{lifted} lifted, {model}")
        axis.set(xlabel="lift (degrees)", ylabel=label)
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=8)
    figure.savefig(path, dpi=110)


def main() -> None:
    options = parsed(command_line("Linear pendulums beside arcs, over the lift.", "arcs"))
    rows = []
    with nc.Fmu(options.fmu) as fmu:
        for case in itertools.product((1, 2, 3), range(2, 81, 2), ("linear", "circular")):
            with contextlib.suppress(nc.FmuError):
                rows.append(one_run(fmu, *case))
    table, picture = options.out / "lifts.csv", options.out / "lifts.png"
    write_rows(table, rows)
    draw(rows, picture)
    print(f"{len(rows)} runs: {table}, {picture}")


if __name__ == "__main__":
    ended(main)
