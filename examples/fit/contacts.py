"""Stiffness and damping of the contacts from filmed positions: a fit with the FMU's own derivatives.

    python examples/fit/contacts.py [--fmu FILE] [--out FOLDER]

A cradle of soft balls is filmed for five seconds, with errors of 0.2 mm. Nobody sees a force, but each contact takes
a while and loses energy, so the balls come late and swing lower. The film is made here, with known values and a fixed
random seed.

`nc.fit` asks the FMU how the positions depend on the parameters through all contacts so far: the Jacobian is exact and
comes from the same run as the positions. Prints the true and the fitted values with their standard errors, and writes
them, with a plot, into the folder (out/fit).
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import diagrams
from support import command_line, ended, nc, parsed, print_rows, write_rows

LINEAR = {"contact.model": "powerLaw", "contact.dampingLaw": "kelvinVoigt", "contact.exponent": 1.0}
UNITS = {"contact.stiffness": "N/m", "contact.damping": "N.s/m"}
TRUE = {"contact.stiffness": 1e5, "contact.damping": 30.0}
GUESS = {"contact.stiffness": 1.6e5, "contact.damping": 12.0}
STOP, RATE = 5.0, 30  # s, frames per second
NOISE, SEED = 2e-4, 2002  # standard deviation of a position, m


def film(fmu: nc.Fmu, values: dict) -> np.ndarray:
    """The positions (m) that a camera sees in a run with these values of the fitted parameters, shape (frames,
    balls)."""
    return fmu.simulate(LINEAR | values, stop=STOP, step=1 / RATE, record=["x"])["x"][1:]


def save_plot(path: Path, fmu: nc.Fmu, track: dict, found: nc.Fit) -> None:
    """The outer balls as filmed, guessed and fitted, and how the parameters come closer."""
    guessed, fitted = film(fmu, GUESS), film(fmu, found.values)
    with diagrams(path, 3.6, width_ratios=[1.6, 1]) as (left, right):
        for ball, colour in ((0, "#0060a0"), (fmu.balls - 1, "#c04000")):
            dots = {"color": colour, "markersize": 3, "label": f"x[{ball + 1}], filmed"}
            left.plot(track["time"], 1e3 * track["x"][:, ball], ".", **dots)
            left.plot(track["time"], 1e3 * fitted[:, ball], color=colour, linewidth=0.8, label="fitted")
            grey = {"color": "#909090", "linewidth": 0.8, "label": "first guess"}
            left.plot(track["time"], 1e3 * guessed[:, ball], "--", **grey)
        left.set(xlabel="time, s", ylabel="position, mm")
        left.legend(fontsize=7, ncols=2)
        for name, colour in zip(TRUE, ("#208030", "#805080"), strict=True):
            off = [abs(values[name] / TRUE[name] - 1) for values in found.course]
            right.semilogy(off, "o-", color=colour, linewidth=1, markersize=4, label=name)
            error = found.errors[name] / found.values[name]
            right.axhline(error, color=colour, linestyle=":", linewidth=1, label="standard error")
        right.set(xlabel="iteration", ylabel="relative difference from the true value")
        right.xaxis.get_major_locator().set_params(integer=True)
        right.legend(fontsize=7)


def main() -> None:
    """Films, fits and shows."""
    options = parsed(command_line(__doc__.splitlines()[0], "fit", fmu="NewtonsCradle.fmi3.fmu"))
    fmu = nc.Fmu(options.fmu)
    exact = film(fmu, TRUE)
    filmed = exact + np.random.default_rng(SEED).normal(0.0, NOISE, exact.shape)
    track = {"time": np.arange(1, len(filmed) + 1) / RATE, "x": filmed}
    found = nc.fit(track, by=GUESS, fmu=fmu, values=LINEAR)
    print(f"{filmed.size} positions, {len(found.course) - 1} iterations, {found.runs} runs")
    head = ("parameter", "unit", "true", "guess", "fitted", "standard_error")
    columns = (UNITS, *(each.values() for each in (UNITS, TRUE, GUESS, found.values, found.errors)))
    rows = [dict(zip(head, row, strict=True)) for row in zip(*columns, strict=True)]
    write_rows(options.out / "contacts.csv", rows)
    print_rows(rows, digits=6)
    save_plot(options.out / "contacts.png", fmu, track, found)
    print(f"wrote {options.out / 'contacts.png'}")


if __name__ == "__main__":
    ended(main)
