"""FMPy's instances of FMI 2.0 and 3.0: their log goes to a list, variables are read and set by type or by name."""

from collections.abc import Callable
from ctypes import POINTER, byref, c_double
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from fmpy import platform, platform_tuple, sharedLibraryExtension
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.logging import addLoggerProxy

from ..errors import FmuError
from ..pulses import Array
from .model import Model, Place, split


@dataclass(frozen=True)
class LogLine:
    """One message of an FMU: FMI status (0 OK, 1 warning, 3 error, 4 fatal), category and text."""

    status: int
    category: str
    text: str


class Log(list[LogLine]):
    """The messages of one instance."""

    def take(self, status: int, *texts: bytes | None) -> None:
        """A message as C passes it: status, category, text."""
        self.append(LogLine(status, *((text or b"").decode("utf-8", "replace") for text in texts)))


# FMPy's proxy formats C-style messages, but keeps one logger for the process: the last one registered gets the messages
# of every instance. So all runs of FMI 2.0 share `_logger`, and the componentEnvironment, which the FMU hands back,
# tells them apart. (A `simulate_fmu(..., logger=...)` that starts during a run takes over its later messages.)
_logs: WeakValueDictionary[int, Log] = WeakValueDictionary()


@fmi2CallbackLoggerTYPE  # type: ignore[untyped-decorator]
def _logger(environment: int, _instance: bytes, status: int, *texts: bytes | None) -> None:
    if (log := _logs.get(environment)) is not None:
        log.take(status, *texts)


class Instance:
    """What all kinds of instances have. Variables are read and set by name, arrays of FMI 3.0 as a whole, or read by
    element, `x[1]`."""

    def __init__(self, fmu: Model):
        identifier, guid = fmu.description.coSimulation.modelIdentifier, fmu.description.guid
        given = {"guid": guid, "modelIdentifier": identifier, "unzipDirectory": fmu.folder}
        # FMPy looks in linux64 for FMI 2.0 on ARM, too; FMI 2.0.4 has aarch64-linux, as FMI 3.0.
        folders, library = Path(fmu.folder, "binaries"), identifier + sharedLibraryExtension
        paths = [path for name in (platform_tuple, platform) if (path := folders / name / library).is_file()]
        if not paths:
            has = ", ".join(sorted(folder.name for folder in folders.glob("*"))) or "no machine"
            needs = platform if fmu.fmi2 else platform_tuple
            raise FmuError(f"{fmu.path.name} has binaries for {has} only; this machine needs {needs}")
        super().__init__(**given, instanceName="cradle", libraryPath=str(paths[0]))  # type: ignore[call-arg]
        self.variables, self.balls = fmu.described, fmu.balls

    def references(self, *names: str) -> list[int]:
        """Value references of these variables."""
        return [self.variables[name].valueReference for name in names]

    def to_bytes(self: Any) -> bytes:
        """The state."""
        state = self.getFMUState()
        data: bytes = self.serializeFMUState(state)
        self.freeFMUState(state)
        return data

    def go_to(self: Any, data: bytes) -> None:
        """Restores the state in these bytes."""
        state = self.deserializeFMUState(data)
        self.setFMUState(state)
        self.freeFMUState(state)

    def resize(self: Any, balls: int) -> None:
        """Makes it a cradle of this many balls (FMI 3.0)."""
        self.enterConfigurationMode()
        self.set("n", balls)
        self.exitConfigurationMode()
        self.balls = balls

    def vector(self, what: str, length: int) -> Array:
        """What this getter of model exchange fills, such as `getContinuousStates`."""
        values = np.zeros(length)
        getattr(self, what)(values.ctypes.data_as(POINTER(c_double)), length)
        return values

    def get(self, name: str) -> Any:
        """The value of a variable; of an array, a NumPy array."""
        array, index = (name, None) if name in self.variables else split(name)
        variable = self.variables[array]
        length = [self.balls] if variable.dimensions else []
        values = self._accessor("get", variable.type)([variable.valueReference], *length)
        return np.array(values) if length and index is None else values[(index or 1) - 1]

    def set(self, name: str, value: Any) -> None:
        """Sets a variable, an enumeration also by the name of its item; of an array all elements."""
        variable = self.variables[name]
        if isinstance(value, str):
            (value,) = (int(item.value) for item in variable.declaredType.items if item.name == value)
        self._accessor("set", variable.type)([variable.valueReference], np.atleast_1d(value).tolist())

    def _accessor(self: Any, prefix: str, kind: str) -> Callable[..., Any]:
        function: Callable[..., Any] = getattr(self, prefix + (self.whole if kind == "Enumeration" else kind))
        return function


class Version2(Instance):
    """An instance of FMI 2.0."""

    whole = "Integer"  # type of enumerations

    def create(self: Any, log: Log, **options: Any) -> None:
        """Instantiates it; pulses, warnings and errors are logged."""
        if options:
            raise FmuError(f"{', '.join(options)} is refused: only FMUs of FMI 3.0 have such options")
        functions = fmi2CallbackFunctions()
        functions.logger = _logger
        addLoggerProxy(byref(functions))
        functions.componentEnvironment = id(log)
        _logs[id(log)] = log
        self.instantiate(callbacks=functions)
        self.setDebugLogging(True, ["logEvents", "logStatusWarning"])

    def enterInitializationMode(self: Any, startTime: float = 0.0) -> None:
        self.setupExperiment(startTime=startTime)
        super().enterInitializationMode()  # type: ignore[misc]

    def read(self, kind: str, references: list[int]) -> list[Any]:
        values: list[Any] = self._accessor("get", kind)(references)
        return values

    def write(self, kind: str, references: list[int], values: list[Any]) -> None:
        self._accessor("set", kind)(references, values)


class Version3(Instance):
    """An instance of FMI 3.0, read and set by elements too."""

    whole = "Int64"

    def create(self: Any, log: Log, **options: Any) -> None:
        """Instantiates it; pulses, warnings and errors are logged."""
        options = {"loggingOn": True} | options
        self.instantiate(logMessage=lambda _, *said: log.take(*said), **options)
        self.setDebugLogging(False, ["logSolver"])

    def read(self, _kind: str, places: list[Place]) -> list[Any]:
        arrays = self._arrays(places)
        return [arrays[name][index] for name, index in places]

    def write(self, _kind: str, places: list[Place], values: list[Any]) -> None:
        """Sets these elements; the others of their arrays keep their values."""
        arrays = self._arrays(places)
        for (name, index), value in zip(places, values, strict=True):
            arrays[name][index] = value
        for name, elements in arrays.items():
            self.set(name, elements)

    def _arrays(self, places: list[Place]) -> dict[str, list[Any]]:
        """The arrays of these elements by name, with all their values."""
        return {name: np.atleast_1d(self.get(name)).tolist() for name in dict(places)}  # each array once


def instance(fmu: Model, exchange: bool) -> Any:
    """A new instance of this FMU, for co-simulation or model exchange."""
    version, kinds = (Version2, (FMU2Slave, FMU2Model)) if fmu.fmi2 else (Version3, (FMU3Slave, FMU3Model))
    kind = kinds[exchange]
    return type(kind.__name__, (version, kind), {})(fmu)  # FMPy goes by the first letters of the name
