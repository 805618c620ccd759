"""Which loss law? The coefficient of restitution of two steel balls over their speed, by each law.

    .venv/bin/python examples/losses/laws.py

sets each law so that two balls of 22 mm, free and alone, that meet at 1 m/s part at 0.9 of it, then lets them meet at
other speeds. It writes out/losses/laws.csv, one row for each run, and out/losses/laws.png.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

import numpy as np
from plots import COLOURS, plt
from support import command_line, ended, nc, parsed, write_rows

RESTITUTION, SPEED = 0.9, 1.0  # m/s
SPEEDS = np.logspace(-3, 1, 41)  # m/s
GAP = 1e-6  # m
FREE = nc.preset("desk") | {"gravity": 0.0, "pendulum.drag": 0.0, "pendulum.model": "linear"}
#: Two contacts of about the same duration at 1 m/s.
CONTACTS = {"Hertz contacts": {}, "linear contacts": nc.power_law(2.5e7)}
STYLES = {
    "kelvinVoigt": (COLOURS[0], "-"),
    "kelvinVoigtNoPull": (COLOURS[0], ":"),
    "huntCrossley": (COLOURS[1], "-"),
    "viscoelastic": (COLOURS[2], "--"),
    "constantRestitution": (COLOURS[3], "-"),
    "rigid": ("black", ":"),
}


def restitution(fmu: nc.Fmu, values: dict, speed: float) -> float:
    """The coefficient of restitution of balls 1 and 2, far from the others, at this speed (m/s)."""
    still, apart = [0.0] * (fmu.balls - 1), [1.0] * (fmu.balls - 2)
    start = {"x_start": [0.0, *still], "v_start": [speed, *still], "contact.gap": [GAP, *apart]}
    end = 0.1 / speed
    v = fmu.simulate(values | start, times=[0.0, end], record=["v"])["v"][-1]
    return float((v[1] - v[0]) / speed)


def main() -> None:
    options = parsed(command_line("The coefficient of restitution over the speed, by each loss law.", "losses"))
    rows = []
    with nc.Fmu(options.fmu) as fmu:
        for contacts, values in CONTACTS.items():
            for law in STYLES:
                if law == "rigid":
                    lossy = {"contact.model": "rigid", "contact.restitution": RESTITUTION}
                else:
                    lossy = nc.damping(law, FREE | values, restitution=RESTITUTION, speed=SPEED, fmu=fmu)
                for speed in SPEEDS:
                    e = restitution(fmu, FREE | values | lossy, speed)
                    rows.append({"contacts": contacts, "law": law, "speed": float(speed), "restitution": e})
    table, picture = options.out / "laws.csv", options.out / "laws.png"
    write_rows(table, rows)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained", sharey=True)
    for axis, contacts in zip(axes, CONTACTS, strict=True):
        for law, (colour, style) in STYLES.items():
            points = [row["restitution"] for row in rows if (row["contacts"], row["law"]) == (contacts, law)]
            axis.semilogx(SPEEDS, points, style, color=colour, label=law)
        axis.set(title=contacts, xlabel="speed at which two balls meet (m/s)")
        axis.grid(alpha=0.3)
    axes[0].set(ylabel="coefficient of restitution", ylim=(0.4, 1.02))
    axes[0].legend(fontsize=8, loc="lower left")
    figure.savefig(picture, dpi=90)
    print(f"{len(rows)} runs: {table}, {picture}")


if __name__ == "__main__":
    ended(main)
