"""Figure 3: 13 balls struck from both sides. The two waves of pulses cross and interfere."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_hex
from plots import COLOURS, Column, Strip, Trace, family
from support import Found, nc

OMEGA = np.sqrt(9.81)  # 1/s, sqrt(g/L)
SPEED = OMEGA * 1.0  # m/s, of a ball pulled 1 m aside when it is back at x = 0
QUARTER = np.pi / 2 / OMEGA  # s, when the lifted balls arrive
STOP = 0.65  # s, after the impacts and before the next ones
CLASSICAL = np.array([-1.0] * 2 + [0.0] * 8 + [1.0] * 3)  # speeds exchanged pair by pair: sorted


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """Both waves, each wave alone, and the classical model: instantaneous impacts, with waves that pass through each
    other."""
    fmu = fmus[13]
    both = simulate(fmu, nc.preset("figure3"), nc.Progress("Figure 3, 13 balls"))
    alone = [simulate(fmu, nc.preset("figure3") | nc.lifted(*side, n=13, amplitude=1.0)) for side in ((3, 0), (0, 2))]
    rigid = simulate(fmu, nc.preset("figure3") | {"contact.model": "rigid"})
    outcomes = {"compliant": velocities(both), "rigid": velocities(rigid)}
    departure = {name: np.abs(outcome - CLASSICAL).max() for name, outcome in outcomes.items()}
    peaks = np.array([result["F"].max(axis=0) for result in alone])
    interference = both["F"].max(axis=0) / peaks.max(axis=0)  # over the larger of the two waves alone
    found.save("figure3.csv", both.samples)
    found.save("figure3_pulses.csv", both.pulses)

    first = nc.impact_sequences(both.pulses)[0]
    found.conserved("3", both, SPEED)
    found.within("3", "first onset", first["onset"].min(), QUARTER, 1e-9, "s")
    found.between("3", "pulses", [*first["onset"], *first["release"]], 0.50, 0.58, "s")
    found.equal("3", "contacts that close", len(set(first["contact"].tolist())), 12)
    found.at_least("3", "overlapping neighbours", nc.overlapping_neighbours(first), 1)
    found.at_least("3", "peak where the waves cross / of one wave", interference.max(), 1.5)
    found.at_least("3", "departure from the classical outcome / speed", departure["compliant"], 0.1)
    times = rigid.pulses["release"] - rigid.pulses["onset"]
    found.at_most("3, rigid", "outcome - classical outcome / speed", departure["rigid"], 1e-12)
    found.at_most("3, rigid", "longest pulse", times.max(initial=0.0), 0.0, "s")
    found.at_most("3, rigid", "energy error", nc.energy_error(rigid), 1e-10)

    colours = LinearSegmentedColormap.from_list("contacts", [COLOURS[i] for i in (0, 2, 4, 1)], N=12)
    strips = family(both, "F", colours=list(map(to_hex, colours(range(12)))), limits=(0, 900))
    for strip in strips:
        strip.traces.extend(Trace(one["time"], one[strip.label], "#555555", "dashed") for one in alone)
    views = {"impacts": (0.5, 0.58), "whole run": (0.0, STOP), "crossing": (0.512, 0.536)}
    found.plot(
        "figure3",
        "Figure 3: two waves cross in a chain of 13 balls",
        "Three balls arrive from the left and two from the right, at the same time and with soft contacts (k/m = "
        "4e4 1/s²), so the pulses take 0.08 s to run through. Dashed: each wave alone. Where they meet, at contact "
        f"{np.argmax(interference) + 1}, the force is {interference.max():.1f} times that of either wave, and the "
        "pulses that come back out differ in shape and number from those that went in.",
        [Column(strips, views, "contact forces, left to right from top to bottom")],
        height=0.62,
    )
    balls = np.arange(1.0, 14.0)
    traces = [
        Trace(balls, CLASSICAL, COLOURS[5], "dashed", "exchanged pair by pair"),
        Trace(balls, outcomes["compliant"], COLOURS[1], "points", "compliant contacts"),
        Trace(balls, outcomes["rigid"], COLOURS[0], "points", "rigid contacts"),
    ]
    strip, views = Strip("velocity / impact speed", traces, limits=(-1.4, 1.6)), {"all balls": (0.5, 13.5)}
    found.plot(
        "figure3_outcome",
        "The velocities with which the balls leave",
        "The classical model exchanges velocities pair by pair: two balls leave to the left, three to the right, and "
        "the waves do not affect each other. With compliant contacts, whose pulses overlap, all 13 balls move.",
        [Column([strip], views, xlabel="ball", xunit="")],
        height=2.6,
    )


def simulate(fmu: nc.Fmu, values: dict, progress: nc.Progress | None = None) -> nc.Result:
    """A run in steps of half a millisecond, finer in the pulses."""
    return nc.resolved(fmu, values, stop=STOP, step=5e-4, per_pulse=64, progress=progress)


def velocities(result: nc.Result) -> np.ndarray:
    """Amplitudes of the balls after the impacts, with the sign of v at x = 0, relative to a lifted ball's amplitude."""
    phase = OMEGA * (result["time"][-1] - QUARTER)
    x, v = result["x"][-1], result["v"][-1]
    return (v * np.cos(phase) + OMEGA * x * np.sin(phase)) / SPEED
