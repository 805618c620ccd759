"""The log of an instance. Nothing in it is parsed before somebody asks, and nothing twice.

Python runs handlers of signals, and raises what other threads send, wherever its bytecode runs: in a function that C
calls back, too, where nobody can catch it. So the callback is made of builtins, in which no bytecode runs: `max` passes
one argument after the other to the `write` of a buffer, and each of them is bytes.

Pulses come from here in FMI 3.0, too: `log.pulses` keeps the last 499 of them only, and a step may have more.
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
BEGIN, END = b"\x1e", b"\x1f"  # of a line, and of a category that is not one of these
CATEGORIES = (b"logEvents", b"logSolver", b"logStatusWarning", b"logStatusDiscard", b"logStatusError")
RECORD = re.compile(rb"\x1e(?:cradle)?([\x00-\x05])", re.DOTALL)

NO_PULSES = pulse_table(b"")

# The status is below 256, and C passes it as a number, so that its first byte is all of it.
LOGGER_2 = CFUNCTYPE(None, c_char_p, c_char_p, c_char, c_char_p, c_char_p)
LOGGER_3 = CFUNCTYPE(None, c_char_p, c_char, c_char_p, c_char_p)


@dataclass(frozen=True)
class LogLine:
    """One message of an FMU: FMI status (0 OK, 1 warning, 3 error, 4 fatal), category and text."""

    status: int
    category: str
    text: str


class Sink:
    """Where an instance writes its messages. `environment`: what it hands back to `callback`."""

    def __init__(self, fmi2: bool):
        self.buffer, self.fmi2 = io.BytesIO(), fmi2
        self.environment = create_string_buffer(BEGIN)
        write: Callable[..., Any] = partial(max, key=self.buffer.write)
        self.callback: Any = (LOGGER_2 if fmi2 else LOGGER_3)(write)

    def address(self) -> int | None:
        """The environment's, for C."""
        return cast(self.environment, c_void_p).value

    def take(self, status: int, category: bytes | None, text: bytes | None) -> None:
        """A message as C passes it to a callback that is not this one."""
        self.buffer.write(BEGIN + bytes([status]) + (category or b"") + END + (text or b""))


class Log(Sequence[LogLine]):
    """The messages of one run, so far."""

    def __init__(self, sink: Sink):
        self._buffer, self._fmi2 = sink.buffer, sink.fmi2
        self._told = 0  # up to where errors have said it
        self._forget()

    def _forget(self) -> None:
        # What was parsed, up to where: in one assignment, so that a signal cannot part them.
        self._lines: tuple[list[LogLine], int] = [], 0
        self._pulses: tuple[Array, int] = NO_PULSES, 0

    def text(self) -> bytes:
        """All that was written."""
        return self._buffer.getvalue()

    def mark(self) -> int:
        """The place to which it has been written."""
        return self._buffer.tell()

    def cut(self, mark: int) -> None:
        """Forgets what was written since."""
        self._buffer.truncate(mark)
        self._buffer.seek(mark)
        self._told = min(self._told, mark)
        if max(self._lines[1], self._pulses[1]) > mark:
            self._forget()

    def clear(self) -> None:
        """Forgets all."""
        self.cut(0)

    def release(self) -> None:
        """Keeps what there is, and leaves the sink to others."""
        kept = io.BytesIO()
        kept.write(self.text())
        used, self._buffer = self._buffer, kept
        used.seek(0)
        used.truncate()

    def since(self, mark: int) -> list[LogLine]:
        """The lines that were written since."""
        return list(self._parsed(self.text()[mark:]))

    def news(self) -> list[LogLine]:
        """The lines that were written since this was asked last."""
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
