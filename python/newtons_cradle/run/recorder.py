"""Samples of a run."""

from collections.abc import Callable, Iterable
from ctypes import c_double, c_size_t, c_void_p
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..pulses import Array
from .calls import WARNING
from .model import Model
from .parts import PROMPT, length
from .result import Result

if TYPE_CHECKING:
    from .instance import Run

FIRST = 256  # samples that there is room for; the room is doubled when it is full

#: The dtype of values in results, by the variable's type.
DTYPES = {"Real": "f8", "Integer": "i8", "Enumeration": "i4", "Boolean": "?"}


class Recorder:
    """Reads a fixed set of variables, with one call for each type, into tables that grow."""

    def __init__(self, run: "Run", names: tuple[str, ...]):
        self._run, self._names = run, names
        self._access = run._calls.access(names)
        self._times: list[float] = []
        self._tables: list[Array] = [np.empty((0, call.group.length), call.values.dtype) for call in self._access.calls]
        self._grow(FIRST)

    def _grow(self, rows: int) -> None:
        filled = len(self._times)
        for i, table in enumerate(self._tables):
            self._tables[i] = np.empty((rows, table.shape[1]), table.dtype)
            self._tables[i][:filled] = table[:filled]
        calls = zip(self._access.calls, self._tables, strict=True)
        # The arguments of each getter as C types, which need no conversion, and where its first row is.
        self._reads = [
            (
                call.functions[0],
                call.references,
                c_size_t(call.count),
                c_void_p(),
                table.ctypes.data,
                table.strides[0],
                tuple(map(c_size_t, call.tail)),
            )
            for call, table in calls
        ]
        self._room = rows

    def __len__(self) -> int:
        """The number of samples."""
        return len(self._times)

    def reserve(self, samples: int) -> None:
        """Makes room for this many samples."""
        self._grow(max(samples, len(self._times)))

    def sample(self) -> None:
        """Keeps the values at the run's current time."""
        run, row, component = self._run, len(self._times), self._run._calls.component
        if run._closed:
            run._check_open()
        if row == self._room:
            self._grow(2 * row)
        for function, references, count, place, begin, stride, tail in self._reads:
            place.value = begin + row * stride
            if function(component, references, count, place, *tail) > WARNING:
                run._read(self._names)  # which says why
        if run._parts.means:
            for name, value in run._parts.means.items():
                if name in self._access.where:
                    i, column = self._access.where[name]
                    self._tables[i][row, column] = value
        self._times.append(run.time)

    def steps(self, points: Iterable[float]) -> None:
        """Does `run.step_to` and `sample` for each of these times (s), which rise, without repeated look-ups and
        checks."""
        run, calls, parts = self._run, self._run._calls, self._run._parts
        step, component, tail, longest = calls.step, calls.component, calls.step_tail, parts.longest
        times, now, last, plain, reads = self._times, run.time, perf_counter(), False, self._reads
        early = not run._instance.again  # a step may end before its time
        at, by = c_double(), c_double()
        for time in points:
            h = time - now
            row = len(times)
            if h > longest or row == self._room or not plain:
                run.time = now
                run._step_to(time)
                self.sample()
                now, last, longest, plain = run.time, perf_counter(), parts.longest, not (parts.means or early)
                run._in_step, reads = plain, self._reads  # until the loop ends, `run.time` asks the FMU
                continue
            if now + h != time:
                h = length(now, time)
            at.value, by.value = now, h
            if step(component, at, by, *tail) > WARNING:
                raise run._refusal(f"the step to t = {time} s has failed")
            now = time
            for function, references, count, place, begin, stride, rest in reads:
                place.value = begin + row * stride
                if function(component, references, count, place, *rest) > WARNING:
                    run._read(self._names)  # which says why
            times.append(time)
            before, last = last, perf_counter()
            if last - before > PROMPT:
                parts.slow(h, last - before)
                longest = parts.longest
        run.time = now

    def result(self) -> Result:
        """All samples and pulses so far and, while the run is open, its parameters and inputs."""
        run, count = self._run, len(self._times)
        types, units, dims = run.fmu.columns(self._names)
        samples = np.empty(count, dtype=types)
        samples["time"] = self._times
        for name in self._names:
            i, column = self._access.where[name]
            samples[name] = self._tables[i][:count, column]
        return Result(samples, run.log.text(), units, dims, run.fmu, given(run))


def given(run: "Run") -> Callable[[], dict[str, Any]]:
    """A function that returns the run's present parameters and inputs, {} if it is closed."""
    if run._closed:
        return dict
    access = run._calls.access(run.fmu.given_names)
    run._done(access.read())
    values = [call.values.copy() for call in access.calls]
    return lambda: dict(zip(access.names, access.listed(values), strict=True))


def columns(model: Model, names: Iterable[str]) -> tuple[Any, dict[str, str], dict[str, str]]:
    """The dtype of samples of these variables, their units by name, and by array whether its elements belong to a
    `ball` or a `contact`."""
    names, place = list(names), model.variables.place
    types = [("time", "f8"), *((name, DTYPES[place(name).type]) for name in names)]
    of_array: dict[str, str] = {}  # the unit, which all elements share
    units = {"time": "s"}
    for name in names:
        array = name.partition("[")[0]
        if name == array or array not in of_array:
            of_array[array] = model.unit(name)
        units[name] = units[array] = of_array[array]
    lengths = {array: len(model.arrays[array]) for array in of_array if array in model.arrays}
    kinds = {model.balls - 1: "contact", model.balls: "ball"}
    return np.dtype(types), units, {name: kinds[count] for name, count in lengths.items() if count in kinds}
