"""Dead band scan: how large a dead band separates the pulses, for each order of the force law."""

import numpy as np
from plots import COLOURS, Column, Strip, Trace
from support import Fmus, Found, nc, tracked

# deadBand / largest overlap at which neighbouring pulses part: I_p = B(1/(p+1), 1/2)/(p+1).
THRESHOLD = {1.0: 1.5708, 1.5: 1.4716, 2.0: 1.4022, 3.0: 1.3110, 4.0: 1.2537, 5.0: 1.2143}
RATIOS = np.linspace(0.0, 1.6, 17)


def run(fmus: Fmus, found: Found) -> None:
    """The overlap over the dead band for each order; the threshold by bisection, which does not depend on the number
    of balls."""
    orders = tracked("Dead band scan for orders 1 to 5", THRESHOLD)
    curves = {p: np.array([overlap(fmus.five, p, ratio) for ratio in RATIOS]) for p in orders}
    kinds = [("deadBand_over_overlap", "f8"), *((f"p={p:g}", "f8") for p in curves)]
    found.save("dead_band.csv", np.array(list(zip(RATIOS, *curves.values(), strict=True)), dtype=kinds))
    for fmu in (fmus.five, fmus.thirteen):
        for p, wanted in THRESHOLD.items():
            found.within("dead band", f"p = {p:g}, {fmu.balls} balls", threshold(fmu, p), wanted, 6e-5)

    traces = [
        Trace(RATIOS, curve, colour, "line", f"p = {p:g}")
        for (p, curve), colour in zip(curves.items(), COLOURS, strict=True)
    ]
    strip, views = Strip("shared impulse", traces, limits=(0.0, 0.6)), {"all": (0.0, 1.6)}
    found.plot(
        "dead_band",
        "How much dead band separates the pulses",
        "Overlap of neighbouring pulses over the dead band, in units of the largest overlap of two balls. Each curve "
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
    return nc.overlaps(nc.resolved(fmu, chain, stop=30.0, step=0.1, per_pulse=64, record=["F"])).mean()


def threshold(fmu: nc.Fmu, p: float) -> float:
    """Smallest ratio without overlap, to 1e-6."""
    overlapping, separate = 1.0, 2.0
    while separate - overlapping > 1e-6:
        ratio = 0.5 * (overlapping + separate)
        run = fmu.simulate(values(p, ratio, fmu.balls), times=[0.0, 100.0], record=[])
        if nc.overlapping_neighbours(run.pulses) == 0:
            separate = ratio
        else:
            overlapping = ratio
    return separate
