"""Hertz: steel balls that touch at rest move apart at the first impact, as experiments show."""

import numpy as np
from plots import COLOURS, Column, Plot, Strip, Trace, View, forces
from support import Check, Fmus, Outcome, at_least, conserved, nc, run_script, save_csv, within

AMPLITUDE = 0.05  # m
SPEED = AMPLITUDE * np.sqrt(5.0)  # m/s, amplitude times sqrt(g/L)
# Velocities after one ball of five has struck, over its speed: chain with p = 1.5 in quadruple precision.
OUTCOME = [-0.071085017086, -0.030273764097, -0.014463629032, 0.127044986068, 0.988777424147]
STOP = 8.0  # s
DEAD_BAND = 2e-5  # m, more than the largest overlap of 6 µm times 1.4716
NAMES = [f"{what}[{i}]" for what in "xvF" for i in range(1, 6) if (what, i) != ("F", 5)]


def run(fmus: Fmus, out) -> Outcome:
    """The struck chain by itself, then a cradle of steel balls, touching and with a dead band."""
    touching = case(fmus.five, nc.steel(amplitude=AMPLITUDE), "Hertz, steel balls that touch")
    apart = case(
        fmus.five, nc.steel(amplitude=AMPLITUDE) | {"contact.deadBand": DEAD_BAND}, "Hertz with a dead band"
    )
    save_csv(out / "hertz.csv", touching["macro"].samples)
    save_csv(out / "hertz_pulses.csv", touching["macro"].pulses)
    return Outcome(
        checks(chain(fmus.five), touching, apart), [plot_impact(touching, apart), plot_swing(touching, apart)]
    )


def chain(fmu: nc.Fmu) -> np.ndarray:
    """Velocities of a free chain of order 1.5 after its pulses, over the striker's speed."""
    with fmu.start(nc.chain(1.5, strikers=1)) as free:
        free.step_to(20.0)
        return np.array([free.get(f"v[{i}]") for i in range(1, 6)])


def case(fmu: nc.Fmu, values: dict, label: str) -> dict:
    """A few swings, and the first impact in microsecond steps."""
    macro = fmu.simulate(values, stop=STOP, progress=nc.Progress(label))
    with fmu.start(values) as run:
        onset, micro = run.zoom(span=1.7e-3, step=1e-6, record=NAMES, before=5e-5)
        outcome = np.array([run.get(f"v[{i}]") for i in range(1, 6)]) / SPEED
    return {"macro": macro, "onset": onset, "micro": micro, "outcome": outcome}


def checks(free: np.ndarray, touching: dict, apart: dict) -> list[Check]:
    """The chain to 1e-9, the cradle to within the effect of gravity in a millisecond, and the dead band's textbook outcome."""
    worst = np.abs(touching["outcome"] - OUTCOME).max()
    ideal = np.abs(apart["outcome"] - [0, 0, 0, 0, 1]).max()
    return [
        *conserved("Hertz", touching["macro"], SPEED),
        *(within("Hertz", f"chain: v[{i}] / speed", v, w, 1e-9) for i, (v, w) in enumerate(zip(free, OUTCOME, strict=True), start=1)),
        within("Hertz", "steel cradle: worst difference from the chain", worst, 0.0, 1e-5),
        at_least("Hertz", "speed of ball 4 / striker's, touching", touching["outcome"][3], 0.1),
        within("Hertz", "with dead band: difference from textbook", ideal, 0.0, 1e-5),
    ]  # fmt: skip


def plot_impact(touching: dict, apart: dict) -> Plot:
    """The forces of the first impact."""
    titles = ((touching, "balls that touch"), (apart, f"dead band of {DEAD_BAND * 1e6:g} µm"))
    views = [View("impact", -5e-5, 1.6e-3), View("onset", -5e-6, 1e-4)]
    columns = [
        Column(title, "time after the first onset", "s", forces(data["micro"], origin=data["onset"]), views)
        for data, title in titles
    ]
    v = touching["outcome"]
    return Plot(
        "hertz",
        "Hertz contacts: the first impact of a cradle of steel balls",
        f"One steel ball of 1 kg strikes four at {SPEED:.3f} m/s. Left, touching: the last ball leaves with {v[4]:.3f} of the "
        f"speed, ball 4 with {v[3]:.3f}, and the first three bounce back. The paper calls this unrealistic; experiments "
        "with steel balls find the same (Hutzler et al. 2004, Donahue et al. 2008). Right: with a dead band the outcome is "
        "that of the textbook. Orders of 3 and more come close.",
        columns,
        files=("hertz.csv", "hertz_pulses.csv"),
    )


def plot_swing(touching: dict, apart: dict) -> Plot:
    """Positions over a few swings."""
    columns = []
    for data, title in ((touching, "balls that touch"), (apart, "with the dead band")):
        strips = [
            Strip(f"x[{i}]", "m", [Trace(data["macro"]["time"], data["macro"][f"x[{i}]"], COLOURS[i - 1])], (-0.06, 0.06))
            for i in range(1, 6)
        ]  # fmt: skip
        columns.append(
            Column(title, "time", "s", strips, [View("8 s", 0.0, STOP), View("two clicks", 0.5, 3.0)])
        )
    return Plot(
        "hertz_swing",
        "Hertz contacts: a few swings",
        "Left: after the first impact no ball is at rest, and soon the balls swing together in groups, as on any desk. "
        "Right: with the dead band the middle balls stand still.",
        columns,
        height=0.9,
    )


if __name__ == "__main__":
    run_script(run, __doc__)
