"""An instance of FMI 2.0, as runs use it."""

from pathlib import Path
from typing import Any

from fmpy import platform_tuple, sharedLibraryExtension
from fmpy.fmi2 import FMU2Slave

from .log import LogLine, router
from .model import Model


class FMU2Instance(FMU2Slave):  # type: ignore[misc]  # FMPy goes by the first letters
    """FMPy's slave, whose log messages are appended to `log`."""

    def __init__(self, fmu: Model, log: list[LogLine]):
        identifier = fmu.description.coSimulation.modelIdentifier
        # FMPy looks in linux64 on ARM, too; FMI 2.0.4 has aarch64-linux.
        library = Path(fmu.folder, "binaries", platform_tuple, identifier + sharedLibraryExtension)
        super().__init__(
            guid=fmu.description.guid,
            modelIdentifier=identifier,
            unzipDirectory=fmu.folder,
            instanceName="cradle",
            libraryPath=str(library) if library.is_file() else None,
        )
        self._callbacks = router.callbacks(log)

    def create(self) -> None:
        """Instantiates it."""
        self.instantiate(callbacks=self._callbacks)

    def log_events(self) -> None:
        """Has the pulses logged."""
        self.setDebugLogging(True, ["logEvents"])

    def initialize(self, start_time: float) -> None:
        """Goes through initialization, at this start time (s)."""
        self.setupExperiment(startTime=start_time)
        self.enterInitializationMode()
        self.exitInitializationMode()

    def read(self, kind: str, references: list[int]) -> list[Any]:
        """Values of variables of one type."""
        values: list[Any] = getattr(self, f"get{_stored(kind)}")(references)
        return values

    def write(self, kind: str, references: list[int], values: list[Any]) -> None:
        """Sets variables of one type."""
        getattr(self, f"set{_stored(kind)}")(references, values)

    def to_bytes(self) -> bytes:
        """The state."""
        state = self.getFMUstate()
        data: bytes = self.serializeFMUstate(state)
        self.freeFMUstate(state)
        return data

    def go_to(self, data: bytes) -> None:
        """Goes to the state in these bytes."""
        state = self.deSerializeFMUstate(data)
        self.setFMUstate(state)
        self.freeFMUstate(state)

    def forget(self) -> None:
        """Takes no more log messages."""
        router.forget(self._callbacks)


def _stored(kind: str) -> str:
    return "Integer" if kind == "Enumeration" else kind
