"""The log of an instance: what the FMU says through FMI's logger."""

import itertools
import threading
from ctypes import byref
from dataclasses import dataclass

from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy


@dataclass(frozen=True)
class LogLine:
    """One message of an FMU: FMI status (0 OK, 1 warning, 3 error, 4 fatal), category and text."""

    status: int
    category: str
    text: str


class LogRouter:
    """Hands each log message to the run it belongs to.

    FMPy's proxy, which formats the C-style message, keeps one logger for the whole process: the last
    one registered gets the messages of every instance. So all runs share this one. The componentEnvironment that
    the FMU hands back tells them apart. (A `simulate_fmu(..., logger=...)` started
    while a run is open takes over the proxy: the run's later messages go to that logger.)
    """

    def __init__(self) -> None:
        self._logs: dict[int, list[LogLine]] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._logger = fmi2CallbackLoggerTYPE(self._receive)

    def _receive(
        self, environment: int, _instance: bytes, status: int, category: bytes | None, message: bytes | None
    ) -> None:
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
        """Stops taking messages of this instance."""
        self._logs.pop(callbacks.componentEnvironment, None)


router = LogRouter()
