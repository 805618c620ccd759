"""Figure 6: where the balls are. The middle ball should stand still, and very slowly does not."""

from time import perf_counter

import numpy as np
from figure5 import MIRRORED, ORDER
from plots import COLOURS, Column, Strip, Trace, family
from support import Found, nc

OMEGA = np.sqrt(5.0)  # 1/s, sqrt(g/L)
AMPLITUDE = 1.0  # m
DEAD_BAND = 1.46e-7  # m
PULSE = np.pi / np.sqrt(2 * 2.9e14)  # s, length of a two-ball pulse at k/m = 2.9e14 1/s2
SHIFT = 2 * (DEAD_BAND + AMPLITUDE * OMEGA * PULSE / 2)  # m, what each sequence adds to the middle ball's amplitude
SHOWN, MENTIONED, STOP = 30.0, 240.0, 600.0  # s: the paper shows the first, and mentions the others
RECORD = ["x", "v", "E_total", "E_residual", "p_total", "F_support_mean"]


def run(fmus: dict[int, nc.Fmu], found: Found) -> None:
    """Ten minutes in steps of 25 ms, and in one step, which is timed: the paper's 1e-4 after 240 s, the law behind it,
    and all clicks in order until the end."""
    progress = nc.Progress(f"Figure 6, {STOP:g} s in steps of 25 ms")
    values = nc.preset("figure6")
    result = fmus[5].simulate(values, stop=STOP, step=0.025, record=RECORD, progress=progress)
    with fmus[5].start(values) as single:
        begin = perf_counter()
        single.step_to(STOP)
        seconds = perf_counter() - begin
        pulses = single.pulses
    print(f"  as one fmi2DoStep: {seconds * 1e3:.0f} ms; the paper needed a couple of minutes")
    time, x3 = result["time"], result["x[3]"]
    found.save("figure6.csv", result.samples[time <= SHOWN])
    found.save("figure6_pulses.csv", pulses)

    sequences = nc.impact_sequences(result.pulses)
    ends = np.array([sequence["release"].max() for sequence in sequences])
    after = np.searchsorted(time, ends[ends <= time[-1]])
    number, swing = np.arange(1, len(after) + 1), swings(result)[after, 2]  # of the middle ball after each sequence
    separate = [sequence for sequence in sequences if not nc.overlapping_neighbours(sequence)]
    ordered = [sequence for sequence in separate if nc.pulse_order(sequence) in (ORDER, MIRRORED)]
    then = swings(result)[time <= MENTIONED][-1]
    found.conserved("6", result, AMPLITUDE * OMEGA)
    found.within("6", "first onset", pulses["onset"][0], 0.702481538397, 1e-9, "s")
    found.equal("6", f"impact sequences in {MENTIONED:g} s", sum(ends < MENTIONED), 171)
    found.equal("6", f"impact sequences, pulses in {STOP:g} s", (len(sequences), len(pulses)), (427, 2562))
    found.equal("6", "sequences in proper order", len(ordered), len(sequences))
    found.equal("6", "same pulses in a single step", bool(np.all(pulses == result.pulses)), True)
    found.within("6", f"middle ball's amplitude at {MENTIONED:g} s / others'", then[2] / then.max(), 1.0e-4, 1e-6)
    linear = np.abs(swing / (number * SHIFT) - 1.0).max()
    found.at_most("6", "growth - 2 N (deadBand + v t_c/2), relative", linear, 1e-3)

    envelope = Trace(time, swings(result)[:, 2], COLOURS[5], "dashed")
    strips = family(result, "x", limits=(-1.15, 1.15))
    strips.append(Strip("x[3]", [Trace(time, x3, COLOURS[2]), envelope], "m", (-1.5e-5, 1.5e-5)))
    found.plot(
        "figure6",
        "Figure 6: positions of the five balls",
        "Two balls swing while three wait. The middle ball, third from either side, should stand still. The bottom "
        "strip, magnified a hundred thousand times, shows that it does not quite: its amplitude (dashed) grows with "
        "each click. The pendulums are linearised: their period does not depend on the amplitude.",
        [Column(strips, {"30 s": (0.0, SHOWN), "240 s": (0.0, MENTIONED), "600 s": (0.0, STOP)})],
        height=1.05,
    )
    every = slice(4, None, 5)
    curves = [
        Trace(number.astype(float), number * SHIFT, COLOURS[5], "line", "2 N (dead band + v t_c/2)"),
        Trace(number[every] * 1.0, swing[every], COLOURS[2], "points", "every fifth click, measured"),
    ]
    strip, views = Strip("amplitude", curves, "m", (0, 2.6e-4)), {"all": (0.0, 430.0)}
    found.plot(
        "figure6_growth",
        "Figure 6, continued: how the middle ball starts to swing",
        f"Each click shifts the middle ball by {SHIFT * 1e6:.3f} µm, twice the sum of the dead band and half a "
        "pulse's travel. So its amplitude grows linearly with the number N of clicks. After 171 clicks in 240 s it "
        "is 1e-4 of the other balls', which is the number that the paper gives.",
        [Column([strip], views, xlabel="number of clicks N", xunit="")],
        height=2.6,
    )
    error = Trace(time, result["E_residual"] / result["E_total"][0], COLOURS[1])
    found.plot(
        "figure6_energy",
        "Figure 6, continued: ten minutes",
        "427 clicks of six pulses. The paper needed a couple of minutes of computer time for them; the FMU needs "
        "milliseconds. The solver's own energy error stays at the level of rounding.",
        [Column([Strip("energy error", [error])], {"600 s": (0.0, STOP)})],
    )


def swings(result: nc.Result) -> np.ndarray:
    """Amplitude (m) with which each ball would swing on from each sample: shape (samples, balls)."""
    return np.hypot(result["x"], result["v"] / OMEGA)
