"""Figure 4: ten seconds of contact forces. The pulses look like simultaneous spikes; they are not."""

import numpy as np
from figure5 import SPEED, STOP
from plots import Column, family
from support import Found, nc


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """Ten seconds as a host sees them, and the same run with samples in every pulse, to zoom in from ten seconds to one
    pulse."""
    values = nc.figure5()
    result = fmus[5].simulate(values, stop=STOP, progress=nc.Progress("Figure 4, 10 s in steps of 10 ms"))
    resolved = nc.resolved(fmus[5], values, stop=STOP, record=["F"], per_pulse=48)
    found.save("figure4.csv", result.samples)
    found.save("figure4_pulses.csv", result.pulses)

    clicks = nc.impact_sequences(result.pulses)
    spans = [click["release"].max() - click["onset"].min() for click in clicks]
    found.conserved("4", result, SPEED)
    found.within("4", "first onset", result.pulses["onset"][0], 0.702481589380, 1e-9, "s")
    found.equal("4", "impact sequences, pulses", (len(clicks), len(result.pulses)), (7, 42))
    found.at_most("4", "longest impact sequence", max(spans), 2e-6, "s")
    found.equal("4", "same pulses with steps of 5 ns", bool(np.all(result.pulses == resolved.pulses)), True)

    first, onset, length = clicks[0], clicks[0]["onset"].min(), spans[0]
    views = {
        "10 s": (0.0, STOP),
        "first click": (onset - 0.1 * length, onset + 1.2 * length),
        "first pulse": (first["onset"][0] - 2e-8, first["release"][0] + 2e-8),
        "10 ns": (onset - 1e-9, onset + 9e-9),
    }
    found.plot(
        "figure4",
        "Figure 4: contact forces over ten seconds",
        "Five balls, two pulled 1 m aside, dead band 0.26 µm. Each click of the cradle is a spike in every contact, "
        "all at once at this scale. Zoom into one, as Figure 5 does, and it comes apart: six pulses, one after the "
        "other, within a microsecond.",
        [Column(family(resolved, "F", limits=(0, 1.8e7)), views)],
    )
