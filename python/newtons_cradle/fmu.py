"""Open an FMU, or make one of another cradle; start instances of it, or run it from start to stop.

FMPy's `simulate_fmu` is the right tool for an ordinary run. This package drives FMPy's slave directly
where you need more: a table of all pulses, nanosecond steps at an impact, or control over each step.
"""

import hashlib
import platform
import shutil
import subprocess
import tempfile
import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description

from . import files
from .errors import MOST_BALLS, FmuError, InvalidValue, needed, number, warn, whole
from .run import Model, Result, Run
from .run.model import Values, meant

MOST_STEPS = 100_000_000  # of one run: their samples alone are gigabytes


class Fmu(Model, AbstractContextManager["Fmu"]):
    """An FMU, unpacked: start as many runs of it as you like, side by side if need be.

    `path`: the file; if None, the FMU that comes with the package or, in a checkout, the one that was built last.
    `folder`: where to unpack it; if None, a temporary folder. `close`, or the end of the program, removes it.
    Raises FileMissing, InvalidValue or FmuError.
    """

    def __init__(self, path: str | Path | None = None, folder: str | Path | None = None):
        needed("path", path, str | Path | None, "the path of an .fmu file")
        needed("folder", folder, str | Path | None, "the path of a folder")
        path = files.newest(files.FMU) if path is None else files.regular(Path(path))
        try:
            description = read_model_description(str(path))
        except Exception as problem:  # FMPy passes on its parser's exceptions
            raise FmuError(f"{path} is not an FMU that FMPy can read: {problem}") from problem
        own = description.modelName == files.MODEL and description.fmiVersion.startswith("3.")
        if not (own or description.fmiVersion.startswith("2.")) or description.coSimulation is None:
            what = f"an FMU of FMI {description.fmiVersion}, the model {description.modelName}"
            raise FmuError(f"{path} is {what}; allowed: FMI 2.0 for co-simulation, or {files.MODEL} of FMI 3.0")
        try:
            unpacked = extract(str(path), unzipdir=str(folder) if folder else None)
        except OSError as problem:
            raise FmuError(f"{path} cannot be unpacked: {problem}") from problem
        super().__init__(path, description, unpacked)
        self._remove = weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)

    def __repr__(self) -> str:
        return super().__repr__() if self._remove.alive else f"Fmu({self.path.name}, closed)"

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Removes the unpacked files."""
        self._remove()

    def require(self, *, balls: int | None = None, starts: Values | None = None) -> None:
        """Raises FmuError unless this is a cradle of this many balls, built with these start values.

        For programs that need a certain cradle, and would fail or give wrong numbers with another one.
        """
        what = f"{self.path} is refused: "
        if self.description.modelName != files.MODEL:
            raise FmuError(f"{what}it is the model {self.description.modelName}; allowed: {files.MODEL}")
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
        return {
            "fmu": self.path.name,
            "guid": self.description.guid,
            "sha256": hashlib.sha256(self.path.read_bytes()).hexdigest(),
            "model": f"{self.description.modelName} {self.description.version}",
            "newtons-cradle": files.version(),
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.machine()}",
            **{name: metadata.version(name) for name in ("fmpy", "numpy")},
        }

    def start(self, values: Values | None = None, *, initialize: bool = True, **options: bool) -> Run:
        """A run at its start time; see `Run`. Use it in a `with` block, which frees the instance. `options`:
        `exchange=True` for model exchange, and those of the instantiation in FMI 3.0, such as `eventModeUsed=True` for a master that steps `run.slave` itself."""
        if not self._remove.alive:
            raise FmuError(f"{self.path.name} is closed: its `with` block has ended, or `close` was called")
        return Run(self, values, initialize=initialize, **options)

    def simulate(
        self,
        values: Values | None = None,
        *,
        stop: float = 10.0,
        step: float = 0.01,
        times: Iterable[float] | None = None,
        record: Iterable[str] | None = None,
        inputs: Callable[[float], Values] | None = None,
        control: Callable[[Run], Values] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Runs from 0 to `stop` (s) in equal steps of about `step` (s) and records at each.

        `values`: start values by name, see `Run.set`. `times`: the communication points (s, rising, from 0 on) instead
        of equal steps. `record`: names of variables or arrays, all outputs and E_residual if None. `inputs(t)`: inputs
        for the step that begins at t. `control(run)`: inputs from a controller, which may read the run, `run["v[1]"]`.
        `progress(fraction)`: called up to 200 times. Raises FmuError, UnknownName, InvalidValue.
        """
        points = equal_steps(stop, step) if times is None else rising(times)
        for what, function in (("inputs", inputs), ("control", control), ("progress", progress)):
            needed(what, function, Callable | None, "a function")
        with self.start(values) as run:
            names = [*self.outputs, *(["E_residual"] if "E_residual" in self.variables else [])]
            recorder = run.recorder(names if record is None else record)
            recorder.sample()
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


def build(
    *,
    balls: int | None = None,
    preset: str | None = None,
    set: Mapping[str, Any] | None = None,
    fmi: int = 2,
    out: str | Path | None = None,
    binaries: str | Path | None = None,
) -> Fmu:
    """An FMU of a cradle of this many `balls`, from a `preset`, with other start values by `set`, as `cradle-fmu build`
    makes it; opened.

    `nc.build(balls=13, set={"x_start": [-0.1] + 12 * [0], "contact.model": "hertz"})`. `fmi`: the version of the
    standard, 2 or 3. `out`: where to write the file; if None, into a temporary folder, removed with the FMU. Nothing is
    compiled: `binaries` is the FMU whose binaries it gets; if None, the one that comes with the package. A preset has
    its own number of balls; for another, `balls=7, set=nc.preset("desk") | {"x_start": [-0.03] + 6 * [0]}`. Raises
    FmuError with what `cradle-fmu` says, InvalidValue, and FileMissing where that program is missing.
    """
    if balls is not None:
        whole("balls", balls, 1, MOST_BALLS)
    needed("preset", preset, str | None, "a name such as 'desk'")
    needed("set", set, Mapping | None, 'a dict such as {"ball.mass": 0.5}')
    whole("fmi", fmi, 2, 3)
    command: list[str | Path] = [files.producer(), "build", "--from", binaries or files.newest(files.FMU)]
    command += ["--fmi", str(fmi)]
    command += ["--balls", str(balls)] if balls is not None else []
    command += ["--preset", preset] if preset is not None else []
    for name, value in (set or {}).items():
        several = isinstance(value, (list, tuple)) or hasattr(value, "tolist")
        try:
            text = ",".join(map(repr, map(float, value))) if several else value
        except (TypeError, ValueError):
            allowed = "a number in the variable's SI unit, a list of them, or the name of an item"
            raise InvalidValue(f"{name} = {value!r} is refused; allowed: {allowed}") from None
        command += ["--set", f"{name}={text}"]
    folder = Path(tempfile.mkdtemp(prefix="cradle-"))
    path = Path(out or folder / "NewtonsCradle.fmu").absolute()
    done = subprocess.run([*command, "--out", path], capture_output=True, text=True)
    if done.returncode:
        shutil.rmtree(folder, ignore_errors=True)
        raise FmuError(done.stderr.strip().removeprefix("error: "))
    said = [line.removeprefix("warning: ") for line in done.stderr.splitlines() if line.startswith("warning: ")]
    for line in said if not meant(set or {}) else ():
        warn(line)
    fmu = Fmu(path)
    weakref.finalize(fmu, shutil.rmtree, folder, ignore_errors=True)
    return fmu


def returned(function: str, values: Values) -> Values:
    """What a function of the user's gave for a step. Raises InvalidValue unless it is a dict."""
    needed(function, values, Mapping, 'a returned dict of inputs, such as {"F_ext[1]": 0.2} or {},')
    return values


def equal_steps(stop: float, step: float) -> list[float]:
    """The ends (s) of equal steps up to `stop` (s), about `step` (s) long. Raises InvalidValue."""
    for name, value in (("stop", stop), ("step", step)):
        number(name, value, "s", positive=True)
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
    if points[:1].tolist() != [0.0] or not np.all(np.diff(points) > 0.0):
        raise InvalidValue("times: a list of communication points (s) is needed that begins at 0 and rises")
    return [float(point) for point in points[1:]]
