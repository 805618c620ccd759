"""Ten minutes of Figure 6's cradle: 427 clicks, as one step of the FMU and in steps of a host."""

import time

import numpy as np
from figure6 import AMPLITUDE, OMEGA, RECORD, SHIFT, growth, is_sequenced, swings
from plots import COLOURS, Column, Plot, Strip, Trace, View
from support import Check, Fmus, Outcome, conserved, equal, nc, run_script, save_csv, within

STOP = 600.0  # s


def run(fmus: Fmus, out) -> Outcome:
    """Runs it in steps of 25 ms, and in one step, which is timed."""
    result = fmus.five.simulate(
        nc.figure6(),
        stop=STOP,
        step=0.025,
        record=RECORD,
        progress=nc.Progress("Ten minutes in steps of 25 ms"),
    )
    with fmus.five.start(nc.figure6()) as single:
        begin = time.perf_counter()
        single.step_to(STOP)
        seconds = time.perf_counter() - begin
        pulses = single.pulses
    print(f"  as one fmi2DoStep: {seconds * 1e3:.0f} ms; the paper needed a couple of minutes")
    save_csv(out / "ten_minutes_pulses.csv", pulses)
    return Outcome(checks(result, pulses), [plot(result)])


def checks(result: nc.Result, pulses: np.ndarray) -> list[Check]:
    """All clicks are in order until the end, and the same in one step."""
    sequences = nc.impact_sequences(result.pulses)
    number, swing = growth(result)
    figure = "ten minutes"
    wanted = number[-1] * SHIFT / AMPLITUDE
    return [
        *conserved(figure, result, AMPLITUDE * OMEGA),
        equal(figure, "impact sequences, pulses", (len(sequences), len(result.pulses)), (427, 2562)),
        equal(figure, "sequences in proper order", sum(map(is_sequenced, sequences)), len(sequences)),
        equal(figure, "same pulses in a single step", bool(np.all(pulses == result.pulses)), True),
        within(figure, "middle ball's amplitude / others'", swing[-1] / swings(result)[-1].max(), wanted, 1e-3 * wanted),
    ]  # fmt: skip


def plot(result: nc.Result) -> Plot:
    """Ball 1, the middle ball, and the error of the energy balance."""
    time_, energy = result["time"], result["E_residual"] / result["E_total"][0]
    strips = [
        Strip("x[1]", "m", [Trace(time_, result["x[1]"], COLOURS[0])], (-1.15, 1.15)),
        Strip("x[3]", "m", [Trace(time_, result["x[3]"], COLOURS[2])]),
        Strip("energy error", "", [Trace(time_, energy, COLOURS[1])]),
    ]
    return Plot(
        "ten_minutes",
        "Ten minutes",
        "Figure 6's cradle for 600 s: 427 clicks of six pulses. The paper needed a couple of minutes of computer time for "
        "it; the FMU needs milliseconds. The middle ball's swing keeps growing linearly, and the solver's own energy error "
        "stays at the level of rounding.",
        [Column("", "time", "s", strips, [View("600 s", 0.0, STOP), View("last 20 s", 580.0, STOP)])],
        files=("ten_minutes_pulses.csv",),
    )


if __name__ == "__main__":
    run_script(run, __doc__)
