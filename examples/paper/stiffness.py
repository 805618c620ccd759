"""Stiffness: a stiffer linear contact shortens the pulses, but does not change their overlap."""

import numpy as np
from plots import COLOURS, Column, Plot, Strip, Trace, View
from support import Check, Fmus, Outcome, at_least, at_most, equal, nc, run_script, save_csv

STIFFNESS = [1e10, 1e12, 1e13, 1e14]  # N/m
SPEED = np.sqrt(5.0)  # m/s, of the arriving balls; their mass is 1 kg
DEAD_BAND = 2.6e-7  # m
FORCES = [f"F[{i}]" for i in range(1, 5)]
SPAN, STEPS = 10.0, 1000  # how long to look after the onset, in sqrt(m/k), and in how many steps


def run(fmus: Fmus, out) -> Outcome:
    """The first impact of Figure 5 at four stiffnesses, in units of the impact, without and with dead band."""
    progress = nc.Progress("Stiffness from 1e10 to 1e14 N/m")
    cases = {}
    for number, dead_band in enumerate((0.0, DEAD_BAND)):
        for place, k in enumerate(STIFFNESS, start=1):
            cases[k, dead_band] = impact(fmus.five, k, dead_band)
            progress((number * len(STIFFNESS) + place) / (2 * len(STIFFNESS)))
    rows = [(k, d, *data["outcome"]) for (k, d), data in cases.items()]
    kinds = [("stiffness", "f8"), ("deadBand", "f8"), *((f"v[{i}]", "f8") for i in range(1, 6))]
    save_csv(out / "stiffness.csv", np.array(rows, dtype=kinds))
    return Outcome(checks(cases), [plot(cases)])


def impact(fmu: nc.Fmu, k: float, dead_band: float) -> dict:
    """Forces over v sqrt(k m), against time over sqrt(m/k) from the onset, and the final velocities over v."""
    unit = 1 / np.sqrt(k)
    with fmu.start(nc.figure5() | nc.power_law(k, dead_band=dead_band)) as run:
        _, micro = run.zoom(span=SPAN * unit, step=SPAN * unit / STEPS, record=FORCES)
        outcome = np.array([run.get(f"v[{i}]") for i in range(1, 6)]) / SPEED
    force = micro.stack("F") / (SPEED * np.sqrt(k))
    return {
        "time": np.linspace(0.0, SPAN, STEPS + 1),
        "force": force,
        "outcome": outcome,
        "neighbours": nc.overlapping_neighbours(micro.pulses),
    }


def checks(cases: dict) -> list[Check]:
    """The same shape, apart from the effect of gravity (about omega^2 m/k) and rounding; not so with a fixed dead band."""
    reference = cases[STIFFNESS[0], 0.0]
    others = [cases[k, 0.0] for k in STIFFNESS]
    shape = max(np.abs(case["force"] - reference["force"]).max() for case in others)
    outcome = max(np.abs(case["outcome"] - reference["outcome"]).max() for case in others)
    neighbours = tuple(cases[k, DEAD_BAND]["neighbours"] for k in STIFFNESS)
    change = np.ptp([cases[k, DEAD_BAND]["outcome"] for k in STIFFNESS], axis=0).max()
    return [
        at_most("stiffness", "no dead band: change of the pulses / v sqrt(k m)", shape, 1e-6),
        at_most("stiffness", "no dead band: change of the outcome / v", outcome, 1e-6),
        equal("stiffness", "0.26 µm: overlapping neighbours at 1e10 .. 1e14", neighbours, (3, 3, 3, 0)),
        at_least("stiffness", "0.26 µm: change of the outcome / v", change, 0.1),
    ]


def plot(cases: dict) -> Plot:
    """All stiffnesses on top of each other, in the impact's own units."""
    columns = []
    for dead_band, title in (
        (0.0, "without a dead band: one curve"),
        (DEAD_BAND, "with a dead band of 0.26 µm"),
    ):
        strips = [Strip(name, "", [
            Trace(data["time"], data["force"][:, i], colour, "line", f"{k:.0e} N/m" if i == 0 else "")
            for k, colour in zip(STIFFNESS, COLOURS, strict=False)
            for data in [cases[k, dead_band]]
        ], (0.0, 0.85)) for i, name in enumerate(FORCES)]  # fmt: skip
        columns.append(Column(title, "time / sqrt(m/k)", "", strips, [View("all", 0.0, SPAN)]))
    return Plot(
        "stiffness",
        "Stiffness does not matter, unless there is a dead band",
        "Figure 5's first impact at stiffnesses from 1e10 to 1e14 N/m, forces over v sqrt(k m) and time over sqrt(m/k). "
        "Left: the four curves coincide. A stiffer contact makes the pulses shorter and higher, but never separates them. "
        "Right: what counts is the ratio of dead band to largest overlap, so a dead band that separates the pulses of stiff "
        "contacts does nothing for soft ones.",
        columns,
        files=("stiffness.csv",),
    )


if __name__ == "__main__":
    run_script(run, __doc__)
