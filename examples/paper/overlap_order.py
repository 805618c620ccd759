"""The overlap of pulses as a function of the order p of the force law F = k overlap^p."""

import numpy as np
from plots import COLOURS, Column, Strip, Trace, forces
from support import Fmus, Found, nc, tracked

# Overlap with one ball lifted, from an independent computation in quadruple precision.
OVERLAP = {1.0: 0.536, 1.5: 0.357, 2.0: 0.234, 3.0: 0.108, 4.0: 0.0523, 5.0: 0.0261}
SHOWN = (1.0, 2.0, 4.0)  # orders whose pulses are drawn
STOP = 12.0  # duration of the chain's units, sqrt(m/k) for p = 1: the pulses are over


def run(fmus: Fmus, found: Found) -> None:
    """A chain of five balls that just touch, struck by the first one, for each order."""
    fine = {"stop": STOP, "step": 0.05, "per_pulse": 800, "record": ["F"]}
    orders = tracked("Overlap for orders 1 to 5", OVERLAP)
    results = {p: nc.resolved(fmus.five, nc.chain(p, strikers=1), **fine) for p in orders}
    overlap = {p: nc.overlaps(result).mean() for p, result in results.items()}
    found.save(
        "overlap_order.csv", np.array(list(overlap.items()), dtype=[("order", "f8"), ("overlap", "f8")])
    )
    for p, wanted in OVERLAP.items():
        # An error of half a unit in the third digit is allowed.
        allowed = 0.5 * 10 ** (np.floor(np.log10(wanted)) - 2)
        found.within("overlap", f"p = {p:g}", overlap[p], wanted, allowed)

    orders, values = np.array(list(overlap)), np.array(list(overlap.values()))
    traces = [Trace(orders, values, COLOURS[5], "dashed"), Trace(orders, values, COLOURS[1], "points")]
    strip, views = Strip("shared impulse", traces, limits=(0.0, 0.6)), {"all": (0.8, 5.2)}
    found.plot(
        "overlap_order",
        "Overlap of neighbouring pulses over the order of the force law",
        "One ball strikes four that touch. The overlap of two pulses is the impulse that they share (the integral "
        "of the smaller force) over the smaller of their impulses. The plot shows the mean of the three "
        "neighbouring pairs. Pulses of quadratic springs still overlap, those of third and higher order hardly do, "
        "as the paper says. Hertz: p = 1.5.",
        [Column([strip], views, xlabel="order p", xunit="")],
        height=2.6,
    )
    columns = []
    for p in SHOWN:
        strips = forces(results[p], unit="", limits=(0.0, 1.1))
        columns.append(Column(strips, {"all": (0.0, STOP)}, f"order {p:g}", "time / unit", ""))
    found.plot(
        "overlap_pulses",
        "Pulses for orders 1, 2 and 4",
        "Contact forces of the same chain in its own units (mass, stiffness and speed of the striking ball are 1). The "
        "higher the order, the more the pulses follow one another.",
        columns,
    )
