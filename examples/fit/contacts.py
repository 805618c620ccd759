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
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import diagrams
from support import command_line, nc, parsed, write_rows

LINEAR = {"contact.model": "powerLaw", "contact.dampingLaw": "kelvinVoigt", "contact.exponent": 1.0}
UNITS = {"contact.stiffness": "N/m", "contact.damping": "N.s/m"}
FITTED = list(UNITS)
TRUE = np.array([1e5, 30.0])
GUESS = np.array([1.6e5, 12.0])
STOP, RATE = 5.0, 30  # s, frames per second
NOISE, SEED = 2e-4, 2002  # standard deviation of a position, m
MOST_ITERATIONS, MOST_HALVINGS = 20, 10
CLOSE = 1e-6  # relative change of the parameters at which the fit ends


class Camera:
    """The FMU, and what a camera sees of its runs."""

    def __init__(self, path: Path) -> None:
        self.fmu = nc.Fmu(path)
        model, version = self.fmu.description.modelName, self.fmu.description.fmiVersion
        if not version.startswith("3."):
            what = f"the model {model} of FMI {version}"
            raise RuntimeError(f"{path} is {what}; needed: NewtonsCradle of FMI 3.0 for co-simulation")
        if self.fmu.balls < 2:
            raise RuntimeError(f"{path} has one ball, which touches no other; needed: two or more")
        self.runs = 0

    def film(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A run with these values of the fitted parameters: positions (m; frames, balls), and their derivatives by
        the parameters."""
        self.runs += 1
        positions, derivatives = [], []
        start = dict(zip(FITTED, values, strict=True)) | {"derivatives.of": "run"}
        with self.fmu.start(LINEAR | start) as run:
            x, parameters = run.slave.references("x"), run.slave.references(*FITTED)
            for frame in range(1, round(STOP * RATE) + 1):
                run.step_to(frame / RATE)
                positions.append(run["x"])
                along = [
                    run.slave.getDirectionalDerivative(x, parameters, list(one), self.fmu.balls)
                    for one in np.eye(len(FITTED))
                ]
                derivatives.append(np.transpose(along))
        return np.array(positions), np.array(derivatives)


def fit(camera: Camera, filmed: np.ndarray, guess: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """The parameters after each iteration, and their relative standard errors. Raises RuntimeError.

    Gauss and Newton in the logarithms of the parameters, which keeps them positive. A step that makes the sum of
    squares larger is halved.
    """

    def linearized(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        seen, derivatives = camera.film(values)
        return (filmed - seen).ravel(), derivatives.reshape(-1, len(FITTED)) * values

    course = [guess]
    misfit, slopes = linearized(guess)
    for _ in range(MOST_ITERATIONS):
        if np.linalg.matrix_rank(slopes) < len(FITTED):
            raise RuntimeError(
                "the positions do not tell these parameters apart: no contact has closed, or none is damped"
            )
        step = np.linalg.lstsq(slopes, misfit, rcond=None)[0]
        if np.abs(step).max() < CLOSE:
            break
        for _ in range(MOST_HALVINGS):
            trial = course[-1] * np.exp(step)
            new_misfit, new_slopes = linearized(trial)
            if new_misfit @ new_misfit <= misfit @ misfit:
                break
            step = step / 2
        else:
            raise RuntimeError("no step along the derivatives makes the sum of squares smaller")
        course.append(trial)
        misfit, slopes = new_misfit, new_slopes
    else:
        raise RuntimeError(f"the fit has not ended after {MOST_ITERATIONS} iterations")
    variance = misfit @ misfit / (len(misfit) - len(FITTED))
    return course, np.sqrt(variance * np.diag(np.linalg.inv(slopes.T @ slopes)))


def save_plot(path: Path, camera: Camera, filmed: np.ndarray, course: list, errors: np.ndarray) -> None:
    """The outer balls as filmed, guessed and fitted, and how the parameters come closer."""
    time = np.arange(1, len(filmed) + 1) / RATE
    guessed, fitted = camera.film(course[0])[0], camera.film(course[-1])[0]
    with diagrams(path, 3.6, width_ratios=[1.6, 1]) as (left, right):
        for ball, colour in ((0, "#0060a0"), (camera.fmu.balls - 1, "#c04000")):
            label = f"x[{ball + 1}], filmed"
            left.plot(time, 1e3 * filmed[:, ball], ".", color=colour, markersize=3, label=label)
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
    try:
        camera = Camera(options.fmu)
        exact = camera.film(TRUE)[0]
        filmed = exact + np.random.default_rng(SEED).normal(0.0, NOISE, exact.shape)
        camera.runs = 0
        course, relative = fit(camera, filmed, GUESS)
    except RuntimeError as reason:
        sys.exit(str(reason))
    print(f"{filmed.size} positions, {len(course) - 1} iterations, {camera.runs} runs")
    print(f"{'parameter':20} {'unit':6} {'true':>8} {'guess':>8} {'fitted':>10} {'error':>8} {'off by':>12}")
    rows = list(zip(UNITS, UNITS.values(), TRUE, GUESS, course[-1], relative * course[-1], strict=True))
    for name, unit, true, guess, found, error in rows:
        off = f"{(found - true) / error:+.1f} errors"
        print(f"{name:20} {unit:6} {true:8g} {guess:8g} {found:10.6g} {error:8.2g} {off:>12}")
    head = ("parameter", "unit", "true", "guess", "fitted", "standard_error")
    write_rows(options.out / "contacts.csv", [head, *rows])
    save_plot(options.out / "contacts.png", camera, filmed, course, relative)
    print(f"wrote {options.out / 'contacts.png'}")


if __name__ == "__main__":
    main()
