"""A run of an FMU through FMPy: its description, its log, its steps, and its results."""

from .instance import NEVER, Run, Saved
from .log import LogLine
from .model import Model
from .recorder import Recorder
from .result import Result

__all__ = ["NEVER", "LogLine", "Model", "Recorder", "Result", "Run", "Saved"]
