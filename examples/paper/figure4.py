"""Figure 4: ten seconds of contact forces. The pulses look like simultaneous spikes; they are not."""

import numpy as np
from support import COLOURS, Check, at_most, equal, finish, nc, run_script, save_csv, stacked, within

STOP = 10.0  # s
OMEGA = np.sqrt(5.0)  # 1/s, sqrt(g/L)
SPEED = OMEGA * 1.0  # m/s, of a ball lifted by 1 m when it is back at x = 0


def run(fmu: nc.Fmu, out) -> list[Check]:
    """Simulates, writes figure4.png, figure4.csv and figure4_pulses.csv; returns the checks."""
    result = fmu.simulate(nc.figure5(), stop=STOP, progress=nc.Progress("Figure 4, 10 s in steps of 10 ms"))
    save_csv(out / "figure4.csv", result.samples)
    save_csv(out / "figure4_pulses.csv", result.pulses)
    draw(result, out / "figure4.png")
    sequences = nc.impact_sequences(result.pulses)
    momentum = np.abs(nc.momentum_of_sequences(result)).max() / SPEED
    spans = [s["release"].max() - s["onset"].min() for s in sequences]
    return [
        at_most("4", "energy error over 10 s", nc.energy_error(result), 1e-10),
        at_most("4", "momentum defect per sequence / m v", momentum, 1e-12),
        within("4", "first onset", result.pulses["onset"][0], 0.702481589380, 1e-9, "s"),
        equal("4", "impact sequences, pulses", (len(sequences), len(result.pulses)), (7, 42)),
        at_most("4", "longest impact sequence", max(spans), 2e-6, "s"),
    ]


def draw(result: nc.Result, path) -> None:
    """One strip per contact, a line from zero to the peak for each pulse of the log."""
    contacts = result.stack("F").shape[1]
    figure, axes = stacked(contacts, "Figure 4: contact forces over ten seconds")
    for i, axis in enumerate(axes[:, 0]):
        pulses = result.pulses[result.pulses["contact"] == i + 1]
        axis.vlines(pulses["onset"], 0, pulses["peak"] / 1e6, color=COLOURS[i], linewidth=1.4)
        axis.axhline(0, color=COLOURS[i], linewidth=0.8)
        axis.set(ylabel=f"F[{i + 1}] (MN)\nballs {i + 1}-{i + 2}", ylim=(0, 18), xlim=(0, STOP))
    axes[-1, 0].set_xlabel("time (s)")
    finish(
        figure,
        path,
        "Five balls, two lifted by 1 m, dead band 0.26 µm. Each click of the cradle is a spike in every contact, "
        "all at once at this scale. Figure 5 opens the first one: six pulses, one after the other, within a microsecond. "
        "The pulses fall between the communication points (10 ms); their height is the peak from the pulse log.",
    )


if __name__ == "__main__":
    run_script(run, __doc__)
