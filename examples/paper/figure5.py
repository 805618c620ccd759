"""Figure 5 and Table 1: the microsecond of the first impact, without and with a dead band."""

import numpy as np
from plots import Column, family
from support import Found, nc, print_rows

DEAD_BAND = 2.6e-7  # m
SPEED = np.sqrt(5.0)  # m/s, amplitude 1 m times sqrt(g/L): speed of a lifted ball at x = 0
STOP = 10.0  # s, of the macro runs
TABLE1 = [(1, 1, 0, 0, 0), (1, 0, 1, 0, 0), (0, 1, 0, 1, 0), (0, 0, 1, 0, 1), (0, 0, 0, 1, 1)]
ORDER = [[2], [1, 3], [2, 4], [3]]  # contacts that close in each step of Table 1
MIRRORED = [[3], [2, 4], [1, 3], [2]]  # the return stroke
OVERLAPPING = [-0.170899748309, -0.049200786161, 0.382027214318, 0.660994995746, 1.177078324407]  # v / SPEED


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """Both cases: macro run, micro view, Table 1."""
    title = "without a dead band: the pulses overlap"
    onset, macro, micro, overlapping = case(fmus[5], found, "without dead band", 0.0, title)
    figure, first = "5, none", micro.pulses
    worst = np.abs(micro["v"][-1] / SPEED - OVERLAPPING).max()
    found.conserved(figure, macro, SPEED)
    found.within(figure, "first onset (t_next)", onset, 0.702481473104, 1e-9, "s")
    found.equal(figure, "pulses, overlapping neighbours", (len(first), nc.overlapping_neighbours(first)), (4, 3))
    found.within(figure, "impact lasts", first["release"].max() - onset, 5.830036335e-7, 1e-12, "s")
    found.at_most(figure, "final velocities / speed, worst error", worst, 1e-8)

    title = "with a dead band of 0.26 µm: one after the other"
    onset, macro, micro, separate = case(fmus[5], found, "with dead band", DEAD_BAND, title)
    figure, (first, second) = "5, band", nc.impact_sequences(macro.pulses)[:2]
    states = table1(micro)
    found.conserved(figure, macro, SPEED)
    found.within(figure, "first onset (t_next)", onset, 0.702481589380, 1e-9, "s")
    found.equal(figure, "pulses, overlapping neighbours", (len(first), nc.overlapping_neighbours(first)), (6, 0))
    found.equal(figure, "pulse order", show_order(nc.pulse_order(first)), show_order(ORDER))
    found.equal(figure, "return stroke", show_order(nc.pulse_order(second)), show_order(MIRRORED))
    found.equal("Table 1", "states, in order", show_states(states), show_states(TABLE1))
    save_table1(states, found)
    found.plot(
        "figure5",
        "Figure 5: the first impact, nanosecond by nanosecond",
        "Two balls arrive at 2.236 m/s. Left: neighbouring contacts are closed together, every ball ends up moving, "
        "and balls 1 and 2 bounce back. Right: the dead band lets each collision finish before the next begins, so "
        "the balls exchange velocities pair by pair (Table 1), and exactly two leave on the other side.",
        [overlapping, separate],
    )


def case(fmu: nc.Fmu, found: Found, label: str, dead_band: float, title: str) -> tuple:
    """One dead band (m): its first onset (s), ten seconds, the first impact in nanosecond steps, and its column in
    the plot."""
    values = nc.figure5(dead_band)
    macro = fmu.simulate(values, stop=STOP, progress=nc.Progress(f"Figure 5 {label}, 10 s"))
    with fmu.start(values) as zoomed:
        onset, micro = zoomed.zoom(span=1.1e-6, step=1e-9, record=["F", "x", "v"], before=5e-8)
    stem = "figure5_" + label.replace(" ", "_")
    found.save(f"{stem}.csv", macro.samples)
    found.save(f"{stem}_pulses.csv", macro.pulses)
    found.save(f"{stem}_micro.csv", micro.samples)
    views = {"impact": (-5e-8, 1.1e-6), "onset": (-2e-9, 4e-8)}
    strips = family(micro, "F", origin=onset, limits=(0, 1.8e7))
    return onset, macro, micro, Column(strips, views, title, f"time after the first onset at {onset:.12f} s")


def show_order(order: list[list[int]]) -> str:
    """[[2], [1, 3]] as "2-3, 1-2 & 3-4": which balls touch, in turn."""
    return ", ".join(" & ".join(f"{i}-{i + 1}" for i in group) for group in order)


def show_states(states) -> str:
    """Rows of Table 1 as digits: 1 moving, 0 stopped."""
    return " ".join("".join(map(str, state)) for state in states)


def table1(micro: nc.Result) -> list[tuple]:
    """Who moves whenever all contacts are open: the distinct rows (1 moving, 0 stopped) in order."""
    free = ~np.any(micro["F"] > 0, axis=1)
    moving = np.abs(micro["v"][free]) > 0.5 * SPEED
    states = [tuple(map(int, row)) for row in moving]
    return [state for i, state in enumerate(states) if i == 0 or state != states[i - 1]]


def save_table1(states: list[tuple], found: Found) -> None:
    """Table 1 as the paper prints it, to a CSV file and to the terminal."""
    names = ["begin", *(f"intermediate {i}" for i in range(1, len(states) - 1)), "end"]
    rows = [
        {"state": name} | {f"ball {i}": "moving" if moves else "stopped" for i, moves in enumerate(state, start=1)}
        for name, state in zip(names, states, strict=True)
    ]
    found.save_rows("table1.csv", rows)
    print("  Table 1, from the samples of the first impact at which no contact is closed:")
    print_rows(rows)
