"""A running instance of an FMU, stepped as finely as you like."""

import math
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from ctypes import c_double
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MOST_STEPS, FmuError, InvalidValue, needed, number, warn
from ..pulses import Array
from . import derivatives
from .calls import WARNING, Access, Failure
from .log import Log
from .model import Value, Values, concerns, given
from .parts import NONE, NOTHING, PROMPT, Parts, length
from .recorder import Recorder
from .result import Result

if TYPE_CHECKING:
    from ..fmu import Fmu

LOOKS = 10_000  # steps to find the next onset by
NEVER = 1e30  # s, what `t_next` says when no impact lies ahead


def free(instance: Any) -> None:
    """Ends an instance of FMPy, if it was created."""
    if instance.component:
        instance.freeInstance()


@dataclass(frozen=True)
class Saved:
    """A saved state: its time (s), the bytes, whether steps are made `whole` rather than in parts, and the means over a
    last step made in parts."""

    time: float
    data: bytes = field(repr=False)
    whole: bool = field(default=False, repr=False, compare=False)
    means: Mapping[str, float] = field(default_factory=dict, repr=False, compare=False)


class Run(AbstractContextManager["Run"]):
    """One instance, initialised and ready to step. `values`: start values by variable name, as `set` takes them.

    `run["F_ext[1]"] = 0.2` sets a variable; `run["v[1]"]` is the current value of one. With `initialize=False` the
    instance is only instantiated, and the caller must call `initialize()`. With `exchange=True` it is one for model
    exchange, which the caller integrates through `slave`.

    Ctrl-C and other signals end a step as soon as the FMU returns, and long steps are made in parts for that. The run
    stays at the time that it has reached, and can go on. No pulse and no message is lost.
    """

    def __init__(self, fmu: "Fmu", values: Values | None = None, *, initialize: bool = True, **options: Any):
        self.fmu, self._time = fmu, 0.0
        self._closed = self._initialized = self._failed = self._lent = False
        self._given: frozenset[str] = frozenset()  # the names of start values, without those of presets
        self._in_step = False  # a signal may interrupt a step before its time is noted
        self._names: dict[str, tuple[str, ...]] = {}  # the variables that a name stands for
        self._inputs: dict[tuple[str, ...], Access] = {}  # checked already, for what is set in each step
        self._instance = fmu.taken(options)
        self._dropped = weakref.finalize(self, free, self._instance)  # if the user forgets to close it
        self._dropped.atexit = False  # other threads may still use it then
        self.log = Log(self._instance.sink)
        self._parts = Parts(fmu, special=not self._instance.again)
        try:
            if self._instance.component is None:
                self._call(self._instance.create, **options)
                self._instance.calls = self._instance.prepared()
            self._calls = self._instance.calls
            self.set({} if values is None else values)
            if initialize:
                self.initialize()
        except BaseException:
            self._failed = True
            self.close()
            raise

    def initialize(self, start_time: float = 0.0) -> None:
        """Initialises an instance that was only instantiated, at its start time (s). Raises FmuError."""
        begin = self.log.mark()
        self._call(self._instance.enterInitializationMode, startTime=start_time)
        self._call(self._instance.exitInitializationMode)
        self._time, self._initialized = start_time, True
        if self._given and self.log.mark() > begin:
            for line in self.log.since(begin):
                if line.category == "logStatusWarning" and concerns(line.text, self._given):
                    warn(line.text)

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"at {self.time:.9g} s"
        return f"Run({self.fmu.path.name}, {state}; {len(self.pulses)} pulses)"

    def __exit__(self, kind: object, *_: object) -> None:
        self._failed = self._failed or kind is not None
        self.close()

    def close(self) -> None:
        """Ends the run; the log and the pulses stay readable."""
        if not self._closed:
            if self._instance.again:  # other FMUs may be too broken to be asked for the time
                self.time = self.time
            self._closed = True
            self._dropped.detach()
            self.log.release()
            self.fmu.give_back(self._instance, again=not (self._failed or self._lent))

    @property
    def slave(self) -> Any:
        """FMPy's instance, for functions of FMI that a run has no method for. It ends when the run is closed."""
        if not self._lent:
            self._check_open()  # another run may have it now
            self._lent = True
            self._dropped.detach()
            self._parts.end()
        return self._instance

    def _call(self, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """Calls a function of FMPy. Raises FmuError."""
        self._check_open()
        try:
            return function(*args, **kwargs)
        except FmuError:
            raise
        except Exception as error:
            raise self._refusal(str(error)) from error

    def _check_open(self) -> None:
        if self._closed:
            raise FmuError("the run is closed: its `with` block has ended, or `close` was called")

    def _refusal(self, otherwise: str, kind: type[FmuError | InvalidValue] = FmuError) -> Exception:
        """The error to raise, with the FMU's messages without the function's name, or `otherwise` if it has logged
        none."""
        lines, self._failed = self.log.news(), True
        said = [line for line in lines if line.status > WARNING] or [line for line in lines if line.status]
        return kind("; ".join(line.text.partition(": ")[2] for line in said) or otherwise)

    def _done(self, failure: Failure, kind: type[FmuError | InvalidValue] = FmuError) -> None:
        """Raises if a prepared call has failed."""
        if failure[1]:
            raise self._refusal(f"{failure[0]} has failed with status {failure[1]}", kind)

    @property
    def pulses(self) -> Array:
        """All finished pulses so far, by onset: array of dtype `PULSE`."""
        return self.log.pulses()

    def set(self, values: Values) -> None:
        """Sets parameters and inputs by name, with one call for each type.

        An array takes a sequence, `{"x_start": [-0.1, 0, 0, 0, 0]}`; an enumeration takes the name or the number of an
        item; a number may have a unit that the FMU lists, `(2.6, "um")`. Raises UnknownName, InvalidValue.
        """
        self._check_open()
        again = self._inputs.get(tuple(values)) if isinstance(values, dict) else None
        if again is not None and all(isinstance(value, float) for value in values.values()):
            self._done(again.write(list(values.values())), InvalidValue)
            return
        numbers = self.fmu.settings(values)
        if not numbers:
            return
        if not self._initialized:
            self._given |= given(values)
        self._parts.note(values)
        access = self._calls.access(tuple(numbers))
        self._done(access.write(list(numbers.values())), InvalidValue)
        if all(name in numbers and self.fmu.variables[name].is_real_input for name in values):
            self._inputs[tuple(values)] = access

    def get(self, name: str) -> float | int | bool:
        """The value of one variable. Raises UnknownName or FmuError."""
        self.fmu.variable(name)
        value: float | int | bool = self._read((name,))[0]
        return value

    def _read(self, names: Sequence[str]) -> list[Any]:
        """The values of these variables."""
        self._check_open()
        access = self._calls.access(names)
        self._done(access.read())
        values, over = access.values(), self._parts.means
        return [over.get(name, value) for name, value in zip(names, values, strict=True)] if over else values

    def __setitem__(self, name: str, value: Value | Sequence[Value] | Array) -> None:
        self.set({name: value})

    def __getitem__(self, name: str) -> Any:
        """The value of a variable; for an array, the values of all elements, shape (elements,)."""
        names = self._names.get(name) if isinstance(name, str) else None
        if names is None:
            names = self._names[name] = tuple(self.fmu.names([name]))
        values = self._read(names)
        return values[0] if names == (name,) else np.array(values)

    def __contains__(self, name: object) -> bool:
        """Whether the FMU has this variable or array."""
        return name in self.fmu.arrays or name in self.fmu.variables

    __iter__ = None  # else Python would iterate by run[0], run[1], ...

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.fmu.arrays, *self.fmu.variables]

    def step(self, h: float) -> None:
        """One communication step of `h` seconds. Raises InvalidValue, FmuError."""
        h = number("h", h, "s", positive=True)
        self._step(h, self.time + h)

    @property
    def time(self) -> float:
        """The time that the run has come to, s."""
        if self._in_step and not self._closed:  # a signal came before it was noted
            self._time, self._in_step = self._calls.time(self._time), False
        return self._time

    @time.setter
    def time(self, time: float) -> None:
        """For callers that have stepped `slave` themselves."""
        self._time, self._in_step = time, False

    def _step(self, h: float, end: float) -> None:
        """One communication step of `h` seconds to `end` (s), or to where the FMU returns early."""
        if not self._initialized or self._closed:
            self._check_open()
            raise FmuError("a step is refused before the run is initialized; call `initialize` first")
        if h > self._parts.longest:
            self._parts.step(self, end)
        else:
            self._parts.means = NOTHING
            self._single(h, end)

    def _single(self, h: float, end: float) -> None:
        calls = self._calls
        self._in_step, begin = True, perf_counter()
        status = calls.step(calls.component, c_double(self._time), c_double(h), *calls.step_tail)
        if status > WARNING:
            raise self._refusal(f"the step to t = {end} s has failed with status {status}")
        self._time = end if self._instance.again else calls.reached(end)
        self._in_step = False
        if perf_counter() - begin > PROMPT:
            self._parts.slow(h, perf_counter() - begin)

    def step_to(self, t: float) -> None:
        """One communication step that ends exactly at `t` (s), or earlier if the FMU may return early and does. Raises
        InvalidValue, FmuError."""
        if not (t := number("t", t, "s")) > self.time:
            raise InvalidValue(f"t = {t} s is refused; allowed: later than now, {self.time} s")
        self._step_to(t)

    def _step_to(self, t: float) -> None:
        self._step(length(self.time, t), t)

    def until(self, t: float, step: float) -> Iterator[float]:
        """Steps to `t` (s) on the grid of multiples of `step` (s), for a `for` loop. The loop gets the start of each
        step; what it sets there acts in that step. Raises InvalidValue, FmuError.

        `for time in run.until(20.0, 0.01): run["F_ext[1]"] = -0.5 * run["v[1]"]`
        """
        t, step = number("t", t, "s", least=self.time), number("step", step, "s", positive=True)
        if t / step > MOST_STEPS:
            many = f"up to {t} s that makes {t / step:.2g} steps"
            raise InvalidValue(f"step = {step} is refused: {many}; allowed: {MOST_STEPS}")
        return self._until(t, step)

    def _until(self, t: float, step: float) -> Iterator[float]:
        # A point of the grid that differs from t, or from the current time, by rounding only counts as equal.
        k, last = math.floor(self.time / step * (1.0 + 1e-12) + 1e-9) + 1, math.ceil(t / step * (1.0 - 1e-12) - 1e-9)
        while self.time < t:
            yield self.time
            end = t if k >= last else k * step
            if end > self.time:  # the loop may have made steps of its own
                self._step_to(end)
            k += 1

    def step_to_onset(self, before: float = 0.0) -> float:
        """Steps to the next onset, or to `before` seconds ahead of it (not negative); returns the time of the onset.

        If a contact phase is so long that the FMU does not see its end, this takes several steps. Raises FmuError if
        no contact will close any more, or if none is in sight after many steps; InvalidValue.
        """
        before = number("before", before, "s", least=0.0)
        for _ in range(LOOKS):
            onset = float(self.get("t_next"))
            if onset >= NEVER:
                raise FmuError(f"no contact closes any more after t = {self.time} s")
            if self._is_onset(onset):
                if onset - before > self.time:
                    self.step_to(onset - before)
                return onset
            # The FMU looks further ahead once time has moved.
            self.step_to(max(onset - before, math.nextafter(self.time, math.inf)))
        raise FmuError(f"no contact closes within {LOOKS} looks ahead, up to t = {onset} s")

    def _is_onset(self, ahead: float) -> bool:
        """Whether `t_next` is an onset. Without a variable for it, as in FMI 3.0, a step to that time shows it."""
        if "t_next_isOnset" in self.fmu.variables:
            return bool(self.get("t_next_isOnset"))
        here, mark, before = self.save(), self.log.mark(), self["pulses"]
        try:
            self.step_to(ahead)
            return bool((self["pulses"] > before).any())
        finally:
            self.load(here)
            self.log.cut(mark)

    def zoom(self, span: float, step: float, record: Iterable[str], before: float = 0.0) -> tuple[float, Result]:
        """The micro view of the next impact: records every `step` (s) from `before` (s) ahead of the onset until `span`
        (s) after it. Returns the time of the onset and the samples. Raises InvalidValue, FmuError."""
        step = number("step", step, "s", positive=True, most=number("span", span, "s", positive=True))
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
        parts = self._parts
        return Saved(self.time, self._call(self._instance.to_bytes), parts.longest == NONE, parts.means)

    def load(self, saved: Saved) -> None:
        """Restores a saved state; the run continues bit-for-bit identically. The log is kept. Raises InvalidValue,
        FmuError."""
        needed("saved", saved, Saved, "what `save` returned")
        self._call(self._instance.go_to, saved.data)
        self._time, self._initialized, self._in_step = saved.time, True, False
        self._parts.means = saved.means
        if saved.whole:
            self._parts.end()

    def recorder(self, record: Iterable[str]) -> Recorder:
        """Records the named variables of this run, all elements where an array is named. Raises UnknownName."""
        return Recorder(self, self.fmu.recorded(record))

    def derivative(self, of: str | Sequence[str], by: str | Sequence[str], *, over: str = "run") -> Array:
        """The derivatives of outputs at the current time by parameters or inputs; see `derivatives.matrix`."""
        return derivatives.matrix(self, of, by, over)

    def gradient(self, of: str, by: Sequence[str], *, over: str = "run") -> dict[str, Any]:
        """The derivatives of one output by these parameters or inputs, by name; see `derivatives.gradient`."""
        return derivatives.gradient(self, of, by, over)
