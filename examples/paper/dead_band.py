"""Dead band scan: how large a dead band separates the pulses, for each order of the force law."""

import numpy as np
from plots import COLOURS, Column, Plot, Strip, Trace, View
from support import Check, Fmus, Outcome, nc, run_script, save_csv, within

# deadBand / largest overlap at which neighbouring pulses part: I_p = B(1/(p+1), 1/2)/(p+1).
THRESHOLD = {1.0: 1.5708, 1.5: 1.4716, 2.0: 1.4022, 3.0: 1.3110, 4.0: 1.2537, 5.0: 1.2143}
RATIOS = np.linspace(0.0, 1.6, 17)
FORCES = [f"F[{i}]" for i in range(1, 5)]


def run(fmus: Fmus, out) -> Outcome:
    """The overlap over the dead band for each order, and the threshold by bisection, for five and 13 balls."""
    progress = nc.Progress("Dead band scan for orders 1 to 5")
    curves, five, thirteen = {}, {}, {}
    for number, p in enumerate(THRESHOLD, start=1):
        curves[p] = np.array([overlap(fmus.five, p, ratio) for ratio in RATIOS])
        five[p], thirteen[p] = threshold(fmus.five, p), threshold(fmus.thirteen, p)
        progress(number / len(THRESHOLD))
    kinds = [("deadBand_over_overlap", "f8"), *((f"p={p:g}", "f8") for p in curves)]
    table = np.array(list(zip(RATIOS, *curves.values(), strict=True)), dtype=kinds)
    save_csv(out / "dead_band.csv", table)
    return Outcome(checks(five, 5) + checks(thirteen, 13), [plot(curves)])


def values(p: float, ratio: float, n: int) -> dict:
    """A free chain at rest, struck at 1 m/s, with a dead band of `ratio` times the largest overlap."""
    largest = ((p + 1) / 4) ** (1 / (p + 1))  # of two balls of 1 kg at 1 m/s, k = 1
    return nc.chain(p, strikers=1, n=n) | {"contact.deadBand": ratio * largest}


def overlap(fmu: nc.Fmu, p: float, ratio: float) -> float:
    """Mean overlap of neighbouring pulses, 0 to 1."""
    chain = values(p, ratio, fmu.balls)
    return nc.overlaps(nc.resolved(fmu, chain, stop=30.0, step=0.1, per_pulse=64, record=FORCES)).mean()


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


def checks(found: dict, balls: int) -> list[Check]:
    """The thresholds, to the digits that are known. They do not depend on the number of balls."""
    return [
        within("dead band", f"p = {p:g}, {balls} balls", found[p], wanted, 6e-5)
        for p, wanted in THRESHOLD.items()
    ]


def plot(curves: dict) -> Plot:
    """Overlap over dead band, a curve for each order."""
    traces = [
        Trace(RATIOS, curve, colour, "line", f"p = {p:g}")
        for (p, curve), colour in zip(curves.items(), COLOURS, strict=True)
    ]
    return Plot(
        "dead_band",
        "How much dead band separates the pulses",
        "Overlap of neighbouring pulses over the dead band, in units of the largest overlap of two balls. Each curve "
        "reaches zero at the ratio I_p = B(1/(p+1), 1/2)/(p+1): 1.5708 for linear contacts, less for higher orders, "
        "for any number of balls. From there on a ball leaves its neighbour before it reaches the next one.",
        [Column("", "dead band / largest overlap", "", [Strip("shared impulse", "", traces, (0.0, 0.6))],
                [View("all", 0.0, 1.6)])],
        height=2.6,
        files=("dead_band.csv",),
    )  # fmt: skip


if __name__ == "__main__":
    run_script(run, __doc__)
