"""An instance of FMI 3.0, as runs use it: by the elements of its arrays, in steps without event mode."""

from typing import Any

from fmpy.fmi3 import FMU3Slave

from .elements import Place
from .log import LogLine
from .model import Model

LARGEST = 2**31 - 1  # that counters show, as in FMI 2.0


class FMU3Instance(FMU3Slave):  # type: ignore[misc]
    """FMPy's slave, whose log messages are appended to `log`."""

    def __init__(self, fmu: Model, log: list[LogLine]):
        super().__init__(
            guid=fmu.description.guid,
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            unzipDirectory=fmu.folder,
            instanceName="cradle",
        )
        self._log: list[LogLine] | None = log

    def create(self) -> None:
        """Instantiates it."""
        self.instantiate(loggingOn=True, logMessage=self._receive)

    def _receive(self, _environment: Any, status: int, category: bytes | None, message: bytes | None) -> None:
        if self._log is not None:
            texts = ((text or b"").decode("utf-8", "replace") for text in (category, message))
            self._log.append(LogLine(status, *texts))

    def log_events(self) -> None:
        """Has only pulses and errors logged."""
        self.setDebugLogging(False, ["logSolver"])

    def initialize(self, start_time: float) -> None:
        """Goes through initialization, at this start time (s)."""
        self.enterInitializationMode(startTime=start_time)
        self.exitInitializationMode()

    def read(self, kind: str, places: list[Place]) -> list[Any]:
        """Values of elements of one type."""
        arrays: dict[int, list[Any]] = {}
        for place in places:
            if place.reference not in arrays:
                arrays[place.reference] = self._array(place)
        values = [arrays[place.reference][place.index] for place in places]
        return [min(value, LARGEST) for value in values] if kind == "Integer" else values

    def write(self, _kind: str, places: list[Place], values: list[Any]) -> None:
        """Sets elements of one type; the others of their arrays stay as they are."""
        arrays: dict[Place, list[Any]] = {}
        for place, value in zip(places, values, strict=True):
            first = Place(place.type, place.reference, 0, place.length)
            if first not in arrays:
                arrays[first] = self._array(first) if place.length > 1 else [value]
            arrays[first][place.index] = value
        for array, elements in arrays.items():
            getattr(self, f"set{array.type}")([array.reference], elements)

    def _array(self, place: Place) -> list[Any]:
        """All elements of the array that this one is of."""
        elements: list[Any] = getattr(self, f"get{place.type}")([place.reference], nValues=place.length)
        return elements

    def to_bytes(self) -> bytes:
        """The state."""
        state = self.getFMUState()
        data: bytes = self.serializeFMUState(state)
        self.freeFMUState(state)
        return data

    def go_to(self, data: bytes) -> None:
        """Goes to the state in these bytes."""
        state = self.deserializeFMUState(data)
        self.setFMUState(state)
        self.freeFMUState(state)

    def forget(self) -> None:
        """Takes no more log messages."""
        self._log = None
