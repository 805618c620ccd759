"""Figure 6: where the balls are. The middle ball should stand still, and very slowly does not."""

import numpy as np
from support import COLOURS, Check, at_most, equal, finish, nc, run_script, save_csv, stacked, within

OMEGA = np.sqrt(5.0)  # 1/s, sqrt(g/L)
AMPLITUDE = 1.0  # m
DEAD_BAND = 1.46e-7  # m
PULSE = np.pi / np.sqrt(2 * 2.9e14)  # s, length of a two-ball pulse at k/m = 2.9e14 1/s2
SHIFT = 2 * (DEAD_BAND + AMPLITUDE * OMEGA * PULSE / 2)  # m, what each sequence adds to the middle ball


def run(fmu: nc.Fmu, out, seconds: float = 10.0) -> list[Check]:
    """Simulates, writes figure6.png, figure6.csv and figure6_pulses.csv; returns the checks."""
    progress = nc.Progress(f"Figure 6, {seconds:g} s in steps of 10 ms")
    result = fmu.simulate(nc.figure6(), stop=seconds, progress=progress)
    save_csv(out / "figure6.csv", result.samples)
    save_csv(out / "figure6_pulses.csv", result.pulses)
    swing = np.hypot(result["x[3]"], result["v[3]"] / OMEGA)
    draw(result, swing, out / "figure6.png")
    sequences = nc.impact_sequences(result.pulses)
    complete = sequences if sequences[-1]["release"].max() < seconds - 0.01 else sequences[:-1]
    defect = np.abs(nc.momentum_of_sequences(result)).max() / (AMPLITUDE * OMEGA)
    return [
        at_most("6", f"energy error over {seconds:g} s", nc.energy_error(result), 1e-10),
        at_most("6", "momentum defect per sequence / m v", defect, 1e-12),
        within("6", "first onset", result.pulses["onset"][0], 0.702481538397, 1e-9, "s"),
        equal("6", "sequences in proper order", sum(is_sequenced(s) for s in complete), len(complete)),
        within(
            "6",
            f"middle ball's amplitude after {len(complete)} sequences",
            swing[-1],
            len(complete) * SHIFT,
            1e-3 * len(complete) * SHIFT,
            "m",
        ),
    ]


def is_sequenced(sequence: np.ndarray) -> bool:
    """Six pulses in the order of Table 1 or its mirror image, none overlapping a neighbour."""
    table1 = [[2], [1, 3], [2, 4], [3]]
    mirrored = [[3], [2, 4], [1, 3], [2]]
    return nc.pulse_order(sequence) in (table1, mirrored) and nc.overlapping_neighbours(sequence) == 0


def draw(result: nc.Result, swing: np.ndarray, path) -> None:
    """One strip per ball, and the middle ball magnified."""
    time = result["time"]
    figure, axes = stacked(6, "Figure 6: positions of the five balls", height=1.05)
    for i, axis in enumerate(axes[:5, 0]):
        axis.plot(time, result[f"x[{i + 1}]"], color=COLOURS[i])
        axis.set(ylabel=f"x[{i + 1}] (m)", ylim=(-1.15, 1.15))
    last = axes[5, 0]
    last.plot(time, result["x[3]"] * 1e6, color=COLOURS[2])
    last.plot(time, swing * 1e6, color="#555555", linewidth=0.9, linestyle="--")
    last.set(ylabel="x[3] (µm)\nmagnified", xlabel="time (s)", xlim=(0, time[-1]))
    finish(
        figure,
        path,
        "Two balls swing and three wait; the middle ball, in turn the third of either side, should stand still. Bottom "
        f"strip, a million times magnified: each click shifts it by {SHIFT * 1e6:.3f} µm, twice the sum of the dead band and half "
        "a pulse's travel, so its amplitude (dashed) grows linearly, to 1e-4 of the others' after 240 s.",
    )


if __name__ == "__main__":
    run_script(run, __doc__, seconds=(10.0, "simulated time in s; the paper shows 30"))
