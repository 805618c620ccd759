"""A run of an FMU through FMPy: its description, its log, its steps, and its results."""

from .instance import NEVER, Recorder, Run, Saved
from .log import LogLine
from .model import FmuError, Model
from .names import UnknownName
from .result import Result

__all__ = ["NEVER", "FmuError", "LogLine", "Model", "Recorder", "Result", "Run", "Saved", "UnknownName"]
