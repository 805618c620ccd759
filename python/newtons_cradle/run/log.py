"""The log of an instance. It is parsed on demand, and nothing twice.

Python runs signal handlers wherever its bytecode runs, also in a function that C calls back, where nobody can catch
what they raise. So the callback is made of builtins, which run no bytecode: `max` passes its arguments, all of them
bytes, one after the other to the `write` of a buffer.

Pulses come from here in FMI 3.0, too: a step may have more than the 499 that the variable `log.pulses` keeps.
"""

import io
import re
from collections.abc import Callable, Iterator, Sequence
from ctypes import CFUNCTYPE, c_char, c_char_p, c_void_p, cast, create_string_buffer
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..pulses import Array, Pulses, by_onset, pulse_table

NAME = "cradle"  # of all instances
BEGIN, END = b"\x1e", b"\x1f"  # begin of a line; end of a category that is not one of these
CATEGORIES = (b"logEvents", b"logSolver", b"logStatusWarning", b"logStatusDiscard", b"logStatusError")
RECORD = re.compile(rb"\x1e(?:cradle)?([\x00-\x05])", re.DOTALL)

NO_PULSES = pulse_table(b"")

# The status is an int below 256; declared as c_char, its lowest byte arrives as bytes.
LOGGER_2 = CFUNCTYPE(None, c_char_p, c_char_p, c_char, c_char_p, c_char_p)
LOGGER_3 = CFUNCTYPE(None, c_char_p, c_char, c_char_p, c_char_p)


@dataclass(frozen=True)
class LogLine:
    """One message of an FMU: FMI status (0 OK, 1 warning, 3 error, 4 fatal), category and text."""

    status: int
    category: str
    text: str


class Sink:
    """The buffer for an instance's messages. `environment`: what the instance hands back to `callback`."""

    def __init__(self, fmi2: bool):
        self.buffer, self.fmi2 = io.BytesIO(), fmi2
        self.environment = create_string_buffer(BEGIN)
        write: Callable[..., Any] = partial(max, key=self.buffer.write)
        self.callback: Any = (LOGGER_2 if fmi2 else LOGGER_3)(write)

    def address(self) -> int | None:
        """The address of the environment, for C."""
        return cast(self.environment, c_void_p).value

    def take(self, status: int, category: bytes | None, text: bytes | None) -> None:
        """Takes a message that another callback has received."""
        self.buffer.write(BEGIN + bytes([status]) + (category or b"") + END + (text or b""))


class Log(Sequence[LogLine]):
    """The messages of one run, so far."""

    def __init__(self, sink: Sink):
        self._buffer, self._fmi2 = sink.buffer, sink.fmi2
        self._told = 0  # the length that `news` has returned
        self._forget()

    def _forget(self) -> None:
        # What was parsed, and up to where: in one tuple, so that a signal cannot come between them.
        self._lines: tuple[list[LogLine], int] = [], 0
        self._pulses: tuple[Array, int] = NO_PULSES, 0

    def text(self) -> bytes:
        """The whole text."""
        return self._buffer.getvalue()

    def mark(self) -> int:
        """The length of the text, bytes."""
        return self._buffer.tell()

    def cut(self, mark: int) -> None:
        """Forgets what was written after `mark`."""
        self._buffer.truncate(mark)
        self._buffer.seek(mark)
        self._told = min(self._told, mark)
        if max(self._lines[1], self._pulses[1]) > mark:
            self._forget()

    def clear(self) -> None:
        """Forgets everything."""
        self.cut(0)

    def release(self) -> None:
        """Copies the text, and empties the sink for the next run."""
        kept = io.BytesIO()
        kept.write(self.text())
        used, self._buffer = self._buffer, kept
        used.seek(0)
        used.truncate()

    def since(self, mark: int) -> list[LogLine]:
        """The lines that were written after `mark`."""
        return list(self._parsed(self.text()[mark:]))

    def news(self) -> list[LogLine]:
        """The lines that were written since the last call."""
        lines = self.since(self._told)
        self._told = self.mark()
        return lines

    def pulses(self) -> Array:
        """The finished pulses, by onset."""
        table, read = self._pulses
        if self.mark() > read:
            text = self.text()
            table = by_onset(np.concatenate([table, pulse_table(text[read:])]).view(Pulses))
            self._pulses = table, len(text)
        return table.copy()

    def _parsed(self, text: bytes) -> Iterator[LogLine]:
        _, *parts = RECORD.split(text)
        for status, said in zip(parts[::2], parts[1::2], strict=True):
            category, ended, message = said.partition(END)
            if not ended:
                category = next((known for known in CATEGORIES if said.startswith(known)), b"")
                message = said[len(category) :].replace(b"%%", b"%") if self._fmi2 else said[len(category) :]
            yield LogLine(status[0], *(each.decode("utf-8", "replace") for each in (category, message)))

    def _all(self) -> list[LogLine]:
        lines, read = self._lines
        if self.mark() > read:
            text = self.text()
            lines = [*lines, *self._parsed(text[read:])]
            self._lines = lines, len(text)
        return lines

    def __len__(self) -> int:
        return len(self._all())

    def __getitem__(self, index: Any) -> Any:
        return self._all()[index]

    def __eq__(self, other: object) -> bool:
        return list(self) == other if isinstance(other, list | Log) else NotImplemented

    def __repr__(self) -> str:
        return repr(self._all())
