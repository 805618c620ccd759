"""Fits parameters of a cradle to measurements, by least squares with the FMU's own derivatives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .building import build
from .errors import FmuError, InvalidValue, needed, optional, shown
from .fmu import Fmu
from .pulses import Array
from .run.model import Values

PROMISE = 0.01  # least share: of a predicted reduction in the sum of squares that counts, and of the reduction reached


@dataclass(frozen=True)
class Fit:
    """`values`: the parameters found, by name; `errors`: their standard errors; `rms`: of the residuals, in the unit of
    the measurements; `course`: the parameters after each iteration, the guess first; `runs`: how many runs were
    made."""

    values: dict[str, float]
    errors: dict[str, float]
    rms: float
    course: list[dict[str, float]]
    runs: int


def seen(
    fmu: Fmu, values: Values, names: Sequence[str], times: Sequence[float], by: Sequence[str]
) -> tuple[Array, Array]:
    """Runs the FMU. Returns the variables `names` at these times (s), shape (times, variables), and their derivatives
    by the parameters `by`, shape (times, variables, parameters). Raises FmuError, InvalidValue, UnknownName."""
    found, derivatives = [], []
    with fmu.start({**values, "derivatives.of": "run"}) as run:
        record = run.fmu.names(names)
        for time in times:
            if time > run.time:
                run.step_to(time)
            found.append([run.get(name) for name in record])
            derivatives.append(run.derivative(record, by))
    return np.array(found), np.array(derivatives)


def tracked(fmu: Fmu, track: Any) -> tuple[list[float], list[str], Array]:
    """The times (s) of a track, the names of what was measured, and the values, shape (times, variables). Raises
    InvalidValue, UnknownName."""
    if hasattr(track, "to_dict") and hasattr(track, "columns"):
        table = track.reset_index() if track.index.name == "time" else track  # as `Result.to_dataframe` has it
        track = {name: table[name].to_numpy() for name in table.columns}
    needed("track", track, Mapping, 'a dict such as {"time": [...], "x": [...]}')
    measured = [name for name in track if name != "time"]
    if "time" not in track or not measured:
        raise InvalidValue("track needs `time` and something else that was measured then")
    times = numbers("time", track["time"])
    if times.ndim != 1 or not times.size or times[0] < 0.0 or (np.diff(times) <= 0.0).any():
        raise InvalidValue("track: its times (s) must rise, from 0 on, one for each row")
    columns = []
    for name in measured:
        check_real(fmu, "track", name, "record what was measured, such as ['x']")
        values, many = numbers(name, track[name]), len(fmu.names([name]))
        shape = (len(times), many) if name in fmu.arrays else (len(times),)
        if values.shape != shape:
            raise InvalidValue(f"track: {name} has the shape {values.shape}; needed: {shape}, a row for each time")
        columns.append(values)
    return times.tolist(), measured, np.column_stack(columns)


def check_real(fmu: Fmu, what: str, name: str, cure: str) -> None:
    """Raises InvalidValue if this variable or array is not real and so has no derivatives; UnknownName."""
    needed(what, name, str, "the name of a variable")
    if any(fmu.variable(one).type != "Real" for one in fmu.names([name])[:1]):
        raise InvalidValue(f"{what}: {name} is no real number; {cure}")


def numbers(name: str, values: Any) -> Array:
    """A column of a track as an array of finite numbers. Raises InvalidValue."""
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InvalidValue(f"track: {name} needs a list of numbers, not {shown(values)}") from None
    if bad := np.argwhere(~np.isfinite(found)).tolist():
        raise InvalidValue(f"track: {name} is not finite in row {bad[0][0] if bad[0] else 0}; leave such rows out")
    return found


def fit(
    track: Mapping[str, Any],
    by: str | Sequence[str] | Mapping[str, float],
    *,
    fmu: Fmu | None = None,
    values: Values | None = None,
) -> Fit:
    """The parameters `by` with which a run comes closest to the measurements, by least squares.

    `track`: `time` (s, rising, from 0 on) and what was measured then, by name: a dict, a data frame or a result, arrays
    as a whole or by element. `by`: names of parameters, none of which is 0. First guesses: those of `by` if it is a
    dict, else of `values`, else the start values of the FMU. `fmu`: of FMI 3.0; if None, the default cradle. `values`:
    other start values. Raises FmuError where the track does not determine the parameters, InvalidValue, UnknownName,
    and PackageMissing without SciPy.
    """
    optimize = optional("scipy.optimize", "fit")
    if fmu is None:
        with build(fmi=3) as built:
            return fit(track, by, fmu=built, values=values)
    needed("fmu", fmu, Fmu, "an FMU as `nc.build(fmi=3)` makes it")
    if fmu.fmi2:
        raise FmuError(f"{fmu.path} is of FMI 2.0; a fit needs FMI 3.0, as `nc.build(fmi=3)` makes it")
    needed(
        "by", by, str | Sequence | Mapping, "names of parameters, such as ['contact.damping'], or a dict of guesses,"
    )
    given, listed = fmu.settings(values or {}), [by] if isinstance(by, str) else [*by]
    for name in listed:
        check_real(fmu, "by", name, "such as contact.damping")
    guesses = fmu.settings(by) if isinstance(by, Mapping) else {}
    for name in fmu.names(listed) if not guesses else ():
        if name in guesses:
            raise InvalidValue(f"by: {name} is named twice")
        guesses[name] = given.get(name, fmu.built_with(name))
    names, guess = list(guesses), np.array(list(guesses.values()), dtype=float)
    if not names or (guess == 0.0).any():
        raise InvalidValue("by: at least one parameter is needed, each with a guess that is not 0")
    times, measured, filmed = tracked(fmu, track)

    # SciPy varies log(parameter / guess), so that parameters keep their signs.
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
