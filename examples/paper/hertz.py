"""Hertz: steel balls that touch at rest move apart at the first impact, as experiments show."""

import numpy as np
from plots import Column, family
from support import Found, nc

AMPLITUDE = 0.05  # m
SPEED = AMPLITUDE * np.sqrt(5.0)  # m/s, amplitude times sqrt(g/L)
# Velocities after one ball of five has struck, over its speed: chain with p = 1.5 in quadruple precision.
OUTCOME = [-0.071085017086, -0.030273764097, -0.014463629032, 0.127044986068, 0.988777424147]
STOP = 8.0  # s
DEAD_BAND = 2e-5  # m, more than the largest overlap of 6 µm times 1.4716


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """The struck chain by itself, then a cradle of steel balls, touching and with a dead band: a few swings, and the
    first impact in microsecond steps."""
    with fmus[5].start(nc.chain(1.5, strikers=1)) as run:
        run.step_to(20.0)
        free = run["v"]
    outcomes, impacts, swings = [], [], []
    for label, dead_band, title, of_swings in (
        ("Hertz, steel balls that touch", {}, "balls that touch", "balls that touch"),
        ("Hertz with a dead band", {"contact.deadBand": DEAD_BAND}, "dead band of 20 µm", "with the dead band"),
    ):  # fmt: skip
        values = nc.steel(amplitude=AMPLITUDE) | {"pendulum.length": 1.962} | dead_band
        macro = fmus[5].simulate(values, stop=STOP, progress=nc.Progress(label))
        with fmus[5].start(values) as run:
            onset, micro = run.zoom(span=1.7e-3, step=1e-6, record=["x", "v", "F"], before=5e-5)
            outcomes.append(run["v"] / SPEED)
        if not dead_band:
            found.save("hertz.csv", macro.samples)
            found.save("hertz_pulses.csv", macro.pulses)
            found.conserved("Hertz", macro, SPEED)
        views = {"impact": (-5e-5, 1.6e-3), "onset": (-5e-6, 1e-4)}
        impacts.append(Column(family(micro, "F", origin=onset), views, title, "time after the first onset"))
        views = {"8 s": (0.0, STOP), "two clicks": (0.5, 3.0)}
        swings.append(Column(family(macro, "x", limits=(-0.06, 0.06)), views, of_swings))

    touching, apart = outcomes
    for i, (v, wanted) in enumerate(zip(free, OUTCOME, strict=True), start=1):
        found.within("Hertz", f"chain: v[{i}] / speed", v, wanted, 1e-9)
    # The tolerances allow for gravity during a millisecond.
    worst, ideal = np.abs(touching - OUTCOME).max(), np.abs(apart - [0, 0, 0, 0, 1]).max()
    found.within("Hertz", "steel cradle: worst difference from the chain", worst, 0.0, 1e-5)
    found.at_least("Hertz", "speed of ball 4 / striker's, touching", touching[3], 0.1)
    found.within("Hertz", "with dead band: difference from textbook", ideal, 0.0, 1e-5)
    found.plot(
        "hertz",
        "Hertz contacts: the first impact of a cradle of steel balls",
        f"One steel ball of 1 kg strikes four at {SPEED:.3f} m/s. Left, touching: the last ball leaves with "
        f"{touching[4]:.3f} of the speed, ball 4 with {touching[3]:.3f}, and the first three bounce back. The paper "
        "calls this unrealistic; experiments with steel balls find the same (Hutzler et al. 2004, Donahue et al. "
        "2008). Right: with a dead band the outcome is that of the textbook. Orders of 3 and more come close.",
        impacts,
    )
    found.plot(
        "hertz_swing",
        "Hertz contacts: a few swings",
        "Left: after the first impact no ball is at rest, and soon the balls swing together in groups, as on any desk. "
        "Right: with the dead band the middle balls stand still.",
        swings,
        height=0.9,
    )
