"""Open an FMU, start instances of it, or run it from start to stop.

FMPy's `simulate_fmu` is the right tool for an ordinary run. This package drives FMPy's slave directly
where you need more: a table of all pulses, nanosecond steps at an impact, or control over each step.
"""

import hashlib
import os
import platform
import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, suppress
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from . import archive, files
from .archive import Archive
from .errors import MOST_STEPS, FmuError, InvalidValue, needed, number
from .interrupts import Held
from .run import Model, Result, Run
from .run.calls import FMI2, FMI3
from .run.description import Description
from .run.instance import free
from .run.model import GIVEN, Values
from .run.parts import of_last_step
from .run.recorder import columns

IDLE = 8  # instances that wait for the next run
KEPT = 15  # sets of recorded variables whose dtype and units are cached
A_FUNCTION = 'a function such as `nc.Progress("Run")`'  # of the fraction done


def described(opened: Archive) -> Description:
    """The description in the file of an FMU. Raises FmuError."""
    return Description(opened.description(), opened.path)


class Fmu(Model, AbstractContextManager["Fmu"]):
    """An unpacked FMU. It can have any number of runs, also at the same time. It can be pickled; the other process
    opens the file anew.

    `path`: the file; if None, the FMU that comes with the package or, in a checkout, the one that was built last.
    `folder`: where to unpack it, a new folder or an empty one; if None, a temporary one. `close`, or the end of the
    program, removes what was unpacked.
    Raises FileMissing, InvalidValue or FmuError.
    """

    def __init__(self, path: str | Path | None = None, folder: str | Path | None = None):
        needed("path", path, str | Path | None, "the path of an .fmu file")
        needed("folder", folder, str | Path | None, "the path of a folder")
        path = files.newest(files.FMU) if path is None else Path(path)
        self._archive = Archive(path)
        super().__init__(self._archive.path, described(self._archive))
        known = self.described
        if not (known.fmi2 or (known.version.startswith("3.") and self.is_cradle)) or not self._identifier:
            what = f"an FMU of FMI {known.version}, the model {known.model}"
            raise FmuError(f"{path} is {what}; allowed: FMI 2.0 for co-simulation, or {files.MODEL} of FMI 3.0")
        self._idle: list[Any] = []
        self._columns: dict[tuple[str, ...], tuple[Any, dict[str, str], dict[str, str]]] = {}
        self._held: list[Callable[[], None]] = []  # functions that free the library
        with Held():  # so that no signal leaves a folder that nothing removes
            self._folder = archive.temporary() if folder is None else Path(folder).absolute()
            remove: Callable[[], None] = partial(archive.remove, self._folder, os.getpid())
            if folder is not None:
                remove = archive.emptied(self._folder, self._archive.names)
            self._remove = weakref.finalize(self, _end, remove, self._idle, self._held)
        try:
            self._archive.unpack(self._folder, self._runs_here if folder is None else lambda _: True)
        except BaseException:
            self._remove()
            raise

    @property
    def _identifier(self) -> str:
        return self.described.identifiers.get("CoSimulation", "")

    def _runs_here(self, name: str) -> bool:
        """Whether a run needs this file. An FMU of another model may need all of its files."""
        return not self.is_cradle or name.startswith(("binaries/", "resources/"))

    @property
    def folder(self) -> Path:
        """The folder with the unpacked FMU."""
        self._archive.unpack(self._folder, lambda _: True)
        return self._folder

    def machines(self) -> list[str]:
        """The platform folders in `binaries`, sorted."""
        return self._archive.machines()

    @cached_property
    def description(self) -> Any:
        """The whole description as FMPy's object. Raises FmuError."""
        from fmpy import read_model_description

        try:
            return read_model_description(str(self.path))
        except Exception as problem:  # FMPy lets its parser's exceptions through
            raise FmuError(f"{self.path} is not an FMU that FMPy can read: {problem}") from problem

    def __repr__(self) -> str:
        return super().__repr__() if self._remove.alive else f"Fmu({self.path.name}, closed)"

    def __reduce__(self) -> tuple[Any, ...]:
        return Fmu, (self.path,)

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Removes the unpacked files."""
        self._remove()

    def check_open(self) -> None:
        """Raises FmuError if it is closed."""
        if not self._remove.alive:
            raise FmuError(f"{self.path.name} is closed: its `with` block has ended, or `close` was called")

    def taken(self, options: dict[str, Any]) -> Any:
        """An instance for a run, new or reset. Raises FmuError."""
        self.check_open()
        if not options:
            with suppress(IndexError):
                return self._idle.pop()
        from .run import slaves  # FMPy, which takes a while to import

        made = slaves.instance(self, self._folder, options.pop("exchange", False))
        if not self._held:
            self._held.append(slaves.hold(made))
        made.again = self.is_cradle and not options and "Slave" in type(made).__name__
        return made

    def give_back(self, instance: Any, again: bool) -> None:
        """Takes back the instance of a run that has ended: keeps it for the next run if `again`, else frees it."""
        if again and instance.again and self._remove.alive and len(self._idle) < IDLE:
            with suppress(Exception):
                instance.reset()
                self._idle.append(instance)
                return
        free(instance)

    @cached_property
    def of_last_step(self) -> tuple[tuple[str, ...], Any]:
        """See `parts.of_last_step`."""
        return of_last_step(self)

    @cached_property
    def given_names(self) -> tuple[str, ...]:
        """The parameters and inputs that results keep."""
        place, types = self.variables.place, FMI2 if self.fmi2 else FMI3
        return tuple(name for name in self.variables.named(*GIVEN) if place(name).type in types)

    def columns(self, names: tuple[str, ...]) -> tuple[Any, dict[str, str], dict[str, str]]:
        """Dtype, units and dimensions that results of these variables share; see `recorder.columns`."""
        if names not in self._columns:
            self._columns = dict(list(self._columns.items())[-KEPT:]) | {names: columns(self, names)}
        return self._columns[names]

    def require(self, *, balls: int | None = None, starts: Values | None = None) -> None:
        """Raises FmuError unless this is a cradle of this many balls, built with these start values.

        For programs that would fail, or give wrong numbers, with another cradle.
        """
        what = f"{self.path} is refused: "
        if not self.is_cradle:
            raise FmuError(f"{what}it is the model {self.described.model}; allowed: {files.MODEL}")
        if balls is not None and self.balls != balls:
            raise FmuError(f"{what}it has {self.balls} balls where {balls} are needed")
        others = [
            f"{name} = {self._text(name, own)} where {self._text(name, value)} is needed"
            for name, value in self.settings(starts or {}).items()
            if (own := self.built_with(name)) != value
        ]
        if others:
            cure = "`cradle-fmu build` without --preset and --set makes the default one"
            raise FmuError(f"{what}it was built as another cradle, {', '.join(others)}; {cure}")

    def _text(self, name: str, value: float | int | bool) -> str:
        """A value of a variable as it is written, with its unit."""
        unit = self.unit(name)
        return self.written(name, value, "g") + ("" if unit in ("", "1") else f" {unit}")

    def provenance(self) -> dict[str, str]:
        """What to store with results: file, GUID and checksum of the FMU, and versions of what ran it."""
        from importlib import metadata  # only here, because it takes a while

        return {
            "fmu": self.path.name,
            "guid": self.described.token,
            "sha256": hashlib.sha256(self.path.read_bytes()).hexdigest(),
            "model": f"{self.described.model} {self.described.root.get('version', '')}",
            "newtons-cradle": files.version(),
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.machine()}",
            **{name: metadata.version(name) for name in ("fmpy", "numpy")},
        }

    def start(self, values: Values | None = None, *, initialize: bool = True, **options: Any) -> Run:
        """A run at its start time; see `Run`. Use it in a `with` block, which ends it. `options`: `exchange=True` for
        model exchange, and those of the instantiation in FMI 3.0, such as `eventModeUsed=True` for a master that steps
        `run.slave` itself."""
        return Run(self, values, initialize=initialize, **options)

    def simulate(
        self,
        values: Values | None = None,
        *,
        stop: float = 10.0,
        step: float = 0.01,
        times: Iterable[float] | None = None,
        record: Iterable[str] | None = None,
        inputs: Callable[[float], Values | None] | None = None,
        control: Callable[[Run], Values | None] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Runs from 0 to `stop` (s) in equal steps of about `step` (s) and records at each.

        `values`: start values by name, see `Run.set`. `times`: the communication points (s, rising, from 0 on) instead
        of equal steps. `record`: names of variables or arrays; if None, all outputs and E_residual, which takes two or
        three times as long as `["x", "v"]`; all that there is: `record=fmu.variables`. `inputs(t)`: a dict of inputs
        for the step that begins at t (s), or None for no change. `control(run)`: a controller, called before each step,
        which may read the run, `run["v[1]"]`, set its inputs, or return a dict of them. `progress(fraction)`: called up
        to 200 times. Raises FmuError, UnknownName, InvalidValue.
        """
        points = equal_steps(stop, step) if times is None else rising(times)
        needed("inputs", inputs, Callable | None, "a function `inputs(t)` that returns a dict")
        needed("control", control, Callable | None, "a function `control(run)` that returns a dict or None")
        needed("progress", progress, Callable | None, A_FUNCTION)
        with self.start(values) as run:
            recorder = run.recorder(self.to_record(record))
            recorder.reserve(len(points) + 1)
            recorder.sample()
            if inputs is None and control is None and progress is None:
                recorder.steps(points)
                return recorder.result()
            for i, time in enumerate(points, start=1):
                if inputs is not None:
                    run.set(returned("inputs(t)", inputs(run.time)))
                if control is not None:
                    run.set(returned("control(run)", control(run)))
                run.step_to(time)
                recorder.sample()
                if progress is not None and (i * 200 // len(points) != (i - 1) * 200 // len(points)):
                    progress(i / len(points))
            return recorder.result()

    def to_record(self, record: Iterable[str] | None) -> tuple[str, ...]:
        """The variables that `simulate` records. Raises UnknownName, InvalidValue."""
        return self.recorded(self._outputs if record is None else record)

    @cached_property
    def _outputs(self) -> list[str]:
        """The names that are recorded by default."""
        return [*self.variables.named("output"), *(["E_residual"] if "E_residual" in self.variables else [])]


def returned(function: str, values: Values | None) -> Values:
    """Checks what a user's function returned; {} for None. Raises InvalidValue unless it is a dict or None."""
    needed(function, values, Mapping | None, 'a returned dict of inputs, such as {"F_ext[1]": 0.2}, or None,')
    return values or {}


def _end(remove: Callable[[], None], idle: list[Any], held: list[Callable[[], None]]) -> None:
    """Frees the idle instances and the library, and removes the unpacked files."""
    with Held():
        while idle:
            free(idle.pop())
        while held:
            held.pop()()
        remove()


def equal_steps(stop: float, step: float) -> list[float]:
    """The ends (s) of equal steps up to `stop` (s), about `step` (s) long. Raises InvalidValue."""
    stop, step = (number(name, value, "s", positive=True) for name, value in (("stop", stop), ("step", step)))
    if stop / step > MOST_STEPS:
        many = f"up to {stop} s that makes {stop / step:.2g} steps"
        raise InvalidValue(f"step = {step} is refused: {many}; allowed: {MOST_STEPS}")
    steps = max(1, round(stop / step))
    return [stop * i / steps for i in range(1, steps + 1)]


def rising(times: Iterable[float]) -> list[float]:
    """The ends of the steps between these times (s). Raises InvalidValue unless they begin at 0 and rise."""
    try:
        points = np.array(list(times), dtype=float)
    except (TypeError, ValueError):
        points = np.zeros(0)
    if points[:1].tolist() != [0.0] or not np.all(np.diff(points) > 0.0) or not np.isfinite(points).all():
        raise InvalidValue(
            "times: a list of communication points (s) is needed that begins at 0 and rises, each finite"
        )
    return [float(point) for point in points[1:]]
