"""Parameters of a cradle by what was measured: a fit by least squares with the FMU's own derivatives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .errors import FmuError, InvalidValue, needed, optional
from .fmu import Fmu
from .pulses import Array
from .run.model import Values

PROMISE = 0.01  # of the sum of squares, or of what a first step along right derivatives would take from it


@dataclass(frozen=True)
class Fit:
    """`values`: the parameters found, by name; `errors`: their standard errors; `rms`: of what remains, in the unit of
    what was measured; `course`: the parameters after each iteration; `runs`: how many there were."""

    values: dict[str, float]
    errors: dict[str, float]
    rms: float
    course: list[dict[str, float]]
    runs: int


def seen(
    fmu: Fmu, values: Values, names: Sequence[str], times: Sequence[float], by: Sequence[str]
) -> tuple[Array, Array]:
    """These variables of a run at these times (s), shape (times, variables), and their derivatives by parameters, shape
    (times, variables, parameters). Raises FmuError, InvalidValue, UnknownName."""
    found, derivatives = [], []
    with fmu.start({**values, "derivatives.of": "run"}) as run:
        record = run.fmu.names(names)
        for time in times:
            if time > run.time:
                run.step_to(time)
            found.append([run.get(name) for name in record])
            derivatives.append(run.derivative(record, by))
    return np.array(found), np.array(derivatives)


def fit(
    track: Mapping[str, Any], by: Sequence[str] | Mapping[str, float], *, fmu: Fmu, values: Values | None = None
) -> Fit:
    """The parameters `by` with which a run comes closest to what was measured, by least squares.

    `track`: `time` (s, rising, after 0) and what was measured then, by name: a dict, a data frame or a result, arrays
    as a whole or by element. `by`: names of parameters that are not 0, with first guesses if it is a dict; otherwise
    the guesses are in `values`, or in the FMU, which must be of FMI 3.0. `values`: what else is set at the start.
    Raises FmuError where the track does not determine the parameters, InvalidValue, UnknownName, and PackageMissing
    without SciPy.
    """
    optimize = optional("scipy.optimize", "fit")
    if fmu.fmi2:
        raise FmuError(f"{fmu.path} is of FMI 2.0; a fit needs FMI 3.0, as `nc.build(fmi=3)` makes it")
    if hasattr(track, "to_dict") and hasattr(track, "columns"):
        track = {name: track[name].to_numpy() for name in track.columns}
    needed("track", track, Mapping, 'a dict such as {"time": [...], "x": [...]}')
    given = fmu.settings(values or {})
    if isinstance(by, Mapping):
        guesses = fmu.settings(by)
    else:
        guesses = {name: given.get(name, fmu.built_with(name)) for name in fmu.names(by)}
    names, guess = list(guesses), np.array(list(guesses.values()), dtype=float)
    if not names or (guess == 0.0).any() or "time" not in track or len(track) < 2:
        raise InvalidValue(
            "track needs `time` and something else, and `by` at least one parameter with a guess that is not 0"
        )
    measured = [name for name in track if name != "time"]
    times = np.asarray(track["time"], dtype=float).tolist()
    filmed = np.column_stack([np.asarray(track[name], dtype=float) for name in measured])

    # SciPy varies the logarithms of the parameters over their guesses, which keeps their signs.
    @lru_cache(maxsize=8)
    def at(*logarithms: float) -> tuple[Array, Array]:
        return seen(fmu, {**given, **dict(zip(names, guess * np.exp(logarithms), strict=True))}, measured, times, names)

    def residuals(logarithms: Array) -> Array:
        left: Array = at(*logarithms)[0] - filmed
        return left.ravel()

    def jacobian(logarithms: Array) -> Array:
        by_parameter: Array = at(*logarithms)[1].reshape(-1, len(guess)) * (guess * np.exp(logarithms))
        return by_parameter

    def keep(logarithms: Array) -> None:
        course.append(dict(zip(names, (guess * np.exp(logarithms)).tolist(), strict=True)))

    course = [dict(guesses)]
    begin = np.zeros(len(guess))
    found = optimize.least_squares(residuals, begin, jacobian, callback=keep)
    if np.linalg.matrix_rank(found.jac) < len(guess):
        raise FmuError(f"{fmu.path}: what was measured does not tell these parameters apart: {', '.join(names)}")
    if not found.success:
        raise FmuError(f"{fmu.path}: {found.message}")
    cost = 0.5 * np.sum(residuals(begin) ** 2)
    promised = jacobian(begin) @ np.linalg.lstsq(jacobian(begin), residuals(begin))[0]
    gain = 0.5 * np.sum(promised**2)
    if gain > PROMISE * cost and cost - found.cost < PROMISE * gain:
        raise FmuError(f"{fmu.path}: no step along the derivatives makes the sum of squares smaller")
    best = guess * np.exp(found.x)
    left = filmed.size - len(guess)
    variance = 2.0 * found.cost / max(left, 1)
    errors = np.abs(best) * np.sqrt(variance * np.diag(np.linalg.inv(found.jac.T @ found.jac)))
    rms = float(np.sqrt(2.0 * found.cost / filmed.size))
    values, uncertain = (dict(zip(names, numbers.tolist(), strict=True)) for numbers in (best, errors))
    return Fit(values, uncertain, rms, course, at.cache_info().misses)
