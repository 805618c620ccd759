"""Figure 4: ten seconds of contact forces. The pulses look like simultaneous spikes; they are not."""

import numpy as np
from plots import Column, Plot, View, forces
from support import Check, Fmus, Outcome, at_most, conserved, equal, nc, run_script, save_csv, within

STOP = 10.0  # s
SPEED = np.sqrt(5.0) * 1.0  # m/s, sqrt(g/L) times amplitude: of a lifted ball when it is back at x = 0


def run(fmus: Fmus, out) -> Outcome:
    """Ten seconds as a host sees them, and once more with points in every pulse."""
    values = nc.figure5()
    result = fmus.five.simulate(values, stop=STOP, progress=nc.Progress("Figure 4, 10 s in steps of 10 ms"))
    names = ["F[1]", "F[2]", "F[3]", "F[4]"]
    resolved = nc.resolved(fmus.five, values, stop=STOP, record=names, per_pulse=48)
    save_csv(out / "figure4.csv", result.samples)
    save_csv(out / "figure4_pulses.csv", result.pulses)
    return Outcome(checks(result, resolved), [plot(resolved)])


def checks(result: nc.Result, resolved: nc.Result) -> list[Check]:
    """Seven clicks of six pulses each; the pulses do not depend on the communication step."""
    sequences = nc.impact_sequences(result.pulses)
    spans = [s["release"].max() - s["onset"].min() for s in sequences]
    return [
        *conserved("4", result, SPEED),
        within("4", "first onset", result.pulses["onset"][0], 0.702481589380, 1e-9, "s"),
        equal("4", "impact sequences, pulses", (len(sequences), len(result.pulses)), (7, 42)),
        at_most("4", "longest impact sequence", max(spans), 2e-6, "s"),
        equal("4", "same pulses with steps of 5 ns", bool(np.all(result.pulses == resolved.pulses)), True),
    ]


def plot(resolved: nc.Result) -> Plot:
    """One strip per contact, from ten seconds down to one pulse."""
    first = nc.impact_sequences(resolved.pulses)[0]
    onset, length = first["onset"].min(), first["release"].max() - first["onset"].min()
    views = [
        View("10 s", 0.0, STOP),
        View("first click", onset - 0.1 * length, onset + 1.2 * length),
        View("first pulse", first["onset"][0] - 2e-8, first["release"][0] + 2e-8),
        View("10 ns", onset - 1e-9, onset + 9e-9),
    ]
    return Plot(
        "figure4",
        "Figure 4: contact forces over ten seconds",
        "Five balls, two lifted by 1 m, dead band 0.26 µm. Each click of the cradle is a spike in every contact, "
        "all at once at this scale. Zoom into one, as Figure 5 does, and it comes apart: six pulses, one after the "
        "other, within a microsecond.",
        [Column("", "time", "s", forces(resolved, limits=(0, 1.8e7)), views)],
        files=("figure4.csv", "figure4_pulses.csv"),
    )


if __name__ == "__main__":
    run_script(run, __doc__)
