"""A cradle on a cart, pulled by a voice coil: two FMUs coupled, and the error of the coupling measured.

    .venv/bin/python examples/mechatronics/couple.py

builds the plant's FMU from plant.c, or from plant.py by PythonFMU, runs both with the master in master.py and as an SSP
with FMPy, and leaves machine.ssp, presets.ssp, pictures and CSV files in out/mechatronics. A table of checks ends it.
"""

import json
from pathlib import Path

import numpy as np
import ssp
from machine import CRADLE, FREE, PARAMETERS, STOP, Fmus, opened, positions
from master import METHODS, REPEATING
from plots import COLOURS, Column, Strip, Trace
from reference import reference
from support import Found, command_line, ended, print_rows, tracked

COMMON = 0.2  # s, interval of the times at which runs are compared
STEPS = [0.1, 0.05, 0.025, 0.0125]  # s, the communication steps that are compared
ITERATED = 0.1  # s, the step for counting trials per step
COARSE = 0.01  # s, the step of the run that is shown
TEXTS = {
    "hold": "hold the last step's means",
    "extrapolate": "extrapolate by derivatives",
    "repeat": "repeat steps, means held",
    "smooth": "repeat, with input derivatives",
}
ENERGIES = ["balls", "cart", "lost", "put in"]
# Lowest order of convergence that each way of coupling must show.
ORDERS = {"FMPy": 0.9, "hold": 0.9, "extrapolate": 2.5, "repeat, at impacts": 1.8, "smooth, at impacts": 3.0}


def main() -> int:
    """Runs everything; returns 0 if every check passes, else 1."""
    parser = command_line(__doc__, "mechatronics")
    steps = {"type": int, "default": len(STEPS), "choices": range(2, len(STEPS) + 1)}
    parser.add_argument("--steps", **steps, help=f"how many communication steps to compare, of {STEPS} s")
    languages = {"choices": ["c", "python"], "default": "c"}
    parser.add_argument("--plant", **languages, help="language of the plant's FMU [default: %(default)s]")
    options = parser.parse_args()
    found = Found(options.out)
    with opened(options.fmu, options.out, options.plant) as fmus:
        run(fmus, found, STEPS[: options.steps])
        about = fmus.cradle.provenance() | {"cradle": CRADLE, "plant": PARAMETERS}
        about["plant guid"] = fmus.plant.description.guid
        (options.out / "about.json").write_text(json.dumps(about, indent=1), encoding="utf-8")
    return 0 if found.conclude() else 1


def run(fmus: Fmus, found: Found, steps: list[float]) -> None:
    """All experiments, with these communication steps (s)."""
    path = found.out / "machine.ssp"
    ssp.save_machine(path, fmus)
    ssp.save_presets(found.out / "presets.ssp", fmus)
    shown = at_work(fmus)
    found.save("machine.csv", shown)
    plot_machine(found, shown, free_momenta(fmus))
    errors = compare(fmus, path, steps)
    rows = [dict(zip(["h", *errors], row, strict=True)) for row in zip(steps, *errors.values(), strict=True)]
    found.save_rows("convergence.csv", rows)
    print("  coupling error in m, by communication step in s:")
    print_rows(rows)
    for name, order in ORDERS.items():
        # Slope of the error over the step, both logarithmic.
        found.at_least("order", name, np.polyfit(np.log(steps), np.log(errors[name]), 1)[0], order)
    check_momentum(fmus, found, path)
    check_sensor(found, shown)
    check_trials(fmus, found)
    whole = shown["balls"] + shown["cart"] + shown["lost"] - shown["put in"]
    found.at_most("energy", "of the whole, smooth, steps of 10 ms", np.ptp(whole), 1e-5, "J")
    plot_coupling(found, steps, errors, shown)


# ---------------------------------------------------------------- the machine at work


def at_work(fmus: Fmus) -> np.ndarray:
    """A run with fine steps, as a table."""
    of_cradle = {name: f"{name}[4]" for name in ("F", "F_mean", "impulse", "pulses")}
    of_plant = ["i", "sensed", "impacts"]
    names = ["time", *(f"x[{i}]" for i in range(1, 6)), "s", *of_plant, *of_cradle, *ENERGIES]
    rows = []
    with fmus.started("smooth") as master:
        for time in master.steps(STOP, COARSE):
            plant = map(master.plant.get, of_plant)
            cradle = map(master.cradle.get, of_cradle.values())
            rows.append((time, *positions(master), *plant, *cradle, *map(master.energies().get, ENERGIES)))
    return np.array(rows, dtype=[(name, "f8") for name in names])


def free_momenta(fmus: Fmus) -> np.ndarray:
    """Momenta without spring and damper to ground, with the method that has the most momentum in transit."""
    with fmus.started("hold", FREE) as master:
        rows = [(time, *master.momenta().values()) for time in master.steps(STOP, STEPS[-1])]
        names = ["time", *master.momenta()]
    return np.array(rows, dtype=[(name, "f8") for name in names])


def plot_machine(found: Found, table: np.ndarray, momenta: np.ndarray) -> None:
    """Cart, balls, current and energies over time; momenta of the free cart."""

    def strip(label, unit, names, table=table):
        return Strip(label, [Trace(table["time"], table[n], COLOURS[i], "line", n) for i, n in enumerate(names)], unit)

    names = momenta.dtype.names[1:]
    momentum = strip("momentum, free cart", "N.s", names, momenta)
    whole = sum(momenta[name] for name in names)
    momentum.traces.append(Trace(momenta["time"], whole, COLOURS[5], "dashed", "together"))
    strips = [
        strip("cart", "m", ["s"]),
        strip("balls", "m", ["x[1]", "x[3]", "x[5]"]),
        strip("current", "A", ["i"]),
        strip("energy", "J", ENERGIES),
        momentum,
    ]
    found.plot(
        "machine",
        "A cradle on a cart, started by a voice coil",
        "The coil, mounted on the cart, pulls ball 1 to the left with a current of the form sin² for 1.6 s, then "
        "lets go. Each click sends the last ball up and induces a voltage in the coil; the cart swings on its "
        "spring all the while. The energies of balls and cart and what the damper took add up to what the coil put "
        f"in. Bottom: no spring and damper to ground, last means held over steps of {STEPS[-1] * 1e3:g} ms. Once the "
        "impulse computed by one FMU but not yet applied by the other is included, no momentum is lost.",
        [Column(strips, {"all": (0.0, STOP)})],
        height=1.4,
    )


# ---------------------------------------------------------------- the error of the coupling


def compare(fmus: Fmus, path: Path, steps: list[float]) -> dict[str, list[float]]:
    """Largest deviation of a position from the reference, m, for each step; by way of coupling."""
    exact = reference(CRADLE, PARAMETERS, 5, COMMON * np.arange(round(STOP / COMMON) + 1))
    errors = {"FMPy": [ssp_error(path, h, exact) for h in steps]}
    ways = [(method, False) for method in METHODS] + [(method, True) for method in REPEATING]
    for method, at_impacts in tracked("Coupling error of four methods", ways):
        name = f"{method}, at impacts" if at_impacts else method
        errors[name] = [error(fmus, method, h, exact, at_impacts) for h in steps]
    return errors


def error(fmus: Fmus, method: str, h: float, exact: np.ndarray, at_impacts: bool) -> float:
    """The largest deviation in one run by the master, m."""
    with fmus.started(method) as master:
        numbers = (time / COMMON for time in master.steps(STOP, h, at_impacts=at_impacts))
        common = (round(number) for number in numbers if abs(number - round(number)) < 1e-11)
        return max(np.abs(positions(master) - exact[number]).max() for number in common)


def ssp_error(path: Path, h: float, exact: np.ndarray) -> float:
    """The largest deviation in one run by FMPy, m."""
    every = round(COMMON / h)
    rows = ssp.run(path, h)[every - 1 :: every]
    names = [*(f"cradle.x[{i}]" for i in range(1, 6)), "plant.s"]
    return float(np.abs(np.column_stack([rows[name] for name in names]) - exact[1:]).max())


# ---------------------------------------------------------------- what must hold exactly


def check_momentum(fmus: Fmus, found: Found, path: Path) -> None:
    """Without spring and damper to ground, the total momentum stays 0."""
    for method in METHODS:
        with fmus.started(method, FREE) as master:
            defect = max(abs(sum(master.momenta().values())) for _ in master.steps(STOP, COARSE))
        found.at_most("momentum", f"{method}, free cart", defect, 1e-10, "kg.m/s")
    free = ssp.run(path, COARSE, {f"plant.{name}": value for name, value in FREE.items()})
    # The cradle repeats in each step what the cart did in the step before; two impulses are still on their way.
    on_its_way = COARSE * (free["cradle.F_support_mean"] + free["plant.F_coil_mean"])[1:]
    balls = free["cradle.p_total"][1:] + 5.0 * free["plant.v"][:-1]
    whole = balls + 2.0 * free["plant.v"][1:] + on_its_way
    found.at_most("momentum", "FMPy, free cart", np.abs(whole).max(), 1e-10, "kg.m/s")


def check_sensor(found: Found, table: np.ndarray) -> None:
    """F_mean times step is the momentum that crossed the contact; F at the communication points is not."""
    passed = COARSE * table["F_mean"].cumsum()
    missed = abs(COARSE * table["F"].sum() / table["impulse"][-1] - 1.0)
    # The sensor lags by a step, because it gets a mean when the step is over.
    lag = np.abs(table["sensed"][1:] - table["impulse"][:-1]).max()
    found.at_most("sensor", "sum of F_mean h - impulse", np.abs(passed - table["impulse"]).max(), 1e-12, "N.s")
    found.at_least("sensor", "missed by sampling F, of 1", missed, 0.5)
    found.at_most("sensor", "what it has seen - impulse", lag, 1e-12, "N.s")
    found.equal("sensor", "impacts that it counted", table["impacts"][-1], table["pulses"][-2])


def check_trials(fmus: Fmus, found: Found) -> None:
    """Directional derivatives: fewer trials per step until both FMUs agree."""
    trials = []
    for newton in (False, True):
        with fmus.started("repeat", newton=newton) as master:
            count = sum(1 for _ in master.steps(STOP, ITERATED)) - 1
            trials.append(master.trials / count)
    what = f"trials per step of {ITERATED:g} s"
    found.at_least("repeat", f"{what}, fixed point", trials[0], 6)
    found.at_most("repeat", f"{what}, directional derivatives", trials[1], 3)


def plot_coupling(found: Found, steps: list[float], errors: dict, shown: np.ndarray) -> None:
    """The error over the step, and what a force sensor sees."""
    steps, traces = np.log10(steps), []
    names = {"FMPy": "SSP in FMPy"} | {method: TEXTS[method] for method in ("hold", "extrapolate")}
    names |= {f"{method}, at impacts": f"{TEXTS[method]}, t_next" for method in REPEATING}
    for (name, text), colour in zip(names.items(), COLOURS, strict=False):
        logarithm = np.log10(errors[name])
        traces += [Trace(steps, logarithm, colour, "line", text), Trace(steps, logarithm, colour, "points")]
    errors = Strip("log10 (error / m)", traces, limits=(-10.0, 1.5))
    time = shown["time"]
    sums = [
        Trace(time, COARSE * np.cumsum(shown["F_mean"]), COLOURS[0], "line", "sum of F_mean h"),
        Trace(time, shown["impulse"], COLOURS[4], "dashed", "what crossed the contact"),
        Trace(time, COARSE * np.cumsum(shown["F"]), COLOURS[1], "line", "sum of F h, sampled"),
    ]
    impulse = Strip("impulse on the last ball", sums, "N.s")
    views = {"all": (steps.min() - 0.05, steps.max() + 0.05)}
    found.plot(
        "coupling",
        "Coupling the cradle: error over step, and the force that a partner sees",
        "Left: largest deviation from the same machine integrated as one set of equations. Right: a pulse lasts "
        "microseconds, so the force at the communication points, every 10 ms, misses it. Its mean over the "
        "step carries its whole impulse.",
        [
            Column([errors], views, "error of the coupled run", "log10 (communication step / s)", ""),
            Column([impulse], {"all": (0.0, STOP)}, "what reaches a partner"),
        ],
        height=3.4,
    )


if __name__ == "__main__":
    ended(main)
