"""Figure 6: where the balls are. The middle ball should stand still, and very slowly does not."""

import numpy as np
from plots import COLOURS, Column, Plot, Strip, Trace, View
from support import Check, Fmus, Outcome, at_most, conserved, equal, nc, run_script, save_csv, within

OMEGA = np.sqrt(5.0)  # 1/s, sqrt(g/L)
AMPLITUDE = 1.0  # m
DEAD_BAND = 1.46e-7  # m
PULSE = np.pi / np.sqrt(2 * 2.9e14)  # s, length of a two-ball pulse at k/m = 2.9e14 1/s2
SHIFT = 2 * (DEAD_BAND + AMPLITUDE * OMEGA * PULSE / 2)  # m, what each sequence adds to the middle ball
SHOWN, STOP = 30.0, 240.0  # s; the paper shows the first and mentions the second
RECORD = [f"{name}[{i}]" for name in "xv" for i in range(1, 6)]
RECORD += ["E_total", "E_residual", "p_total", "F_support_mean"]


def run(fmus: Fmus, out) -> Outcome:
    """Four minutes in steps of 10 ms; writes figure6.csv and figure6_pulses.csv."""
    progress = nc.Progress(f"Figure 6, {STOP:g} s in steps of 10 ms")
    result = fmus.five.simulate(nc.figure6(), stop=STOP, record=RECORD, progress=progress)
    save_csv(out / "figure6.csv", result.samples[result["time"] <= SHOWN])
    save_csv(out / "figure6_pulses.csv", result.pulses)
    number, swing = growth(result)
    return Outcome(checks(result, number, swing), [plot(result), plot_growth(number, swing)])


def swings(result: nc.Result) -> np.ndarray:
    """Amplitude (m) with which each ball would swing on from each sample: shape (samples, balls)."""
    return np.hypot(result.stack("x"), result.stack("v") / OMEGA)


def growth(result: nc.Result) -> tuple[np.ndarray, np.ndarray]:
    """The middle ball's amplitude (m) after each impact sequence, with the sequences' numbers from 1."""
    ends = [sequence["release"].max() for sequence in nc.impact_sequences(result.pulses)]
    after = np.searchsorted(result["time"], ends)
    after = after[after < len(result["time"])]
    return np.arange(1, len(after) + 1), swings(result)[after, 2]


def checks(result: nc.Result, number: np.ndarray, swing: np.ndarray) -> list[Check]:
    """The paper's 1e-4 after 240 s, and the law behind it."""
    sequences = nc.impact_sequences(result.pulses)
    last = swings(result)[-1]
    linear = np.abs(swing / (number * SHIFT) - 1.0).max()
    return [
        *conserved("6", result, AMPLITUDE * OMEGA),
        within("6", "first onset", result.pulses["onset"][0], 0.702481538397, 1e-9, "s"),
        equal("6", f"impact sequences in {STOP:g} s", len(number), 171),
        equal("6", "sequences in proper order", sum(is_sequenced(s) for s in sequences), len(sequences)),
        within("6", f"middle ball's amplitude at {STOP:g} s / others'", last[2] / last.max(), 1.0e-4, 1e-6),
        at_most("6", "growth - 2 N (deadBand + v t_c/2), relative", linear, 1e-3),
    ]


def is_sequenced(sequence: np.ndarray) -> bool:
    """Six pulses in the order of Table 1 or its mirror image, none overlapping a neighbour."""
    table1 = [[2], [1, 3], [2, 4], [3]]
    mirrored = [[3], [2, 4], [1, 3], [2]]
    return nc.pulse_order(sequence) in (table1, mirrored) and nc.overlapping_neighbours(sequence) == 0


def plot(result: nc.Result) -> Plot:
    """One strip per ball, and the middle ball magnified."""
    time = result["time"]
    strips = [
        Strip(f"x[{i}]", "m", [Trace(time, result[f"x[{i}]"], COLOURS[i - 1])], (-1.15, 1.15))
        for i in range(1, 6)
    ]
    envelope = Trace(time, swings(result)[:, 2], COLOURS[5], "dashed")
    strips.append(Strip("x[3]", "m", [Trace(time, result["x[3]"], COLOURS[2]), envelope], (-1.5e-5, 1.5e-5)))
    return Plot(
        "figure6",
        "Figure 6: positions of the five balls",
        "Two balls swing while three wait. The middle ball, third from either side, should stand still. The bottom strip, "
        "magnified a hundred thousand times, shows that it does not quite: its amplitude (dashed) grows with each click. "
        "The pendulums are linearised: their period does not depend on the amplitude.",
        [Column("", "time", "s", strips, [View("30 s", 0.0, SHOWN), View("240 s", 0.0, STOP)])],
        files=("figure6.csv", "figure6_pulses.csv"),
        height=1.05,
    )


def plot_growth(number: np.ndarray, swing: np.ndarray) -> Plot:
    """The middle ball's amplitude over four minutes, against the law."""
    law = Trace(number.astype(float), number * SHIFT, COLOURS[5], "line", "2 N (dead band + v t_c/2)")
    measured = Trace(
        number[4::5].astype(float), swing[4::5], COLOURS[2], "points", "every fifth click, measured"
    )
    return Plot(
        "figure6_growth",
        "Figure 6, continued: how the middle ball starts to swing",
        f"Each click shifts the middle ball by {SHIFT * 1e6:.3f} µm, twice the sum of the dead band and half a pulse's travel. "
        "So its amplitude grows linearly with the number N of clicks. After 171 clicks in 240 s it is 1e-4 of the other "
        "balls', which is the number that the paper gives.",
        [Column("", "number of clicks N", "", [Strip("amplitude", "m", [law, measured], (0, 1.2e-4))],
                [View("all", 0.0, 175.0)])],
        height=2.6,
    )  # fmt: skip


if __name__ == "__main__":
    run_script(run, __doc__)
