"""Ten minutes of Figure 6's cradle: 427 clicks, as one step of the FMU and in steps of a host."""

import time

import numpy as np
from figure6 import AMPLITUDE, OMEGA, RECORD, SHIFT, growth, is_sequenced, swings
from plots import COLOURS, Column, Strip, Trace
from support import Fmus, Found, nc

STOP = 600.0  # s


def run(fmus: Fmus, found: Found) -> None:
    """In steps of 25 ms, and in one step, which is timed: all clicks are in order until the end, and the same in one
    step."""
    progress = nc.Progress("Ten minutes in steps of 25 ms")
    result = fmus.five.simulate(nc.preset("figure6"), stop=STOP, step=0.025, record=RECORD, progress=progress)
    with fmus.five.start(nc.preset("figure6")) as single:
        begin = time.perf_counter()
        single.step_to(STOP)
        seconds = time.perf_counter() - begin
        pulses = single.pulses
    print(f"  as one fmi2DoStep: {seconds * 1e3:.0f} ms; the paper needed a couple of minutes")
    found.save("ten_minutes_pulses.csv", pulses)

    sequences = nc.impact_sequences(result.pulses)
    number, swing = growth(result)
    figure, wanted = "ten minutes", number[-1] * SHIFT / AMPLITUDE
    found.conserved(figure, result, AMPLITUDE * OMEGA)
    found.equal(figure, "impact sequences, pulses", (len(sequences), len(result.pulses)), (427, 2562))
    found.equal(figure, "sequences in proper order", sum(map(is_sequenced, sequences)), len(sequences))
    found.equal(figure, "same pulses in a single step", bool(np.all(pulses == result.pulses)), True)
    amplitude = swing[-1] / swings(result)[-1].max()
    found.within(figure, "middle ball's amplitude / others'", amplitude, wanted, 1e-3 * wanted)

    times, energy = result["time"], result["E_residual"] / result["E_total"][0]
    strips = [
        Strip("x[1]", [Trace(times, result["x[1]"], COLOURS[0])], "m", (-1.15, 1.15)),
        Strip("x[3]", [Trace(times, result["x[3]"], COLOURS[2])], "m"),
        Strip("energy error", [Trace(times, energy, COLOURS[1])]),
    ]
    found.plot(
        "ten_minutes",
        "Ten minutes",
        "Figure 6's cradle for 600 s: 427 clicks of six pulses. The paper needed a couple of minutes of computer "
        "time for it; the FMU needs milliseconds. The middle ball's swing keeps growing linearly, and the solver's "
        "own energy error stays at the level of rounding.",
        [Column(strips, {"600 s": (0.0, STOP), "last 20 s": (580.0, STOP)})],
    )
