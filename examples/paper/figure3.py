"""Figure 3: 13 balls struck from both sides. The two waves of pulses cross and interfere."""

import numpy as np
from plots import COLOURS, Column, Plot, Strip, Trace, View, forces
from support import (
    Check,
    Fmus,
    Outcome,
    at_least,
    at_most,
    between,
    conserved,
    equal,
    nc,
    run_script,
    save_csv,
    within,
)

OMEGA = np.sqrt(9.81)  # 1/s, sqrt(g/L)
SPEED = OMEGA * 1.0  # m/s, of a ball lifted by 1 m when it is back at x = 0
QUARTER = np.pi / 2 / OMEGA  # s, when the lifted balls arrive
STOP = 0.65  # s, after the impacts and before the next ones
CLASSICAL = np.array([-1.0] * 2 + [0.0] * 8 + [1.0] * 3)  # speeds exchanged pair by pair: sorted


def run(fmus: Fmus, out) -> Outcome:
    """Both waves, each wave alone, and rigid contacts where the FMU has them."""
    fmu = fmus.thirteen
    both = simulate(fmu, nc.figure3(), "Figure 3, 13 balls")
    alone = [simulate(fmu, nc.figure3() | nc.lifted(*side, n=13)) for side in ((3, 0), (0, 2))]
    save_csv(out / "figure3.csv", both.samples)
    save_csv(out / "figure3_pulses.csv", both.pulses)
    checks = checks_compliant(both, alone)
    outcomes = {"compliant": velocities(both)}
    if "rigid" in fmu.items("contact.model"):
        rigid = simulate(fmu, nc.figure3() | {"contact.model": fmu.items("contact.model")["rigid"]})
        outcomes["rigid"] = velocities(rigid)
        checks += checks_rigid(rigid, outcomes["rigid"])
    return Outcome(checks, [plot_forces(both, alone), plot_velocities(outcomes)])


def simulate(fmu: nc.Fmu, values: dict, label: str | None = None) -> nc.Result:
    """A run in steps of half a millisecond, finer in the pulses."""
    progress = nc.Progress(label) if label else None
    return nc.resolved(fmu, values, stop=STOP, step=5e-4, per_pulse=64, progress=progress)


def velocities(result: nc.Result) -> np.ndarray:
    """Amplitudes of the balls after the impacts, with the sign of v at x = 0, divided by that of a lifted ball."""
    phase = OMEGA * (result["time"][-1] - QUARTER)
    x, v = result.stack("x")[-1], result.stack("v")[-1]
    return (v * np.cos(phase) + OMEGA * x * np.sin(phase)) / SPEED


def interference(both: nc.Result, alone: list[nc.Result]) -> np.ndarray:
    """Largest force of each contact, divided by the larger of those of the two waves alone."""
    peaks = np.array([result.stack("F").max(axis=0) for result in alone])
    return both.stack("F").max(axis=0) / peaks.max(axis=0)


def checks_compliant(both: nc.Result, alone: list[nc.Result]) -> list[Check]:
    """The paper's time span, the overlap, and forces that neither wave has by itself."""
    first = nc.impact_sequences(both.pulses)[0]
    departure = np.abs(velocities(both) - CLASSICAL).max()
    return [
        *conserved("3", both, SPEED),
        within("3", "first onset", first["onset"].min(), QUARTER, 1e-9, "s"),
        between("3", "pulses", [*first["onset"], *first["release"]], 0.50, 0.58, "s"),
        equal("3", "contacts that close", len(set(first["contact"].tolist())), 12),
        at_least("3", "overlapping neighbours", nc.overlapping_neighbours(first), 1),
        at_least("3", "peak where the waves cross / of one wave", interference(both, alone).max(), 1.5),
        at_least("3", "departure from the classical outcome / speed", departure, 0.1),
    ]


def checks_rigid(rigid: nc.Result, outcome: np.ndarray) -> list[Check]:
    """The classical model: the impacts are instantaneous, and the waves pass through each other unchanged."""
    times = rigid.pulses["release"] - rigid.pulses["onset"]
    return [
        at_most("3, rigid", "outcome - classical outcome / speed", np.abs(outcome - CLASSICAL).max(), 1e-12),
        at_most("3, rigid", "longest pulse", times.max(initial=0.0), 0.0, "s"),
        at_most("3, rigid", "energy error", nc.energy_error(rigid), 1e-10),
    ]


def plot_forces(both: nc.Result, alone: list[nc.Result]) -> Plot:
    """One strip per contact; dashed, the force of each wave alone."""
    strips = forces(both, nc.look.series(12), limits=(0, 900))
    for strip in strips:
        strip.traces.extend(Trace(one["time"], one[strip.label], "#555555", "dashed") for one in alone)
    meeting = int(np.argmax(interference(both, alone))) + 1
    return Plot(
        "figure3",
        "Figure 3: two waves cross in a chain of 13 balls",
        "Three balls arrive from the left and two from the right, at the same time and with soft contacts "
        "(k/m = 4e4 1/s²), so the pulses take 0.08 s to run through. Dashed: each wave alone. Where they "
        f"meet, at contact {meeting}, the force is {interference(both, alone).max():.1f} times that of either wave, "
        "and the pulses that come back out differ in shape and number from those that went in.",
        [
            Column(
                "contact forces, left to right from top to bottom",
                "time",
                "s",
                strips,
                [View("impacts", 0.5, 0.58), View("whole run", 0.0, STOP), View("crossing", 0.512, 0.536)],
            )
        ],
        files=("figure3.csv", "figure3_pulses.csv"),
        height=0.62,
    )


def plot_velocities(outcomes: dict) -> Plot:
    """Velocity over number of ball: the classical model's outcome, and what the FMU's contacts gave."""
    balls = np.arange(1.0, 14.0)
    traces = [
        Trace(balls, CLASSICAL, COLOURS[5], "dashed", "exchanged pair by pair"),
        Trace(balls, outcomes["compliant"], COLOURS[1], "points", "compliant contacts"),
    ]
    if "rigid" in outcomes:
        traces.append(Trace(balls, outcomes["rigid"], COLOURS[0], "points", "rigid contacts"))
    strip = Strip("velocity / impact speed", "", traces, (-1.4, 1.6))
    return Plot(
        "figure3_outcome",
        "The velocities with which the balls leave",
        "The classical model exchanges velocities pair by pair: two balls leave to the left, three to the right, and "
        "the waves do not affect each other. With compliant contacts, whose pulses overlap, all 13 balls move.",
        [Column("", "ball", "", [strip], [View("all balls", 0.5, 13.5)])],
        height=2.6,
    )


if __name__ == "__main__":
    run_script(run, __doc__)
