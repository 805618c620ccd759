"""Many runs: cases by name, on all cores or on the machines of a dask client, with the results side by side.

found = nc.sweep({"contact.exponent": [1.0, 1.5, 2.0], "contact.deadBand": [0.0, 2.6e-6]}, record=["x"])
found["x"].shape                 # (6, 1001, 5): cases, samples, balls
found.to_xarray()                # with the axes as dimensions
found.errors                     # {number of the case: why it has failed}
"""

import itertools
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import InvalidValue, UnknownName, did_you_mean, needed, optional, plain, shown, whole
from .fmu import A_FUNCTION, Fmu, equal_steps, rising
from .markup import html_table
from .processes import by_processes
from .pulses import Array
from .run import Result
from .run.model import with_unit
from .run.result import equal
from .workers import Case, Measure, Outcome, by_dask, outcome

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

OWN = ("error", "seconds")  # columns of a data frame beside those of cases and results
SHOWN = 10  # cases that a notebook shows


class Sweep(Mapping[str, Array]):
    """The results of all cases: `sweep["x[1]"]` has the shape (cases, samples), `sweep["x"]` (cases, samples, balls),
    and what was measured (cases,). Where a case has failed, NaN. `cases`: dicts; `errors`: by the case's number, from
    0."""

    def __init__(self, cases: list[Case], axes: dict[str, list[Any]] | None, outcomes: list[Outcome]):
        self.cases, self.axes, self.outcomes = cases, axes, outcomes
        self.errors = {i: outcome.error for i, outcome in enumerate(outcomes) if outcome.error}

    @property
    def results(self) -> list[Any]:
        """The result or measured numbers of each case; None where it has failed."""
        return [outcome.found for outcome in self.outcomes]

    @property
    def seconds(self) -> Array:
        """How long each case took, s."""
        return np.array([outcome.seconds for outcome in self.outcomes])

    @property
    def pulses(self) -> list[Array]:
        """The table of pulses of each case; empty where it has failed."""
        none = np.zeros(0, self._first.pulses.dtype) if isinstance(self._first, Result) else np.zeros(0)
        return [each.pulses if isinstance(each, Result) else none for each in self.results]

    @cached_property
    def time(self) -> Array:
        """The time of the samples, s. Raises InvalidValue if no runs were recorded, or if their times differ."""
        runs = {i: found for i, found in enumerate(self.results) if isinstance(found, Result)}
        if not runs:
            raise InvalidValue(f"there are no samples: {self._failure or '`measure` has returned none'}")
        (first, like), *others = runs.items()
        for i, found in others:
            if not np.array_equal(found.time, like.time):
                raise InvalidValue(f"the times of case {i} are others than those of case {first}; `results` has each")
        return like.time

    @property
    def _failure(self) -> str:
        """A message if no case has succeeded, else ""."""
        if not self.outcomes or len(self.errors) < len(self.outcomes):
            return ""
        return f"no case has succeeded; case 0: {self.errors[0]}"

    @cached_property
    def _first(self) -> Any:
        return next((found for found in self.results if found is not None), {})

    def _values(self, name: str) -> list[Array | None]:
        """The values of each case, None where it has none. Raises InvalidValue."""
        try:
            return [None if found is None or name not in found else np.asarray(found[name]) for found in self.results]
        except ValueError as problem:
            raise InvalidValue(f"{name} is no array in each case ({problem}); see `results`") from None

    def __getitem__(self, name: str) -> Array:
        needed("name", name, str, "a variable's, such as 'x[1]',")
        values = self._values(name)
        known = {i: value for i, value in enumerate(values) if value is not None}
        if not known:
            if self._failure:
                raise UnknownName(f"{name}: {self._failure}")
            raise UnknownName(f"{name} was not recorded{did_you_mean(name, self)} (recorded: {', '.join(self)})")
        (first, like), *others = known.items()
        for i, value in others:
            if value.shape != like.shape:
                shapes = f"{like.shape} in case {first} and {value.shape} in case {i}"
                raise InvalidValue(f"{name} has the shapes {shapes}, which make no array; `results` has each alone")
            if columns_of(self.results[i], name) != columns_of(self.results[first], name):
                raise InvalidValue(f"{name} has other elements in case {i} than in case {first}; `results` has each")
        missing = np.full(like.shape, np.nan if like.dtype.kind in "biufc" else None)
        return np.array([missing if value is None else value for value in values])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: object) -> bool:
        """Whether any case has this name."""
        return isinstance(name, str) and any(found is not None and name in found for found in self.results)

    def __len__(self) -> int:
        return len(self._names)

    @cached_property
    def _names(self) -> dict[str, None]:
        """The names that any case has, in order."""
        return dict.fromkeys(name for found in self.results if found is not None for name in found)

    @cached_property
    def _vectors(self) -> dict[str, Any]:
        """The names that any case has, arrays as a whole, each with the first result that has it."""
        having: dict[str, Any] = {}
        for found in self.results:
            for name in found.vectors() if isinstance(found, Result) else found or ():
                having.setdefault(name, found)
        return having

    @cached_property
    def _keys(self) -> dict[str, None]:
        """The names that any case is given by, in order."""
        return dict.fromkeys(name for case in self.cases for name in case)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._names)

    def __eq__(self, other: object) -> bool:
        """Whether cases, results and errors are the same, however long they took."""
        if not isinstance(other, Sweep):
            return NotImplemented
        mine, others = ([each.cases, each.results, each.errors] for each in (self, other))
        return alike(mine, others)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        failed = f", {len(self.errors)} failed" if self.errors else ""
        return f"Sweep({len(self.cases)} cases{failed}; {self.seconds.sum():.3g} s)"

    def _repr_html_(self) -> str:
        rows = [
            [str(i), *(shown(case[name]) if name in case else "" for name in self._keys), self.errors.get(i, "")]
            for i, case in enumerate(self.cases[:SHOWN])
        ]
        return html_table(["case", *self._keys, "error"], *rows, below=repr(self))

    def to_dataframe(self) -> "pd.DataFrame":
        """A row for each case: its values, what was measured or the last samples, `error` and `seconds`; units of
        values in `attrs["units"]`. A result with the name of a value of the cases is called `... (result)`. Raises
        PackageMissing without pandas."""
        pandas = optional("pandas", "data")
        given = {name: labels([case.get(name) for case in self.cases]) for name in self._keys}
        columns: dict[str, Sequence[Any]] = {name: values for name, (values, _) in given.items()}
        sampled = [isinstance(found, Result) for found in self.results]
        for name in self:
            last = [
                value[-1] if of_run and value is not None and value.ndim else value
                for value, of_run in zip(self._values(name), sampled, strict=True)
            ]
            columns[apart(name, [*self._keys, *OWN])] = list(map(plain, last))
        columns[apart("error", self._keys)] = [outcome.error for outcome in self.outcomes]
        columns[apart("seconds", self._keys)] = self.seconds.tolist()
        frame: pd.DataFrame = pandas.DataFrame(columns)
        frame.attrs["units"] = {name: unit for name, (_, unit) in given.items() if unit}
        return frame

    def to_xarray(self) -> "xr.Dataset":
        """A data set with the cases in front: `x(case, time, ball)`, or, where the cases are a product of axes, with
        these as dimensions. A result with the name of a value of the cases is called `... (result)`. Raises
        InvalidValue, PackageMissing without xarray."""
        xarray = optional("xarray", "data")
        front = {"case": len(self.cases)}
        if self.axes is not None:
            front = {name: len(values) for name, values in self.axes.items()}
        of_runs = any(isinstance(found, Result) for found in self.results)
        coordinates: dict[str, Any] = {"time": ("time", self.time, {"units": "s"})} if of_runs else {}
        arrays: dict[str, Any] = {}
        for name, first in self._vectors.items():
            values = self[name]
            if isinstance(first, Result):
                dims, coords, about = first.labels(name)
            else:
                dims, coords, about = [f"{name}_{k}" for k in range(1, values.ndim)], {}, {}
            if same := [dim for dim in dims if dim in self._keys]:
                raise InvalidValue(f"cases: {same[0]} is also a dimension of the results; call it by another name")
            shaped = values.reshape([*front.values(), *values.shape[1:]])
            called = apart(name, [*self._keys, "error", "case"])
            arrays[called] = xarray.DataArray(shaped, coords=coords, dims=[*front, *dims], attrs=about)
        errors = np.array([outcome.error for outcome in self.outcomes]).reshape([*front.values()])
        arrays[apart("error", self._keys)] = (list(front), errors, {})
        for name in self._keys:
            along, unit = labels([case.get(name) for case in self.cases] if self.axes is None else self.axes[name])
            if not any(isinstance(value, list | tuple | np.ndarray) for value in along):
                dim = "case" if self.axes is None else name
                coordinates[name] = ([dim], along, {"units": unit} if unit else {})
        found: xr.Dataset = xarray.Dataset(arrays, coords=coordinates)
        return found


def columns_of(found: Any, name: str) -> list[str]:
    """The recorded variables that a name stands for, if this is the result of a run."""
    return found.columns(name) if isinstance(found, Result) else []


def apart(name: str, others: Iterable[str]) -> str:
    """The name of a result, marked as one if these have it, too."""
    return f"{name} (result)" if name in others else name


def labels(values: Iterable[Any]) -> tuple[list[Any], str]:
    """Values without their unit, and the unit, if they share one; else values with their units as text, and "". NaN for
    None."""
    pairs = [with_unit(np.nan if value is None else value) for value in values]
    units = {unit or "" for value, unit in pairs if value is not np.nan}
    if len(units) <= 1:
        return [plain(value) for value, _ in pairs], "".join(units)
    return [value if unit is None else f"{value} {unit}" for value, unit in pairs], ""


def alike(one: Any, other: Any) -> bool:
    """Equality of nested values that may contain arrays; NaN equals NaN."""
    if isinstance(one, Mapping) and isinstance(other, Mapping) and not isinstance(one, Result):
        return one.keys() == other.keys() and all(alike(one[name], other[name]) for name in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return equal(np.asarray(one), np.asarray(other))
    return bool(one == other or (one != one and other != other))  # NaN is alike


def sweep(
    cases: "Mapping[str, Sequence[Any]] | Iterable[Mapping[str, Any]] | pd.DataFrame",
    measure: Measure | None = None,
    *,
    fmu: Fmu | str | Path | None = None,
    stop: float | None = None,
    step: float | None = None,
    times: Sequence[float] | None = None,
    record: Sequence[str] | None = None,
    workers: int | None = None,
    client: Any = None,
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Runs all cases, on several processes, each with an FMU of its own; a case that fails does not stop the others.

    `cases`: a dict of axes, all of whose combinations are run; a list of dicts; or a data frame with a row for each
    case. A case has start values by name; `simulate` takes them, with `stop` (10 s if None), `step` (0.01 s if None),
    `times` and `record`. Or `measure(fmu, case)` runs the FMU itself, with cases of any content, and returns a result
    or a dict of numbers. `workers`: number of processes, None for one per core; with 1 everything runs in this process.
    `client`: a dask client, whose workers run the cases and need this package. `progress(fraction)`: such as
    `nc.Progress("Sweep")`. Raises InvalidValue, FileMissing, FmuError.
    """
    axes, listed = listed_cases(cases)
    if workers is not None:
        whole("workers", workers, 1, 1000)
    needed("measure", measure, Callable | None, "a function `measure(fmu, case)`")
    needed("progress", progress, Callable | None, A_FUNCTION)
    own = {"stop": stop, "step": step, "times": times, "record": record}
    if measure is not None and (names := [name for name, value in own.items() if value is not None]):
        raise InvalidValue(f"{', '.join(names)}: they act without `measure` only, which runs the FMU itself")
    if client is not None and not hasattr(client, "upload_file"):
        raise InvalidValue(f"client: a client of dask is needed, not {shown(client)}")
    opened = fmu if isinstance(fmu, Fmu) else Fmu(fmu)
    try:
        opened.check_open()
        # Raises here what would be wrong in all cases.
        steps = equal_steps(10.0 if stop is None else stop, 0.01 if step is None else step)
        points = [0.0, *(steps if times is None else rising(times))]
        run = measure or partial(simulated, times=points, record=opened.to_record(record))
        if not listed:
            return Sweep([], axes, [])
        if client is not None:
            outcomes = by_dask(client, opened.path, run, listed)
        elif (count := min(workers or os.cpu_count() or 1, len(listed))) == 1:
            outcomes = ((i, outcome(opened, run, dict(case))) for i, case in enumerate(listed))
        else:
            outcomes = by_processes(count, opened.path, run, listed)
        found: dict[int, Outcome] = {}
        with closing(outcomes):
            for i, one in outcomes:
                found[i] = one
                if measure is None and isinstance(one.found, Result):
                    one.found.model = opened  # results from other processes come without it
                if progress is not None:
                    progress(len(found) / len(listed))
        return Sweep(listed, axes, [found[i] for i in range(len(listed))])
    finally:
        if opened is not fmu:
            opened.close()


def listed_cases(cases: Any) -> tuple[dict[str, list[Any]] | None, list[Case]]:
    """The axes, None if the cases are not a product of axes; and the cases. Raises InvalidValue."""
    if hasattr(cases, "to_dict") and hasattr(cases, "columns"):
        rows = cases.to_dict("records")
        cases = [{name: value for name, value in row.items() if given(value)} for row in rows]
    if isinstance(cases, Mapping):
        lists = {name: values_of(name, cases[name]) for name in cases}
        return lists, [dict(zip(lists, values, strict=True)) for values in itertools.product(*lists.values())]
    needed("cases", cases, Iterable, "a dict of axes, a list of dicts, or a data frame")
    rows = list(cases)
    for row in rows:
        needed("cases", row, Mapping, 'for each case a dict such as {"ball.mass": 0.5}')
    return None, [dict(row) for row in rows]


def given(value: Any) -> bool:
    """Whether a cell of a data frame is not empty."""
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def values_of(name: str, axis: Any) -> list[Any]:
    """The values of an axis, each with its unit: `([0.0, 2.6], "um")`. Raises InvalidValue."""
    values, unit = with_unit(axis)
    if isinstance(values, str):  # an axis of two names, no unit
        values, unit = axis, None
    try:
        if isinstance(values, str | Mapping):
            raise TypeError
        return list(values) if unit is None else [(value, unit) for value in values]
    except TypeError:
        raise InvalidValue(f"cases: {name} needs a list of values, not {shown(axis)}") from None


def simulated(fmu: Fmu, case: Case, times: Sequence[float], record: Sequence[str]) -> Result:
    """Runs a case of start values."""
    return fmu.simulate(case, times=times, record=record)
