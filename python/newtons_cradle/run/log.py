"""The log of an instance: what the FMU says through FMI's logger."""

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


def line(status: int, *texts: bytes | None) -> LogLine:
    """A message as C passes it: status, category, text."""
    return LogLine(status, *((text or b"").decode("utf-8", "replace") for text in texts))


# FMPy's proxy formats C-style messages, but keeps one logger for the process: the last one registered gets the messages
# of every instance. So all runs of FMI 2.0 share `_logger`, and the componentEnvironment, which the FMU hands back,
# tells them apart. (A `simulate_fmu(..., logger=...)` that starts during a run takes over its later messages.)
_logs: dict[int, list[LogLine]] = {}


@fmi2CallbackLoggerTYPE  # type: ignore[untyped-decorator]
def _logger(environment: int, _instance: bytes, status: int, *texts: bytes | None) -> None:
    if environment in _logs:
        _logs[environment].append(line(status, *texts))


def callbacks(log: list[LogLine]) -> fmi2CallbackFunctions:
    """Callbacks of a new instance of FMI 2.0, whose messages are appended to `log`."""
    functions = fmi2CallbackFunctions()
    functions.logger = _logger
    addLoggerProxy(byref(functions))
    functions.componentEnvironment = id(log)
    _logs[id(log)] = log
    return functions


def forget(functions: fmi2CallbackFunctions) -> None:
    """Takes no more messages of the instance with these callbacks."""
    _logs.pop(functions.componentEnvironment, None)
