"""Many runs: cases by name, on all cores or on the machines of a dask client, with the results side by side.

found = nc.sweep({"contact.exponent": [1.0, 1.5, 2.0], "contact.deadBand": [0.0, 2.6e-6]}, record=["x"])
found["x"].shape                 # (6, 1001, 5): cases, samples, balls
found.to_xarray()                # with the axes as dimensions
found.errors                     # {number of the case: why it has failed}
"""

import itertools
import os
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import InvalidValue, UnknownName, did_you_mean, needed, optional, whole
from .fmu import Fmu
from .pulses import Array
from .run import Result

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Case = dict[str, Any]
Measure = Callable[[Fmu, Case], Result | Mapping[str, Any]]

PARCELS = 8  # for each worker, so that all of them end at about the same time
MOST = 64  # cases in a parcel: progress is told after each


@dataclass(frozen=True)
class Outcome:
    """What has come of a case: a result, or what was measured, or an error. `seconds` that it took."""

    found: Result | dict[str, Any] | None
    error: str
    seconds: float


class Sweep(Mapping[str, Array]):
    """The results of all cases: `sweep["x[1]"]` has the shape (cases, samples), `sweep["x"]` (cases, samples, balls),
    and what was measured (cases,). Where a case has failed, NaN. `cases`: dicts; `errors`: by the case's number, from
    0."""

    def __init__(self, cases: list[Case], axes: dict[str, list[Any]] | None, outcomes: list[Outcome]):
        self.cases, self.axes, self.outcomes = cases, axes, outcomes
        self.errors = {i: outcome.error for i, outcome in enumerate(outcomes) if outcome.error}

    @property
    def results(self) -> list[Any]:
        """Each case's result, or what was measured; None where it has failed."""
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
        """The time of the samples, s. Raises InvalidValue where no runs were recorded."""
        if not isinstance(self._first, Result):
            raise InvalidValue("there are no samples: no case has succeeded, or `measure` has returned none")
        return self._first.time

    @cached_property
    def _first(self) -> Any:
        return next((found for found in self.results if found is not None), {})

    def __getitem__(self, name: str) -> Array:
        needed("name", name, str, "a variable's, such as 'x[1]',")
        if name not in self._first:
            raise UnknownName(f"{name} was not recorded{did_you_mean(name, self)} (recorded: {', '.join(self)})")
        like = np.asarray(self._first[name])
        missing = np.full(like.shape, np.nan) if like.dtype.kind in "biuf" else np.full(like.shape, None)
        columns = [missing if found is None else found[name] for found in self.results]
        return np.array(columns) if self.errors else np.array(columns, dtype=like.dtype)

    def __iter__(self) -> Iterator[str]:
        return iter(self._first)

    def __len__(self) -> int:
        return len(self._first)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._first)

    def __repr__(self) -> str:
        failed = f", {len(self.errors)} failed" if self.errors else ""
        return f"Sweep({len(self.cases)} cases{failed}; {self.seconds.sum():.3g} s)"

    def to_dataframe(self) -> "pd.DataFrame":
        """A row for each case: its values, what was measured or the last samples, `error` and `seconds`. Raises
        PackageMissing without pandas."""
        frame = optional("pandas", "data").DataFrame(self.cases)
        for name in self:
            values = self[name]
            frame[name] = values if values.ndim == 1 else values[:, -1]
        return frame.assign(error=[outcome.error for outcome in self.outcomes], seconds=self.seconds)

    def to_xarray(self) -> "xr.Dataset":
        """A data set with the cases in front: `x(case, time, ball)`, or, where the cases are a product of axes, with
        these as dimensions. Raises PackageMissing without xarray."""
        xarray = optional("xarray", "data")
        kind = self._first
        if isinstance(kind, Result):
            like = kind.to_xarray()
            arrays = {name: (("case", *one.dims), self[str(name)], one.attrs) for name, one in like.items()}
            found: xr.Dataset = xarray.Dataset(arrays, coords=like.coords)
        else:
            found = xarray.Dataset({name: ("case", self[name]) for name in self})
        found["error"] = ("case", [outcome.error for outcome in self.outcomes])
        if self.axes is None:
            names = dict.fromkeys(name for case in self.cases for name in case if np.ndim(case[name]) == 0)
            return found.assign_coords({name: ("case", [case.get(name) for case in self.cases]) for name in names})
        index = optional("pandas", "data").MultiIndex.from_product(self.axes.values(), names=list(self.axes))
        of_cases = xarray.Coordinates.from_pandas_multiindex(index, "case")
        return found.assign_coords(of_cases).unstack("case").transpose(*self.axes, ...)


def sweep(
    cases: "Mapping[str, Sequence[Any]] | Iterable[Mapping[str, Any]] | pd.DataFrame",
    measure: Measure | None = None,
    *,
    fmu: Fmu | str | Path | None = None,
    stop: float = 10.0,
    step: float = 0.01,
    times: Sequence[float] | None = None,
    record: Sequence[str] | None = None,
    workers: int | None = None,
    client: Any = None,
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Runs all cases, each with an FMU of one's own in each process; a case that fails does not stop the others.

    `cases`: a dict of axes, whose product they are, a list of dicts, or a data frame with a row for each. A case has
    start values by name, as `simulate` takes them with `stop`, `step`, `times` and `record`; or whatever
    `measure(fmu, case)` understands, which returns a result, or a dict of numbers. `workers`: processes, as many as
    there are cores if None; with 1 everything runs in this one. `client`: of dask, whose workers run the cases; they
    need this package. `progress(fraction)`: such as `nc.Progress("Sweep")`. Raises InvalidValue, FileMissing, FmuError.
    """
    axes, listed = listed_cases(cases)
    if workers is not None:
        whole("workers", workers, 1, 1000)
    for what, function in (("measure", measure), ("progress", progress)):
        needed(what, function, Callable | None, "a function")
    options: dict[str, Any] = {"stop": stop, "step": step, "times": None if times is None else list(times)}
    run = measure or partial(simulated, options=options | {"record": None if record is None else list(record)})
    opened = fmu if isinstance(fmu, Fmu) else Fmu(fmu)  # a file that is no FMU is told here
    try:
        if not listed:
            return Sweep([], axes, [])
        if client is not None:
            outcomes = by_dask(client, opened.path, run, listed)
        elif (count := min(workers or os.cpu_count() or 1, len(listed))) == 1:
            outcomes = ((i, outcome(opened, run, case)) for i, case in enumerate(listed))
        else:
            outcomes = by_processes(count, opened.path, run, listed)
        found: dict[int, Outcome] = {}
        for i, one in outcomes:
            found[i] = one
            if progress is not None:
                progress(len(found) / len(listed))
        return Sweep(listed, axes, [found[i] for i in range(len(listed))])
    finally:
        if opened is not fmu:
            opened.close()


def listed_cases(cases: Any) -> tuple[dict[str, list[Any]] | None, list[Case]]:
    """The axes, if these are cases of a product, and the cases. Raises InvalidValue."""
    if hasattr(cases, "to_dict") and hasattr(cases, "columns"):
        cases = cases.to_dict("records")
    if isinstance(cases, Mapping):
        axes = {name: cases[name] for name in cases}
        if wrong := [name for name, values in axes.items() if isinstance(values, str) or np.ndim(values) == 0]:
            raise InvalidValue(f"cases: {wrong[0]} needs a list of values, not {axes[wrong[0]]!r}")
        lists = {name: list(values) for name, values in axes.items()}
        return lists, [dict(zip(lists, values, strict=True)) for values in itertools.product(*lists.values())]
    needed("cases", cases, Iterable, "a dict of axes, a list of dicts, or a data frame")
    rows = list(cases)
    for row in rows:
        needed("cases", row, Mapping, 'for each case a dict such as {"ball.mass": 0.5}')
    return None, [dict(row) for row in rows]


def simulated(fmu: Fmu, case: Case, options: Mapping[str, Any]) -> Result:
    """Runs a case of start values."""
    return fmu.simulate(case, **options)


def outcome(fmu: Fmu, run: Measure, case: Case) -> Outcome:
    """What comes of a case."""
    begin = clock.perf_counter()
    try:
        found = run(fmu, case)
        kept = found if isinstance(found, Result) else dict(found)
        return Outcome(kept, "", clock.perf_counter() - begin)
    except Exception as problem:  # whatever it is: one case does not stop the others
        return Outcome(None, f"{type(problem).__name__}: {problem}", clock.perf_counter() - begin)


_opened: dict[Path, Fmu] = {}  # of this worker


def parcel(path: Path, run: Measure, cases: list[tuple[int, Case]]) -> list[tuple[int, Outcome]]:
    """The outcomes of some cases, in a worker, by their numbers."""
    if not path.is_absolute():  # sent to a worker of dask
        path = Path(optional("distributed", "study").get_worker().local_directory, path).absolute()
    if path not in _opened:
        _opened[path] = Fmu(path)
    return [(i, outcome(_opened[path], run, case)) for i, case in cases]


def parcels(cases: list[Case], workers: int) -> list[list[tuple[int, Case]]]:
    """The cases with their numbers, in parcels."""
    size = max(1, min(MOST, len(cases) // (PARCELS * workers)))
    numbered = list(enumerate(cases))
    return [numbered[i : i + size] for i in range(0, len(numbered), size)]


def by_processes(workers: int, path: Path, run: Measure, cases: list[Case]) -> Iterator[tuple[int, Outcome]]:
    """The outcomes, as they come from processes of this machine."""
    lost: list[tuple[int, Case]] = []
    pool = ProcessPoolExecutor(workers)
    try:
        jobs: dict[Future[Any], Any] = {
            pool.submit(parcel, path.absolute(), run, one): one for one in parcels(cases, workers)
        }
        for job in as_completed(jobs):
            try:
                yield from job.result()
            except BrokenExecutor:
                lost += jobs[job]
    finally:
        pool.shutdown(cancel_futures=True)
    for numbered in lost:  # a process has died, and the others with it: which case was it?
        with ProcessPoolExecutor(1) as alone:
            try:
                yield from alone.submit(parcel, path.absolute(), run, [numbered]).result()
            except BrokenExecutor:
                yield numbered[0], Outcome(None, "its process has died", 0.0)


def by_dask(client: Any, path: Path, run: Measure, cases: list[Case]) -> Iterator[tuple[int, Outcome]]:
    """The outcomes, as they come from the workers of a client. The FMU is sent to them."""
    distributed = optional("distributed", "study")
    client.upload_file(str(path), load=False)
    sent = parcels(cases, max(1, len(client.ncores())))
    jobs = client.map(partial(parcel, Path(path.name), run), sent, pure=False)
    of_key = {job.key: one for job, one in zip(jobs, sent, strict=True)}
    for job, result in distributed.as_completed(jobs, with_results=True, raise_errors=False):
        if job.status == "error":  # not the case's own failure: its workers died
            yield from ((i, Outcome(None, f"lost: {result[1]}", 0.0)) for i, _ in of_key[job.key])
        else:
            yield from result
