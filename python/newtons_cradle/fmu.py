"""Open an FMU, start instances of it, step them as finely as wanted and keep their pulse log.

FMPy's `simulate_fmu` is the right tool for an ordinary run. This module drives FMPy's slave directly
where more is wanted: a table of all pulses, nanosecond steps at an impact, a hand on each step.
"""

import itertools
import math
import shutil
import threading
from collections.abc import Callable, Iterable, Mapping
from ctypes import byref
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy

from .pulses import pulse_table

LOOKS = 10_000  # by which an onset must be in sight
NEVER = 1e30  # s, what `t_next` says when no impact lies ahead
DTYPES = {"Real": "f8", "Integer": "i4", "Enumeration": "i4", "Boolean": "?"}  # FMI type to NumPy's


class FmuError(RuntimeError):
    """A call the FMU refused; the message holds what the FMU logged about it."""


@dataclass(frozen=True)
class LogLine:
    """One message of an FMU: FMI status (0 OK, 1 warning, 3 error, 4 fatal), category and text."""

    status: int
    category: str
    text: str


class _LogRouter:
    """Hands each log message to the run it belongs to.

    FMPy's proxy, which fills in the C-style message, keeps one logger for the whole process: the last
    one registered gets the messages of every instance. So all runs share this one and are told apart
    by the componentEnvironment that the FMU hands back. (A `simulate_fmu(..., logger=...)` started
    while a run is open takes over the proxy: the run's later messages go to that logger.)
    """

    def __init__(self):
        self._logs: dict[int, list[LogLine]] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._logger = fmi2CallbackLoggerTYPE(self._receive)

    def _receive(self, environment, _instance, status, category, message):
        log = self._logs.get(environment)
        if log is not None:
            texts = ((text or b"").decode("utf-8", "replace") for text in (category, message))
            log.append(LogLine(status, *texts))

    def callbacks(self, log: list[LogLine]) -> fmi2CallbackFunctions:
        """Callbacks of a new instance, whose messages are appended to `log`."""
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = self._logger
        with self._lock:
            number = next(self._numbers)
            addLoggerProxy(byref(callbacks))
        callbacks.componentEnvironment = number
        self._logs[number] = log
        return callbacks

    def forget(self, callbacks: fmi2CallbackFunctions) -> None:
        self._logs.pop(callbacks.componentEnvironment, None)


_router = _LogRouter()


@dataclass
class Result:
    """Samples of a run and its pulses.

    `samples`: structured array with `time` (s) and one field per recorded variable;
    `pulses`: structured array of dtype `PULSE`, finished pulses only, by onset.
    `result["x[1]"]` is short for `result.samples["x[1]"]`.
    """

    samples: np.ndarray
    pulses: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        return self.samples[name]

    def stack(self, name: str) -> np.ndarray:
        """All elements of a vector, `stack("x")` for x[1], x[2], ...: shape (samples, elements)."""
        columns = [c for c in self.samples.dtype.names if c.startswith(f"{name}[")]
        return np.column_stack([self.samples[c] for c in columns])


@dataclass(frozen=True)
class Saved:
    """A saved state: the time it was saved at (s), and the bytes."""

    time: float
    data: bytes


class Fmu:
    """An FMU, unpacked: start as many runs of it as you like, side by side if need be.

    `folder`: where to unpack it, a temporary folder if None; `close` removes it.
    """

    def __init__(self, path: str | Path, folder: str | Path | None = None):
        self.path = Path(path)
        if not self.path.exists():
            raise FileNotFoundError(f"{self.path}: build it with `cargo pack build --release`")
        self.description = read_model_description(str(self.path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.folder = extract(str(self.path), unzipdir=folder and str(folder))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self) -> None:
        """Removes the unpacked files."""
        shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def outputs(self) -> list[str]:
        """Names of all outputs, in the description's order."""
        return [v.name for v in self.description.modelVariables if v.causality == "output"]

    @property
    def balls(self) -> int:
        """Number of balls n."""
        return sum(name.startswith("x[") for name in self.variables)

    def items(self, name: str) -> dict[str, int]:
        """The items of an enumeration and their integers: `items("contact.model")["hertz"]` is 2."""
        return {item.name: int(item.value) for item in self.variables[name].declaredType.items}

    def number(self, name: str, value: float | int | bool | str) -> float | int | bool:
        """A value as a variable of this name takes it; an item of an enumeration may be named. Raises FmuError."""
        kind = self.variables[name].type
        try:
            if kind == "Enumeration" and isinstance(value, str):
                return self.items(name)[value]
            return float(value) if kind == "Real" else int(value)
        except KeyError:
            allowed = ", ".join(self.items(name))
            raise FmuError(f"{name} = {value} is refused; allowed: {allowed}") from None
        except ValueError:
            raise FmuError(f"{name} = {value} is not a number") from None

    def start(self, values: Mapping[str, float] | None = None, **options) -> "Run":
        """A run at its start time; see `Run`. Use it in a `with` block, which frees the instance."""
        return Run(self, values, **options)

    def simulate(
        self,
        values: Mapping[str, float] | None = None,
        *,
        stop: float = 10.0,
        step: float = 0.01,
        times: Iterable[float] | None = None,
        record: Iterable[str] | None = None,
        inputs: Callable[[float], Mapping[str, float]] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Runs from 0 to `stop` (s) in equal steps of about `step` (s) and records at each.

        `times`: the communication points (s, rising, from 0 on) instead of equal steps. `record`:
        variable names, all outputs and E_residual if None. `inputs(t)`: inputs for the step that begins
        at t. `progress(fraction)`: called up to 200 times. Raises FmuError.
        """
        if times is None:
            steps = max(1, round(stop / step))
            times = [stop * i / steps for i in range(steps + 1)]
        start, *points = times
        if start != 0.0 or np.any(np.diff([start, *points]) <= 0.0):
            raise ValueError("the communication points must begin at 0 and rise")
        with self.start(values) as run:
            recorder = run.recorder(record if record is not None else [*self.outputs, "E_residual"])
            recorder.sample()
            for i, time in enumerate(points, start=1):
                if inputs is not None:
                    run.set(inputs(run.time))
                run.step_to(time)
                recorder.sample()
                if progress is not None and (i * 200 // len(points) != (i - 1) * 200 // len(points)):
                    progress(i / len(points))
            return recorder.result()


class Run:
    """One instance, initialised and ready to step. `values`: start values by variable name.

    With `initialize=False` it is only instantiated, and `initialize()` is left to the caller.
    """

    def __init__(self, fmu: Fmu, values: Mapping[str, float] | None = None, *, initialize: bool = True):
        self.fmu, self.time = fmu, 0.0
        self.log: list[LogLine] = []
        self._callbacks = _router.callbacks(self.log)
        self._alive = False
        self.slave = FMU2Slave(
            guid=fmu.description.guid,
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            unzipDirectory=fmu.folder,
            instanceName="cradle",
        )
        try:
            self._call(self.slave.instantiate, callbacks=self._callbacks)
            self._alive = True
            self._call(self.slave.setDebugLogging, True, ["logEvents"])
            self.set(values or {})
            if initialize:
                self.initialize()
        except BaseException:
            self.close()
            raise

    def initialize(self, start_time: float = 0.0) -> None:
        """Brings an instance that was only instantiated to its start time (s). Raises FmuError."""
        self._call(self.slave.setupExperiment, startTime=start_time)
        self._call(self.slave.enterInitializationMode)
        self._call(self.slave.exitInitializationMode)
        self.time = start_time

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self) -> None:
        """Frees the instance; the log and the pulses stay readable."""
        if self._alive:
            self._alive = False
            self.slave.freeInstance()
        _router.forget(self._callbacks)

    def _call(self, function, *args, **kwargs):
        before = len(self.log)
        try:
            return function(*args, **kwargs)
        except Exception as error:
            said = "; ".join(line.text for line in self.log[before:] if line.status >= 1)
            raise FmuError(f"{error} {said}".strip()) from error

    @property
    def pulses(self) -> np.ndarray:
        """All finished pulses so far, by onset: array of dtype `PULSE`."""
        return pulse_table(line.text for line in self.log if line.category == "logEvents")

    def set(self, values: Mapping[str, float | str]) -> None:
        """Sets variables by name, all of one type in one call; see `Fmu.number`. Raises KeyError or FmuError."""
        for kind, names in self._by_type(values).items():
            setter = getattr(self.slave, "setInteger" if kind == "Enumeration" else f"set{kind}")
            references = [self.fmu.variables[name].valueReference for name in names]
            self._call(setter, references, [self.fmu.number(name, values[name]) for name in names])

    def get(self, name: str) -> float | int | bool:
        """The value of one variable. Raises KeyError or FmuError."""
        return self.recorder([name]).row()[0]

    def step(self, h: float) -> None:
        """One communication step of `h` seconds. Raises FmuError."""
        self._call(self.slave.doStep, self.time, h)
        self.time += h

    def step_to(self, t: float) -> None:
        """One communication step that ends at `t` (s) exactly, not an ulp beside it."""
        h = t - self.time
        while self.time + h < t:
            h = math.nextafter(h, math.inf)
        while self.time + h > t:
            h = math.nextafter(h, -math.inf)
        self.step(h)
        self.time = t

    def step_to_onset(self, before: float = 0.0) -> float:
        """Steps to the next onset, or to `before` seconds ahead of it; returns the time of the onset.

        Where a contact phase is so long that the FMU does not see its end, that takes several steps. Raises FmuError when
        no contact will close any more, or none is in sight after many steps.
        """
        for _ in range(LOOKS):
            if self.get("t_next_isOnset"):
                break
            # A look goes on as soon as time has moved.
            self.step_to(max(self.get("t_next") - before, math.nextafter(self.time, math.inf)))
        else:
            raise FmuError(f"no contact closes within {LOOKS} looks ahead, up to t = {self.get('t_next')} s")
        onset = self.get("t_next")
        if onset >= NEVER:
            raise FmuError(f"no contact closes any more after t = {self.time} s")
        if onset - before > self.time:
            self.step_to(onset - before)
        return onset

    def zoom(
        self, span: float, step: float, record: Iterable[str], before: float = 0.0
    ) -> tuple[float, Result]:
        """The micro view of the next impact: records every `step` (s) from `before` (s) ahead of the
        onset until `span` (s) after it. Returns the time of the onset and the samples."""
        onset = self.step_to_onset(before)
        recorder = self.recorder(record)
        recorder.sample()
        first = self.time
        for i in range(1, round((onset + span - first) / step) + 1):
            self.step_to(first + i * step)
            recorder.sample()
        return onset, recorder.result()

    def save(self) -> "Saved":
        """The state of the instance, from which any run of the same FMU can go on, also in another process."""
        state = self._call(self.slave.getFMUstate)
        data = self._call(self.slave.serializeFMUstate, state)
        self._call(self.slave.freeFMUstate, state)
        return Saved(self.time, data)

    def load(self, saved: "Saved") -> None:
        """Goes on from a saved state, with the same bits; the log is kept. Raises FmuError."""
        state = self._call(self.slave.deSerializeFMUstate, saved.data)
        self._call(self.slave.setFMUstate, state)
        self._call(self.slave.freeFMUstate, state)
        self.time = saved.time

    def recorder(self, names: Iterable[str]) -> "Recorder":
        """Records the named variables of this run."""
        return Recorder(self, list(names))

    def _by_type(self, names: Iterable[str]) -> dict[str, list[str]]:
        groups: dict[str, list[str]] = {}
        for name in names:
            if name not in self.fmu.variables:
                raise KeyError(f"{self.fmu.path.name} has no variable {name!r}")
            groups.setdefault(self.fmu.variables[name].type, []).append(name)
        return groups


class Recorder:
    """Reads a fixed set of variables with one call per type."""

    def __init__(self, run: Run, names: list[str]):
        self._run, self._names, self._rows = run, names, []
        self._groups = []
        for kind, members in run._by_type(names).items():
            getter = getattr(run.slave, "getInteger" if kind == "Enumeration" else f"get{kind}")
            references = [run.fmu.variables[name].valueReference for name in members]
            self._groups.append((getter, references, [names.index(name) for name in members]))
        kinds = [(name, DTYPES[run.fmu.variables[name].type]) for name in names]
        self._dtype = np.dtype([("time", "f8"), *kinds])

    def row(self) -> list:
        """The values now, in the order of the names."""
        row = [None] * len(self._names)
        for getter, references, places in self._groups:
            for place, value in zip(places, self._run._call(getter, references), strict=True):
                row[place] = value
        return row

    def sample(self) -> None:
        """Keeps the values at the run's current time."""
        self._rows.append((self._run.time, *self.row()))

    def result(self) -> Result:
        """All samples so far and the run's pulses so far."""
        return Result(np.array(self._rows, dtype=self._dtype), self._run.pulses)
