"""FMPy's slaves as runs use them, of FMI 2.0 and 3.0: their log goes to a list, variables are read and set by type."""

from pathlib import Path
from typing import Any

from fmpy import platform_tuple, sharedLibraryExtension
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from . import log
from .model import Model, Place

LARGEST = 2**31 - 1  # that counters show, as in FMI 2.0


def arguments(fmu: Model) -> dict[str, str]:
    """What FMPy makes an instance of."""
    identifier = fmu.description.coSimulation.modelIdentifier
    folder, guid = fmu.folder, fmu.description.guid
    return {"guid": guid, "modelIdentifier": identifier, "unzipDirectory": folder, "instanceName": "cradle"}


class States:
    """States as bytes, under the names that FMPy gives the functions of FMI 2.0."""

    def to_bytes(self: Any) -> bytes:
        """The state."""
        state = self.getFMUstate()
        data: bytes = self.serializeFMUstate(state)
        self.freeFMUstate(state)
        return data

    def go_to(self: Any, data: bytes) -> None:
        """Goes to the state in these bytes."""
        state = self.deSerializeFMUstate(data)
        self.setFMUstate(state)
        self.freeFMUstate(state)


class FMU2Instance(FMU2Slave, States):  # type: ignore[misc]  # FMPy goes by the first letters
    """An instance of FMI 2.0."""

    def __init__(self, fmu: Model, lines: list[log.LogLine]):
        given = arguments(fmu)
        # FMPy looks in linux64 on ARM, too; FMI 2.0.4 has aarch64-linux.
        name = given["modelIdentifier"] + sharedLibraryExtension
        library = Path(fmu.folder, "binaries", platform_tuple, name)
        super().__init__(**given, libraryPath=str(library) if library.is_file() else None)
        self._log = log.callbacks(lines)

    def create(self) -> None:
        """Instantiates it."""
        self.instantiate(callbacks=self._log)

    def log_events(self) -> None:
        """Has pulses, doubts and errors logged."""
        self.setDebugLogging(True, ["logEvents", "logStatusWarning"])

    def forget(self) -> None:
        """Takes no more log messages."""
        log.forget(self._log)

    def initialize(self, start_time: float) -> None:
        """Goes through initialization, at this start time (s)."""
        self.setupExperiment(startTime=start_time)
        self.enterInitializationMode()
        self.exitInitializationMode()

    def read(self, kind: str, references: list[int]) -> list[Any]:
        """Values of variables of one type."""
        values: list[Any] = getattr(self, f"get{kind.replace('Enumeration', 'Integer')}")(references)
        return values

    def write(self, kind: str, references: list[int], values: list[Any]) -> None:
        """Sets variables of one type."""
        getattr(self, f"set{kind.replace('Enumeration', 'Integer')}")(references, values)


class FMU3Instance(FMU3Slave, States):  # type: ignore[misc]
    """An instance of FMI 3.0: by the elements of its arrays, in steps without event mode."""

    getFMUstate, setFMUstate, freeFMUstate = (
        FMU3Slave.getFMUState,
        FMU3Slave.setFMUState,
        FMU3Slave.freeFMUState,
    )
    serializeFMUstate, deSerializeFMUstate = FMU3Slave.serializeFMUState, FMU3Slave.deserializeFMUState

    def __init__(self, fmu: Model, lines: list[log.LogLine]):
        super().__init__(**arguments(fmu))
        self._log = lines

    def create(self) -> None:
        """Instantiates it."""
        self.instantiate(loggingOn=True, logMessage=lambda _, *said: self._log.append(log.line(*said)))

    def log_events(self) -> None:
        """Has pulses, doubts and errors logged."""
        self.setDebugLogging(False, ["logSolver"])

    def forget(self) -> None:
        """Nothing to do: messages end with the instance."""

    def initialize(self, start_time: float) -> None:
        """Goes through initialization, at this start time (s)."""
        self.enterInitializationMode(startTime=start_time)
        self.exitInitializationMode()

    def read(self, kind: str, places: list[Place]) -> list[Any]:
        """Values of elements of one type."""
        arrays = {place.reference: place for place in places}
        values = {reference: self._array(place) for reference, place in arrays.items()}
        found = [values[place.reference][place.index] for place in places]
        return [min(value, LARGEST) for value in found] if kind == "Integer" else found

    def write(self, _kind: str, places: list[Place], values: list[Any]) -> None:
        """Sets elements of one type; the others of their arrays stay as they are."""
        arrays = {place.reference: place for place in places}
        whole = {reference: self._array(place) for reference, place in arrays.items()}
        for place, value in zip(places, values, strict=True):
            whole[place.reference][place.index] = value
        for reference, elements in whole.items():
            getattr(self, f"set{arrays[reference].type}")([reference], elements)

    def _array(self, place: Place) -> list[Any]:
        """All elements of the array that this one is of."""
        elements: list[Any] = getattr(self, f"get{place.type}")([place.reference], nValues=place.length)
        return elements
