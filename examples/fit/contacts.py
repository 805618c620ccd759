"""Stiffness and damping of the contacts from filmed positions: a fit with the FMU's own derivatives.

    python examples/fit/contacts.py [--fmu FILE] [--out FOLDER]

A cradle of soft balls is filmed for five seconds, with errors of 0.2 mm. Nobody sees a force, but each contact takes
a while and loses energy, so the balls come late and swing lower. The film is made here, with known values and a fixed
random seed.

With `derivatives.of = run`, fmi3GetDirectionalDerivative answers how the positions depend on the parameters through
all contacts so far: the Jacobian is exact and comes from the same run as the positions. Prints the true and the
fitted values with their standard errors, and writes them, with a plot, into the folder (out/fit).
"""

import sys
from functools import cache
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import diagrams
from support import command_line, ended, nc, parsed, print_rows, write_rows

LINEAR = {"contact.model": "powerLaw", "contact.dampingLaw": "kelvinVoigt", "contact.exponent": 1.0}
UNITS = {"contact.stiffness": "N/m", "contact.damping": "N.s/m"}
FITTED = list(UNITS)
TRUE = np.array([1e5, 30.0])
GUESS = np.array([1.6e5, 12.0])
STOP, RATE = 5.0, 30  # s, frames per second
NOISE, SEED = 2e-4, 2002  # standard deviation of a position, m


def film(fmu: nc.Fmu, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a camera sees of a run with these values of the fitted parameters: positions (m; frames, balls), and their
    derivatives by the parameters."""
    positions, derivatives = [], []
    with fmu.start(LINEAR | dict(zip(FITTED, values, strict=True)) | {"derivatives.of": "run"}) as run:
        x, parameters = run.slave.references("x"), run.slave.references(*FITTED)
        for frame in range(1, round(STOP * RATE) + 1):
            run.step_to(frame / RATE)
            positions.append(run["x"])
            ask, seeds = run.slave.getDirectionalDerivative, np.eye(len(FITTED)).tolist()
            derivatives.append(np.transpose([ask(x, parameters, seed, fmu.balls) for seed in seeds]))
    return np.array(positions), np.array(derivatives)


def fit(fmu: nc.Fmu, filmed: np.ndarray, guess: np.ndarray) -> tuple[list[np.ndarray], np.ndarray, int]:
    """The parameters after each iteration, their relative standard errors, and the number of runs. Raises FmuError.

    SciPy varies the logarithms of the parameters, which keeps these positive.
    """
    course = [guess]
    seen = cache(lambda *logarithms: film(fmu, np.exp(logarithms)))
    found = least_squares(
        lambda logarithms: (seen(*logarithms)[0] - filmed).ravel(),
        np.log(guess),
        lambda logarithms: seen(*logarithms)[1].reshape(-1, len(guess)) * np.exp(logarithms),
        callback=lambda logarithms: course.append(np.exp(logarithms)),
    )
    if np.linalg.matrix_rank(found.jac) < len(guess):
        why = "the positions do not tell these parameters apart: no contact has closed, or none is damped"
        raise nc.FmuError(f"{fmu.path}: {why}")
    if not found.success:
        raise nc.FmuError(f"{fmu.path}: {found.message}")
    if found.cost >= 0.5 * np.sum((seen(*np.log(guess))[0] - filmed) ** 2):
        raise nc.FmuError(f"{fmu.path}: no step along the derivatives makes the sum of squares smaller")
    variance = 2 * found.cost / (filmed.size - len(guess))
    errors = np.sqrt(variance * np.diag(np.linalg.inv(found.jac.T @ found.jac)))
    return course, errors, seen.cache_info().misses


def save_plot(path: Path, fmu: nc.Fmu, filmed: np.ndarray, course: list, errors: np.ndarray) -> None:
    """The outer balls as filmed, guessed and fitted, and how the parameters come closer."""
    time = np.arange(1, len(filmed) + 1) / RATE
    guessed, fitted = film(fmu, course[0])[0], film(fmu, course[-1])[0]
    with diagrams(path, 3.6, width_ratios=[1.6, 1]) as (left, right):
        for ball, colour in ((0, "#0060a0"), (fmu.balls - 1, "#c04000")):
            left.plot(time, 1e3 * filmed[:, ball], ".", color=colour, markersize=3, label=f"x[{ball + 1}], filmed")
            left.plot(time, 1e3 * fitted[:, ball], color=colour, linewidth=0.8, label="fitted")
            left.plot(time, 1e3 * guessed[:, ball], "--", color="#909090", linewidth=0.8, label="first guess")
        left.set(xlabel="time, s", ylabel="position, mm")
        left.legend(fontsize=7, ncols=2)
        for i, (name, colour) in enumerate(zip(FITTED, ("#208030", "#805080"), strict=True)):
            off = [abs(values[i] / TRUE[i] - 1) for values in course]
            right.semilogy(off, "o-", color=colour, linewidth=1, markersize=4, label=name)
            right.axhline(errors[i], color=colour, linestyle=":", linewidth=1, label="standard error")
        right.set(xlabel="iteration", ylabel="relative difference from the true value")
        right.xaxis.get_major_locator().set_params(integer=True)
        right.legend(fontsize=7)


def main() -> None:
    """Films, fits and shows."""
    options = parsed(command_line(__doc__.splitlines()[0], "fit", fmu="NewtonsCradle.fmi3.fmu"))
    fmu = nc.Fmu(options.fmu)
    if (version := fmu.description.fmiVersion) == "2.0":
        raise nc.FmuError(f"{fmu.path} is of FMI {version}; needed: NewtonsCradle of FMI 3.0")
    exact, _ = film(fmu, TRUE)
    filmed = exact + np.random.default_rng(SEED).normal(0.0, NOISE, exact.shape)
    course, relative, runs = fit(fmu, filmed, GUESS)
    print(f"{filmed.size} positions, {len(course) - 1} iterations, {runs} runs")
    head = ("parameter", "unit", "true", "guess", "fitted", "standard_error")
    columns = (UNITS, UNITS.values(), TRUE, GUESS, course[-1], relative * course[-1])
    rows = [dict(zip(head, row, strict=True)) for row in zip(*columns, strict=True)]
    write_rows(options.out / "contacts.csv", rows)
    print_rows(rows, digits=6)
    save_plot(options.out / "contacts.png", fmu, filmed, course, relative)
    print(f"wrote {options.out / 'contacts.png'}")


if __name__ == "__main__":
    ended(main)
