"""The log of an instance: what the FMU says through FMI's logger."""

from ctypes import byref
from dataclasses import dataclass
from weakref import WeakValueDictionary

from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy


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


def callbacks(log: Log) -> fmi2CallbackFunctions:
    """Callbacks of a new instance of FMI 2.0, whose messages `log` takes."""
    functions = fmi2CallbackFunctions()
    functions.logger = _logger
    addLoggerProxy(byref(functions))
    functions.componentEnvironment = id(log)
    _logs[id(log)] = log
    return functions
