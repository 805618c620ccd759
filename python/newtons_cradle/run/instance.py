"""A running instance of an FMU, stepped as finely as you like."""

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import FmuError, InvalidValue, needed, number, warn
from ..pulses import Array, pulse_table
from .model import GIVEN, Model, Value, Values, meant
from .result import Result
from .slaves import Log, instance

LOOKS = 10_000  # by which an onset must be in sight
NEVER = 1e30  # s, what `t_next` says when no impact lies ahead
DTYPES = {"Real": "f8", "Integer": "i8", "Enumeration": "i4", "Boolean": "?"}  # FMI type to NumPy's


@dataclass(frozen=True)
class Saved:
    """A saved state: the time it was saved at (s), and the bytes."""

    time: float
    data: bytes = field(repr=False)


class Run(AbstractContextManager["Run"]):
    """One instance, initialised and ready to step. `values`: start values by variable name, as `set` takes them.

    `run["F_ext[1]"] = 0.2` sets a variable; `run["v[1]"]` is the current value of one. With `initialize=False` the
    instance is only instantiated, and the caller must call `initialize()`. With `exchange=True` it is one for model
    exchange, which the caller integrates through `slave`.
    """

    def __init__(self, fmu: Model, values: Values | None = None, *, initialize: bool = True, **options: bool):
        self.fmu, self.time = fmu, 0.0
        self.log = Log()
        self._closed = self._initialized = False
        self._meant = True
        self.slave = instance(fmu, options.pop("exchange", False))
        try:
            self._call(self.slave.create, self.log, **options)
            self.set({} if values is None else values)
            if initialize:
                self.initialize()
        except BaseException:
            self.close()
            raise

    def initialize(self, start_time: float = 0.0) -> None:
        """Initialises an instance that was only instantiated, at its start time (s). Raises FmuError."""
        self._call(self.slave.enterInitializationMode, startTime=start_time)
        self._call(self.slave.exitInitializationMode)
        self.time, self._initialized = start_time, True
        for line in self.log:
            if line.category == "logStatusWarning" and not self._meant:
                warn(line.text)

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"at {self.time:.9g} s"
        return f"Run({self.fmu.path.name}, {state}; {len(self.pulses)} pulses)"

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Frees the instance; the log and the pulses stay readable."""
        if self.slave.component and not self._closed:
            self.slave.freeInstance()
        self._closed = True

    def _call(self, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        if self._closed:
            raise FmuError("the run is closed: its `with` block has ended, or `close` was called")
        before = len(self.log)
        try:
            return function(*args, **kwargs)
        except Exception as error:
            # The FMU's message without the function's name; otherwise FMPy's.
            said = [line.text.partition(": ")[2] for line in self.log[before:] if line.status >= 1]
            raise FmuError("; ".join(said) or str(error)) from error

    @property
    def pulses(self) -> Array:
        """All finished pulses so far, by onset: array of dtype `PULSE`."""
        return pulse_table(line.text for line in self.log if line.category == "logEvents")

    def set(self, values: Values) -> None:
        """Sets parameters and inputs by name, with one call for each type.

        An array takes a sequence, `{"x_start": [-0.1, 0, 0, 0, 0]}`; an enumeration takes the name of an item. Raises
        UnknownName, FmuError.
        """
        numbers = self.fmu.settings(values)
        self._meant = self._meant and meant(values)
        for kind, names, references in self._by_type(numbers):
            self._call(self.slave.write, kind, references, [numbers[name] for name in names])

    def get(self, name: str) -> float | int | bool:
        """The value of one variable. Raises UnknownName or FmuError."""
        variable = self.fmu.variable(name)
        value: float | int | bool = self._call(self.slave.read, variable.type, [variable.valueReference])[0]
        return value

    def __setitem__(self, name: str, value: Value | Sequence[Value] | Array) -> None:
        self.set({name: value})

    def __getitem__(self, name: str) -> Any:
        """The value of a variable; for an array, the values of all elements, shape (elements,)."""
        values = self.recorder([name]).row()
        return np.array(values) if name in self.fmu.arrays else values[0]

    def step(self, h: float) -> None:
        """One communication step of `h` seconds. Raises InvalidValue, FmuError."""
        number("h", h, "s", positive=True)
        self._step(h, self.time + h)

    def _step(self, h: float, end: float) -> None:
        """One communication step of `h` seconds to `end` (s), or to where the FMU returns early."""
        if not self._initialized and not self._closed:
            raise FmuError("a step is refused before the run is initialized; call `initialize` first")
        # FMI 3.0: whether an event is due, the run is to end, or the step has ended early, and when it has ended.
        told = self._call(self.slave.doStep, self.time, h)
        self.time = told[3] if told and told[2] else end

    def step_to(self, t: float) -> None:
        """One communication step that ends exactly at `t` (s), or earlier if the FMU may return early and does. Raises
        InvalidValue, FmuError."""
        if not number("t", t, "s") > self.time:
            raise InvalidValue(f"t = {t} s is refused; allowed: later than now, {self.time} s")
        h = t - self.time
        while self.time + h < t:
            h = math.nextafter(h, math.inf)
        while self.time + h > t:
            h = math.nextafter(h, -math.inf)
        self._step(h, t)

    def step_to_onset(self, before: float = 0.0) -> float:
        """Steps to the next onset, or to `before` seconds ahead of it (not negative); returns the time of the onset.

        If a contact phase is so long that the FMU does not see its end, this takes several steps. Raises FmuError if
        no contact will close any more, or if none is in sight after many steps; InvalidValue.
        """
        number("before", before, "s", least=0.0)
        for _ in range(LOOKS):
            onset = float(self.get("t_next"))
            if onset >= NEVER:
                raise FmuError(f"no contact closes any more after t = {self.time} s")
            if self._is_onset(onset):
                if onset - before > self.time:
                    self.step_to(onset - before)
                return onset
            # A look continues once time has moved.
            self.step_to(max(onset - before, math.nextafter(self.time, math.inf)))
        raise FmuError(f"no contact closes within {LOOKS} looks ahead, up to t = {onset} s")

    def _is_onset(self, ahead: float) -> bool:
        """Whether `t_next` is an onset. FMI 3.0 has no variable for it, but a step to it shows it."""
        if "t_next_isOnset" in self.fmu.variables:
            return bool(self.get("t_next_isOnset"))
        here, lines, before = self.save(), len(self.log), self["pulses"]
        try:
            self.step_to(ahead)
            return bool((self["pulses"] > before).any())
        finally:
            self.load(here)
            del self.log[lines:]

    def zoom(self, span: float, step: float, record: Iterable[str], before: float = 0.0) -> tuple[float, Result]:
        """The micro view of the next impact: records every `step` (s) from `before` (s) ahead of the onset until `span`
        (s) after it. Returns the time of the onset and the samples. Raises InvalidValue, FmuError."""
        number("step", step, "s", positive=True, most=number("span", span, "s", positive=True))
        onset = self.step_to_onset(before)
        recorder = self.recorder(record)
        recorder.sample()
        first = self.time
        for i in range(1, round((onset + span - first) / step) + 1):
            self.step_to(first + i * step)
            recorder.sample()
        return onset, recorder.result()

    def save(self) -> Saved:
        """The state of the instance, from which any run of the same FMU can continue, even in another process."""
        return Saved(self.time, self._call(self.slave.to_bytes))

    def load(self, saved: Saved) -> None:
        """Restores a saved state; the run continues bit-for-bit identically. The log is kept. Raises InvalidValue,
        FmuError."""
        needed("saved", saved, Saved, "what `save` returned")
        self._call(self.slave.go_to, saved.data)
        self.time, self._initialized = saved.time, True

    def recorder(self, record: Iterable[str]) -> "Recorder":
        """Records the named variables of this run, all elements where an array is named. Raises UnknownName."""
        return Recorder(self, list(dict.fromkeys(self.fmu.names(record))))

    def _by_type(self, names: Iterable[str]) -> list[tuple[str, list[str], list[Any]]]:
        """These variables by type: type, names, references."""
        known = [self.fmu.variables[name] for name in names]
        groups = {kind: [v for v in known if v.type == kind] for kind in dict.fromkeys(v.type for v in known)}
        return [(kind, [v.name for v in g], [v.valueReference for v in g]) for kind, g in groups.items()]


class Recorder:
    """Reads a fixed set of variables with one call per type."""

    def __init__(self, run: Run, names: list[str]):
        self._run, self._names, self._groups = run, names, run._by_type(names)
        self._rows: list[tuple[Any, ...]] = []

    def row(self) -> list[Any]:
        """The values now, in the order of the names."""
        values: dict[str, Any] = {}
        for kind, names, references in self._groups:
            values |= zip(names, self._run._call(self._run.slave.read, kind, references), strict=True)
        return [values[name] for name in self._names]

    def sample(self) -> None:
        """Keeps the values at the run's current time."""
        self._rows.append((self._run.time, *self.row()))

    def result(self) -> Result:
        """All samples and pulses so far and, while the run is open, its parameters and inputs."""
        fmu = self._run.fmu
        types = [("time", "f8"), *((name, DTYPES[fmu.variables[name].type]) for name in self._names)]
        units = {"time": "s"} | {name: fmu.unit(name) for name in self._names}
        names = [v.name for v in fmu.variables.values() if v.causality in GIVEN]
        given = {} if self._run._closed else dict(zip(names, self._run.recorder(names).row(), strict=True))
        return Result(np.array(self._rows, dtype=types), self._run.pulses, units, fmu, given)
