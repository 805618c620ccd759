"""Stiffness: a stiffer linear contact shortens the pulses, but does not change their overlap."""

import numpy as np
from figure5 import DEAD_BAND, SPEED  # of the arriving balls, of 1 kg each
from plots import COLOURS, Column, Strip, Trace
from support import Found, nc, tracked

STIFFNESS = [1e10, 1e12, 1e13, 1e14]  # N/m
SPAN, STEPS = 10.0, 1000  # time after the onset in sqrt(m/k), and its number of steps
TIME = np.linspace(0.0, SPAN, STEPS + 1)


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """The first impact of Figure 5 at four stiffnesses, in units of the impact. Without a dead band the shape is the
    same, apart from gravity (about omega^2 m/k) and rounding; with a fixed dead band it is not."""
    cases = [(k, dead_band) for dead_band in (0.0, DEAD_BAND) for k in STIFFNESS]
    force, outcome, neighbours = {}, {}, {}
    for case in tracked("Stiffness from 1e10 to 1e14 N/m", cases):
        force[case], outcome[case], neighbours[case] = impact(fmus[5], *case)
    kinds = [("stiffness", "f8"), ("deadBand", "f8"), *((f"v[{i}]", "f8") for i in range(1, 6))]
    found.save("stiffness.csv", np.array([(*case, *velocities) for case, velocities in outcome.items()], dtype=kinds))

    none, band = cases[: len(STIFFNESS)], cases[len(STIFFNESS) :]
    for what, of in (("pulses / v sqrt(k m)", force), ("outcome / v", outcome)):
        change = max(np.abs(of[case] - of[none[0]]).max() for case in none)
        found.at_most("stiffness", f"no dead band: change of the {what}", change, 1e-6)
    overlapping = tuple(neighbours[case] for case in band)
    found.equal("stiffness", "0.26 µm: overlapping neighbours at 1e10 .. 1e14", overlapping, (3, 3, 3, 0))
    change = np.ptp([outcome[case] for case in band], axis=0).max()
    found.at_least("stiffness", "0.26 µm: change of the outcome / v", change, 0.1)

    columns = []
    for shown, title in ((none, "without a dead band: one curve"), (band, "with a dead band of 0.26 µm")):
        strips = [Strip(f"F[{i + 1}]", [
            Trace(TIME, force[case][:, i], colour, "line", f"{case[0]:.0e} N/m" if i == 0 else "")
            for case, colour in zip(shown, COLOURS, strict=False)
        ], limits=(0.0, 0.85)) for i in range(4)]  # fmt: skip
        columns.append(Column(strips, {"all": (0.0, SPAN)}, title, "time / sqrt(m/k)", ""))
    found.plot(
        "stiffness",
        "Stiffness does not matter, unless there is a dead band",
        "Figure 5's first impact at stiffnesses from 1e10 to 1e14 N/m, forces over v sqrt(k m) and time over "
        "sqrt(m/k). Left: the four curves coincide. A stiffer contact makes the pulses shorter and higher, but "
        "never separates them. Right: what counts is the ratio of dead band to largest overlap, so a dead band that "
        "separates the pulses of stiff contacts does nothing for soft ones.",
        columns,
    )


def impact(fmu: nc.Fmu, k: float, dead_band: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Forces over v sqrt(k m) at TIME from the onset; final velocities over v; overlapping neighbours."""
    unit = 1 / np.sqrt(k)
    with fmu.start(nc.figure5() | nc.power_law(k, dead_band=dead_band)) as run:
        _, micro = run.zoom(span=SPAN * unit, step=SPAN * unit / STEPS, record=["F"])
        return micro["F"] / (SPEED * np.sqrt(k)), run["v"] / SPEED, nc.overlapping_neighbours(micro.pulses)
