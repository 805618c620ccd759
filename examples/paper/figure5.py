"""Figure 5 and Table 1: the microsecond of the first impact, without and with a dead band."""

import csv

import numpy as np
from plots import Column, Plot, View, forces
from support import Check, Fmus, Outcome, at_most, conserved, equal, nc, run_script, save_csv, within

DEAD_BAND = 2.6e-7  # m
SPEED = np.sqrt(5.0)  # m/s, amplitude 1 m times sqrt(g/L): speed of a lifted ball at x = 0
STOP = 10.0  # s, of the macro runs
TABLE1 = [(1, 1, 0, 0, 0), (1, 0, 1, 0, 0), (0, 1, 0, 1, 0), (0, 0, 1, 0, 1), (0, 0, 0, 1, 1)]
ORDER = [[2], [1, 3], [2, 4], [3]]  # contacts that close in each step of Table 1
MIRRORED = [[3], [2, 4], [1, 3], [2]]  # the return stroke
OVERLAPPING = [-0.170899748309, -0.049200786161, 0.382027214318, 0.660994995746, 1.177078324407]  # v / SPEED


def run(fmus: Fmus, out) -> Outcome:
    """Both cases: macro run, micro view, Table 1; writes CSV."""
    without = case(fmus.five, out, "without dead band", 0.0)
    with_band = case(fmus.five, out, "with dead band", DEAD_BAND)
    states = table1(with_band)
    save_table1(states, out / "table1.csv")
    return Outcome(checks_without(without) + checks_with(with_band, states), [plot(without, with_band)])


def case(fmu: nc.Fmu, out, label: str, dead_band: float) -> dict:
    """One dead band (m): ten seconds, then the first impact in nanosecond steps."""
    values = nc.figure5(dead_band)
    macro = fmu.simulate(values, stop=STOP, progress=nc.Progress(f"Figure 5 {label}, 10 s"))
    names = [f"{what}[{i}]" for what in "Fxv" for i in range(1, 6) if (what, i) != ("F", 5)]
    with fmu.start(values) as zoomed:
        onset, micro = zoomed.zoom(span=1.1e-6, step=1e-9, record=names, before=5e-8)
        v_after = [zoomed.get(f"v[{i}]") for i in range(1, 6)]
    stem = "figure5_" + label.replace(" ", "_")
    save_csv(out / f"{stem}.csv", macro.samples)
    save_csv(out / f"{stem}_pulses.csv", macro.pulses)
    save_csv(out / f"{stem}_micro.csv", micro.samples)
    return {"onset": onset, "macro": macro, "micro": micro, "v_after": np.array(v_after)}


def checks_without(data: dict) -> list[Check]:
    """Overlapping pulses: when they begin and end, and the velocities with which the balls leave."""
    figure = "5, none"
    first = data["micro"].pulses
    count = (len(first), nc.overlapping_neighbours(first))
    worst = np.abs(data["v_after"] / SPEED - OVERLAPPING).max()
    return [
        *conserved(figure, data["macro"], SPEED),
        within(figure, "first onset (t_next)", data["onset"], 0.702481473104, 1e-9, "s"),
        equal(figure, "pulses, overlapping neighbours", count, (4, 3)),
        within(figure, "impact lasts", first["release"].max() - data["onset"], 5.830036335e-7, 1e-12, "s"),
        at_most(figure, "final velocities / speed, worst error", worst, 1e-8),
    ]


def checks_with(data: dict, states: list) -> list[Check]:
    """Six separate pulses in Table 1's order, and mirrored at the next click."""
    figure = "5, band"
    first, second = nc.impact_sequences(data["macro"].pulses)[:2]
    count = (len(first), nc.overlapping_neighbours(first))
    return [
        *conserved(figure, data["macro"], SPEED),
        within(figure, "first onset (t_next)", data["onset"], 0.702481589380, 1e-9, "s"),
        equal(figure, "pulses, overlapping neighbours", count, (6, 0)),
        equal(figure, "pulse order", show_order(nc.pulse_order(first)), show_order(ORDER)),
        equal(figure, "return stroke", show_order(nc.pulse_order(second)), show_order(MIRRORED)),
        equal("Table 1", "states, in order", show_states(states), show_states(TABLE1)),
    ]


def show_order(order: list[list[int]]) -> str:
    """[[2], [1, 3]] as "2-3, 1-2 & 3-4": which balls touch, in turn."""
    return ", ".join(" & ".join(f"{i}-{i + 1}" for i in group) for group in order)


def show_states(states) -> str:
    """Rows of Table 1 as digits: 1 moving, 0 stopped."""
    return " ".join("".join(map(str, state)) for state in states)


def table1(data: dict) -> list[tuple]:
    """Who moves whenever all contacts are open: the distinct rows (1 moving, 0 stopped) in order."""
    micro = data["micro"]
    free = ~np.any(micro.stack("F") > 0, axis=1)
    moving = np.abs(micro.stack("v")[free]) > 0.5 * SPEED
    states = [tuple(map(int, row)) for row in moving]
    return [state for i, state in enumerate(states) if i == 0 or state != states[i - 1]]


def save_table1(states: list[tuple], path) -> None:
    """Table 1 as the paper prints it, to a CSV file and to the terminal."""
    rows = [["state", *(f"ball {i}" for i in range(1, 6))]]
    for i, state in enumerate(states):
        name = "begin" if i == 0 else "end" if i == len(states) - 1 else f"intermediate {i}"
        rows.append([name, *("moving" if moving else "stopped" for moving in state)])
    with path.open("w", newline="", encoding="ascii") as file:
        csv.writer(file).writerows(rows)
    print("  Table 1, from the samples of the first impact at which no contact is closed:")
    for row in rows:
        print("    " + "".join(cell.ljust(16 if i == 0 else 9) for i, cell in enumerate(row)).rstrip())


def plot(without: dict, with_band: dict) -> Plot:
    """Two columns (without, with), one strip per contact, time from the first onset."""
    return Plot(
        "figure5",
        "Figure 5: the first impact, nanosecond by nanosecond",
        "Two balls arrive at 2.236 m/s. Left: neighbouring contacts are closed together, every ball ends up moving, "
        "and balls 1 and 2 bounce back. Right: the dead band lets each collision finish before the next begins, so "
        "the balls exchange velocities pair by pair (Table 1), and exactly two leave on the other side.",
        [
            column("without a dead band: the pulses overlap", without),
            column("with a dead band of 0.26 µm: one after the other", with_band),
        ],
        files=(
            "figure5_without_dead_band.csv",
            "figure5_without_dead_band_pulses.csv",
            "figure5_without_dead_band_micro.csv",
            "figure5_with_dead_band.csv",
            "figure5_with_dead_band_pulses.csv",
            "figure5_with_dead_band_micro.csv",
            "table1.csv",
        ),
    )


def column(title: str, data: dict) -> Column:
    """The forces of one case."""
    strips = forces(data["micro"], origin=data["onset"], limits=(0, 1.8e7))
    views = [View("impact", -5e-8, 1.1e-6), View("onset", -2e-9, 4e-8)]
    return Column(title, f"time after the first onset at {data['onset']:.12f} s", "s", strips, views)


if __name__ == "__main__":
    run_script(run, __doc__)
