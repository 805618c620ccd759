"""Overlap of neighbouring pulses for each order p of the force law F = k overlap^p, and the dead band that ends it."""

import numpy as np
from plots import COLOURS, Column, Strip, Trace
from support import Found, nc, tracked

# deadBand / largest overlap from which neighbouring pulses do not overlap: I_p = B(1/(p+1), 1/2)/(p+1).
THRESHOLD = {1.0: 1.5708, 1.5: 1.4716, 2.0: 1.4022, 3.0: 1.3110, 4.0: 1.2537, 5.0: 1.2143}
# Overlap without a dead band, from an independent computation in quadruple precision.
OVERLAP = {1.0: 0.536, 1.5: 0.357, 2.0: 0.234, 3.0: 0.108, 4.0: 0.0523, 5.0: 0.0261}
RATIOS = np.linspace(0.0, 1.6, 17)


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """For each order, the overlap over the dead band and, by bisection, the threshold, which does not depend on the
    number of balls."""
    orders = tracked("Dead band scan for orders 1 to 5", THRESHOLD)
    curves = {p: np.array([overlap(fmus[5], p, ratio) for ratio in RATIOS]) for p in orders}
    kinds = [("deadBand_over_overlap", "f8"), *((f"p={p:g}", "f8") for p in curves)]
    found.save("dead_band.csv", np.array(list(zip(RATIOS, *curves.values(), strict=True)), dtype=kinds))
    for p, wanted in OVERLAP.items():
        # An error of half a unit in the third digit is allowed.
        allowed = 0.5 * 10 ** (np.floor(np.log10(wanted)) - 2)
        found.within("overlap", f"p = {p:g}", curves[p][0], wanted, allowed)
    for fmu in fmus.values():
        for p, wanted in THRESHOLD.items():
            found.within("dead band", f"p = {p:g}, {fmu.balls} balls", threshold(fmu, p), wanted, 6e-5)

    traces = [
        Trace(RATIOS, curve, colour, "line", f"p = {p:g}")
        for (p, curve), colour in zip(curves.items(), COLOURS, strict=True)
    ]
    strip, views = Strip("shared impulse", traces, limits=(0.0, 0.6)), {"all": (0.0, 1.6)}
    found.plot(
        "dead_band",
        "Overlap of neighbouring pulses, and how much dead band separates them",
        "One ball strikes four. The overlap of two pulses is the impulse that they share (the integral of the smaller "
        "force) over the smaller of their impulses; shown is the mean of the three neighbouring pairs over the dead "
        "band, in units of the largest overlap of two balls. Without a dead band pulses of quadratic springs still "
        "overlap, those of third and higher order hardly do, as the paper says. Hertz: p = 1.5. Each curve "
        "reaches zero at the ratio I_p = B(1/(p+1), 1/2)/(p+1): 1.5708 for linear contacts, less for higher orders, "
        "for any number of balls. From there on a ball leaves its neighbour before it reaches the next one.",
        [Column([strip], views, xlabel="dead band / largest overlap", xunit="")],
        height=2.6,
    )


def values(p: float, ratio: float, n: int) -> dict:
    """A free chain at rest, struck at 1 m/s, with a dead band of `ratio` times the largest overlap."""
    largest = ((p + 1) / 4) ** (1 / (p + 1))  # of two balls of 1 kg at 1 m/s, k = 1
    return nc.chain(p, strikers=1, n=n) | {"contact.deadBand": ratio * largest}


def overlap(fmu: nc.Fmu, p: float, ratio: float) -> float:
    """Mean overlap of neighbouring pulses, 0 to 1."""
    chain = values(p, ratio, fmu.balls)
    return nc.overlaps(nc.resolved(fmu, chain, stop=30.0, step=0.1, per_pulse=256, record=["F"])).mean()


def threshold(fmu: nc.Fmu, p: float) -> float:
    """Smallest ratio of dead band to largest overlap without overlapping pulses, to 1e-6."""
    overlapping, separate = 1.0, 2.0
    while separate - overlapping > 1e-6:
        ratio = 0.5 * (overlapping + separate)
        run = fmu.simulate(values(p, ratio, fmu.balls), times=[0.0, 100.0], record=[])
        if nc.overlapping_neighbours(run.pulses) == 0:
            separate = ratio
        else:
            overlapping = ratio
    return separate
