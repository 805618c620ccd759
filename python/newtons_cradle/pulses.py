"""The pulse log: lines of the FMU's log category `logEvents`, as a table.

A contact pulse lasts about a microsecond, a communication step milliseconds. After a step with several
pulses, the variables show only the last one. The log has them all, one line per finished pulse.
"""

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .errors import UnknownName, needed, optional
from .markup import html_table

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[Any]

#: The columns of a table of pulses, each with its name in the log, its heading in print, and its format.
COLUMNS = {
    "contact": ("contact", "contact", "7d"),  # 1-based
    "onset": ("onset", "onset (s)", "18.15g"),
    "release": ("release", "release (s)", "18.15g"),
    "peak": ("peak", "peak (N)", "12.6g"),  # the largest force
    "impulse": ("impulse", "impulse (N.s)", "14.6g"),
    "peak_time": ("peakTime", "peak time (s)", "18.15g"),  # when the force was largest; NaN where that is unknown
}
FIELDS = tuple(COLUMNS)
NEEDED = FIELDS[:5]  # columns that a file must have; others are NaN if they are missing

#: One row per finished pulse.
PULSE = np.dtype([(name, "i4" if name == "contact" else "f8") for name in FIELDS])

SHOWN = 10  # rows of a table of pulses that are printed


class Pulses(np.ndarray):
    """A table of pulses: an array of dtype `PULSE`, printed with its units, the first rows only. Its columns, and what
    is computed of them, are plain arrays."""

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str) and key not in (self.dtype.names or ()):
            raise UnknownName(f"pulses have no {key!r}; allowed: {', '.join(self.dtype.names or ())}")
        found = super().__getitem__(key)
        return found.view(np.ndarray) if isinstance(found, Pulses) and found.dtype != PULSE else found

    def __array_wrap__(self, array: Array, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if return_scalar else array

    def __repr__(self) -> str:
        if self.dtype != PULSE or self.ndim != 1:
            return repr(np.asarray(self))
        headings, *rows = self._shown()
        widths = [int(layout.rstrip("dg").split(".")[0]) for _, _, layout in COLUMNS.values()]
        lines = [" ".join(map(str.rjust, row, widths)) for row in (headings, *rows)]
        more = [f"... {len(self)} pulses in all"] if len(self) > SHOWN else []
        return "\n".join([*lines, *more])

    __str__ = __repr__

    def _repr_html_(self) -> str:
        if self.dtype != PULSE or self.ndim != 1:
            return f"<pre>{np.asarray(self)!r}</pre>"
        more = f"{len(self)} pulses in all" if len(self) > SHOWN else ""
        return html_table(*self._shown(), below=more)

    def _shown(self) -> list[list[str]]:
        """The headings, then the first rows."""
        layouts = [layout for *_, layout in COLUMNS.values()]
        rows = [
            [f"{value:{layout}}".strip() for value, layout in zip(row, layouts, strict=True)] for row in self[:SHOWN]
        ]
        return [[heading for _, heading, _ in COLUMNS.values()], *rows]

    def to_dataframe(self) -> "pd.DataFrame":
        """As a pandas data frame, a row for each pulse, in SI units. Raises PackageMissing without pandas."""
        return optional("pandas", "data").DataFrame({name: self[name] for name in FIELDS})


def _in_line(column: str) -> str:
    """The pattern of this column in a line of the log, with the space before it."""
    value = rf" {COLUMNS[column][0]}=([^\s\x1e]+)"
    return value if column in NEEDED else f"(?:{value})?"


_LINE = re.compile("".join(map(_in_line, FIELDS)).strip())
_LINES = re.compile(_LINE.pattern.encode())


def parse_pulse(line: str) -> tuple[int | float, ...] | None:
    """One log line as a row of `PULSE`, or None when the line is not about a pulse."""
    match = _LINE.search(line)
    return (int(match[1]), *map(float, match.groups("nan")[1:])) if match else None


def pulse_table(text: bytes) -> Array:
    """The pulses that a log's text names as an array of dtype `PULSE`, shape (number of pulses,), by onset.

    Simultaneous pulses keep the order of the log, in which rigid impacts follow each other.
    """
    numbers = np.array(_LINES.findall(text), dtype="S25").reshape(-1, len(FIELDS))
    numbers[numbers == b""] = b"nan"
    table = np.empty(len(numbers), dtype=PULSE)
    for name, column in zip(FIELDS, numbers.astype("f8").T, strict=True):
        table[name] = column
    return by_onset(table.view(Pulses))


def by_onset(pulses: Array) -> Array:
    """The pulses in the order of their onsets; simultaneous ones keep their order. Raises InvalidValue."""
    needed("pulses", pulses, np.ndarray, "a table such as `result.pulses`")
    ordered: Array = pulses[np.argsort(pulses["onset"], kind="stable")]
    return ordered


def impact_sequences(pulses: Array, pause: float = 0.01) -> list[Array]:
    """Cuts a pulse table wherever no contact was closed for `pause` seconds.

    The cradle clicks twice per period, and a click is a sequence of pulses within microseconds.
    Each returned table is one click.
    """
    pulses = by_onset(pulses)
    if len(pulses) == 0:
        return []
    open_until = np.maximum.accumulate(pulses["release"])
    cuts = np.flatnonzero(pulses["onset"][1:] - open_until[:-1] > pause) + 1
    return np.split(pulses, cuts)


def pulse_order(sequence: Array) -> list[list[int]]:
    """The contacts of one impact sequence in the order they closed, simultaneous ones together.

    Pulses count as simultaneous when their onsets differ by less than a tenth of the shorter pulse.
    With a dead band two lifted balls of five give [[2], [1, 3], [2, 4], [3]]: the paper's Table 1.
    """
    order: list[list[int]] = []
    last = None
    for pulse in by_onset(sequence):
        length = pulse["release"] - pulse["onset"]
        if last is None or pulse["onset"] - last[0] >= 0.1 * min(length, last[1]):
            order.append([])
            last = pulse["onset"], length
        order[-1].append(int(pulse["contact"]))
    return [sorted(group) for group in order]


def overlapping_neighbours(sequence: Array) -> int:
    """How many pairs of pulses that share a ball overlap in time; 0 means "properly sequenced"."""
    contact, onset, release = (sequence[name] for name in FIELDS[:3])
    share_a_ball = np.subtract.outer(contact, contact) == 1
    overlap = np.less.outer(onset, release)
    return int(np.sum(share_a_ball & overlap & overlap.T))
