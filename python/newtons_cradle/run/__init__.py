"""A run of an FMU through FMPy: its description, its log, its steps, and its results."""

from .instance import NEVER, Recorder, Run, Saved
from .model import Model
from .result import Result
from .slaves import LogLine

__all__ = ["NEVER", "LogLine", "Model", "Recorder", "Result", "Run", "Saved"]
