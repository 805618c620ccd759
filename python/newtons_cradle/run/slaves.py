"""FMPy's instances of FMI 2.0 and 3.0, whose log goes to a buffer. Variables are read and set by name."""

import os
from collections.abc import Callable, Mapping, Sequence
from ctypes import CDLL, POINTER, byref, c_bool, c_char_p, c_double, c_size_t, c_uint, c_void_p, cast
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any, ClassVar
from weakref import WeakValueDictionary

import numpy as np
from fmpy import freeLibrary, platform, platform_tuple, sharedLibraryExtension
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave, fmi3IntermediateUpdateCallback
from fmpy.logging import addLoggerProxy

from ..errors import FmuError
from ..files import MODEL
from ..pulses import Array
from .calls import Calls
from .description import Variable
from .log import NAME, Sink
from .model import Model, split

# Messages of other FMUs of FMI 2.0 have arguments, as of printf. FMPy's proxy formats them, but keeps one logger for
# the process: the last one registered gets the messages of every instance. So they share `_logger`, and the
# componentEnvironment, which the FMU hands back, tells them apart.
_sinks: WeakValueDictionary[int, Sink] = WeakValueDictionary()


@fmi2CallbackLoggerTYPE  # type: ignore[untyped-decorator]
def _logger(environment: int, _instance: bytes, status: int, *texts: bytes | None) -> None:
    if (sink := _sinks.get(environment)) is not None:
        sink.take(status, *texts)


#: FMPy changes the current folder while it loads a library, and stays there if that fails.
_current_folder = Lock()


def folders(fmi2: bool) -> tuple[str, ...]:
    """The folders in `binaries` that may have the library for this machine."""
    # FMPy looks for FMI 2.0 in linux64 even on ARM; FMI 2.0.4 names aarch64-linux, as FMI 3.0 does.
    return (platform_tuple, platform) if fmi2 else (platform_tuple,)


def library(fmu: Model, folder: Path) -> Path:
    """The library for this machine in the unpacked FMU. Raises FmuError."""
    name = f"{fmu.described.identifiers['CoSimulation']}{sharedLibraryExtension}"
    places = [folder / "binaries" / machine for machine in folders(fmu.fmi2)]
    for place in places:
        if (place / name).is_file():
            return place / name
    if any(place.is_dir() for place in places):
        raise FmuError(f"{fmu.path.name} is incomplete: its binaries for this machine have no {name}")
    has = ", ".join(fmu.machines()) or "no machine"
    raise FmuError(f"{fmu.path.name} has binaries for {has} only; this machine needs {folders(fmu.fmi2)[-1]}")


class Instance:
    """What instances of both versions share. Variables are read and set by name, arrays of FMI 3.0 as a whole;
    elements, `x[1]`, can be read only."""

    def __init__(self, fmu: Model, folder: Path):
        described = fmu.described
        identifier, path = described.identifiers["CoSimulation"], library(fmu, folder)
        given = {"guid": described.token, "modelIdentifier": identifier, "unzipDirectory": str(folder)}
        with _current_folder:
            try:
                before = os.getcwd()
            except OSError as problem:
                raise FmuError("the current folder is not there any more: change to another one") from problem
            try:
                super().__init__(**given, instanceName=NAME, libraryPath=str(path))  # type: ignore[call-arg]
            except Exception as problem:  # FMPy raises Exception alone
                os.chdir(before)
                raise FmuError(_not_loaded(path, problem)) from problem
        self.variables: Mapping[str, Variable] = described.described
        self.description, self.balls = described, fmu.balls
        self.sink = Sink(fmu.fmi2)
        self.own = described.model == MODEL

    def prepared(self: Any) -> Calls:
        """The calls of this instance, once it is created."""
        return Calls(self, self.description)

    def references(self, *names: str) -> list[int]:
        """Value references of these variables."""
        return [self.variables[name].valueReference for name in names]

    def to_bytes(self: Any) -> bytes:
        """The FMU's state, serialized."""
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
        self.calls.resized(balls)

    def vector(self, what: str, length: int) -> Array:
        """What this getter of model exchange fills, such as `getContinuousStates`."""
        values = np.zeros(length)
        getattr(self, what)(values.ctypes.data_as(POINTER(c_double)), length)
        return values

    def get(self, name: str) -> Any:
        """The value of a variable; of an array, a NumPy array."""
        array, index = (name, None) if name in self.variables else split(name)
        variable = self.variables[array]
        length = [self.balls] if variable.length else []
        values = self._accessor("get", variable)([variable.valueReference], *length)
        return np.array(values) if length and index is None else values[(index or 1) - 1]

    def set(self, name: str, value: Any) -> None:
        """Sets a variable, an enumeration also by the name of its item; of an array all elements."""
        variable = self.variables[name]
        if isinstance(value, str):
            value = variable.items[value]
        self._accessor("set", variable)([variable.valueReference], np.atleast_1d(value).tolist())

    def _accessor(self: Any, prefix: str, variable: Variable) -> Callable[..., Any]:
        function: Callable[..., Any] = getattr(self, prefix + self.kinds.get(variable.type, variable.type))
        return function


def _not_loaded(path: Path, problem: BaseException) -> str:
    """Why a library cannot be loaded."""
    if "failed to map segment" in str(problem) or "Operation not permitted" in str(problem):
        cure = "set TMPDIR to another one, or give `folder=`"
        return f"no program may run from the folder {path.parents[2]}, which has the unpacked FMU; {cure}"
    return f"{path.name} cannot be loaded: {problem}"


class Version2(Instance):
    """An instance of FMI 2.0."""

    kinds: ClassVar = {"Enumeration": "Integer"}

    def create(self: Any, **options: Any) -> None:
        """Instantiates it; pulses, warnings and errors are logged."""
        if options:
            raise FmuError(f"{', '.join(options)} is refused: only FMUs of FMI 3.0 have such options")
        functions = fmi2CallbackFunctions()
        if self.own:
            functions.logger = cast(self.sink.callback, fmi2CallbackLoggerTYPE)
        else:
            functions.logger = _logger
            addLoggerProxy(byref(functions))
        functions.componentEnvironment = self.sink.address()
        _sinks[functions.componentEnvironment] = self.sink
        self.instantiate(callbacks=functions)
        self.setDebugLogging(True, ["logEvents", "logStatusWarning"])

    def enterInitializationMode(self: Any, startTime: float = 0.0) -> None:
        self.setupExperiment(startTime=startTime)
        super().enterInitializationMode()  # type: ignore[misc]


class Version3(Instance):
    """An instance of FMI 3.0."""

    kinds: ClassVar = {"Real": "Float64", "Integer": "UInt64", "Enumeration": "Int64"}

    def create(
        self: Any,
        *,
        visible: bool = False,
        loggingOn: bool = True,
        eventModeUsed: bool = False,
        earlyReturnAllowed: bool = False,
        intermediateUpdate: Callable[..., Any] | None = None,
        requiredIntermediateVariables: Sequence[int] = (),
    ) -> None:
        """Instantiates it; pulses, warnings and errors are logged.

        It does not use FMPy's function, which takes no environment for the logger, and the path only as text."""
        names = (
            self.instanceName.encode(),
            self.guid.encode(),
            os.fsencode(os.path.join(self.unzipDirectory, "resources", "")),
        )
        given = [*map(c_char_p, names), c_bool(visible), c_bool(loggingOn)]
        log = c_void_p(self.sink.address()), self.sink.callback
        if isinstance(self, FMU3Model):
            function, arguments = self.dll["fmi3InstantiateModelExchange"], [*given, *log]
        else:
            count = len(requiredIntermediateVariables)
            required = (c_uint * count)(*requiredIntermediateVariables), c_size_t(count)
            # Without arguments this makes a null pointer.
            update = (intermediateUpdate,) if intermediateUpdate else ()
            self.intermediateUpdate = fmi3IntermediateUpdateCallback(*update)
            modes = c_bool(eventModeUsed), c_bool(earlyReturnAllowed)
            function = self.dll["fmi3InstantiateCoSimulation"]
            arguments = [*given, *modes, *required, *log, self.intermediateUpdate]
        function.restype = c_void_p
        self.component = function(*arguments)
        if not self.component:
            raise RuntimeError("the FMU cannot be instantiated")
        self.setDebugLogging(False, ["logSolver"])


def instance(fmu: Model, folder: Path, exchange: bool) -> Any:
    """A new instance of this FMU, for co-simulation or model exchange."""
    version, kinds = (Version2, (FMU2Slave, FMU2Model)) if fmu.fmi2 else (Version3, (FMU3Slave, FMU3Model))
    kind = kinds[exchange]
    return type(kind.__name__, (version, kind), {})(fmu, folder)  # FMPy goes by the first letters of the name


def hold(instance: Any) -> Callable[[], None]:
    """Keeps an instance's library loaded until the returned function is called, so that later instances find its static
    data."""
    return partial(freeLibrary, CDLL(instance.dll._name)._handle)
