"""Tables that other programs have written: one reader of CSV for `page` and `judge`, and columns by name."""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import InvalidValue
from .files import text

LONGEST = 16 << 20  # characters of a line: a row of 10,000 balls has a tenth of them
SEPARATORS = ",;\t"
TRUTH = {"true": 1.0, "false": 0.0}
COMMENT = re.compile(r"\s*[#%]+\s*")
WITH_COMMA = re.compile(r"[-+]?\d*,\d+([eEdD][-+]?\d+)?")  # a number


@dataclass(frozen=True)
class Table:
    """A CSV file. `columns`: cells by column name; `lines`: the line of each row in the file, from 1."""

    path: Path
    columns: dict[str, list[str]]
    lines: list[int]


def read_csv(path: Path) -> Table:
    """Reads a CSV file: a line of names, then rows with as many cells, separated by commas, semicolons or tabs;
    decimals may have a comma; lines that begin with # or % and a line of units are left out. Raises FileMissing,
    InvalidValue, OSError."""
    lines = text(path).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for index, line in enumerate(lines, start=1):
        if len(line) > LONGEST:
            raise InvalidValue(f"{path}, line {index}: {len(line)} characters; allowed: {LONGEST}")
    head, above = 0, ""
    while head < len(lines) and (COMMENT.match(lines[head]) or not lines[head].strip(" \t,;")):
        above = lines[head] if COMMENT.match(lines[head]) else above
        head += 1
    separator, named = None, re.fullmatch(r"(?i)sep=(.)", lines[head].strip()) if head < len(lines) else None
    if named:  # as Excel writes it
        separator, head = named[1], head + 1
    if head == len(lines):
        raise InvalidValue(f"{path}: the file is empty; needed: a line of names, and rows of numbers")
    separator = separator or max(SEPARATORS, key=re.sub(r'"[^"]*"', "", lines[head]).count)
    first = cells_of(path, lines[head : head + 1], separator, head)
    if above and all(as_number(cell) is not None for cell in first[0][1]):
        names = cells_of(path, [COMMENT.sub("", above, count=1)], separator, head)[0][1]  # as NumPy writes them
    else:
        names, head = first[0][1], head + 1
    while names and not names[-1].strip():
        names.pop()  # after a trailing separator
    rows = [row for row in cells_of(path, lines[head:], separator, head) if not COMMENT.match(lines[row[0] - 1])]
    while rows and not any(as_number(cell) is not None for cell in rows[0][1]):
        rows.pop(0)  # a row of units, or empty
    rows = [(line, cells) for line, cells in rows if any(map(str.strip, cells))]
    if not any("." in cell for _, cells in rows for cell in cells):
        rows = [(line, list(map(pointed, cells))) for line, cells in rows]
    for at, cells in rows:
        while len(cells) > len(names) and not cells[-1].strip():
            cells.pop()
        if len(cells) != len(names):
            raise InvalidValue(f"{path}, line {at}: {len(cells)} numbers for {len(names)} names")
    columns: dict[str, list[str]] = {}
    for name, *cells in zip(names, *(cells for _, cells in rows), strict=True):
        columns.setdefault(name, cells)
    return Table(path, columns, [at for at, _ in rows])


def cells_of(path: Path, lines: list[str], separator: str, before: int) -> list[tuple[int, list[str]]]:
    """The cells of these lines, each row with the number of its line in the file; `before`: the number of lines before
    them. Raises InvalidValue."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=True)
    usual, rows = csv.field_size_limit(LONGEST), []
    try:
        for cells in reader:
            rows.append((before + reader.line_num, cells))
    except csv.Error as problem:
        raise InvalidValue(f"{path}, line {before + reader.line_num}: {problem}") from None
    finally:
        csv.field_size_limit(usual)
    return rows


def pointed(cell: str) -> str:
    """The cell with decimal points in place of decimal commas."""
    parts = cell.split()
    return " ".join(parts).replace(",", ".") if parts and all(map(WITH_COMMA.fullmatch, parts)) else cell


def as_number(value: Any) -> float | None:
    """A number or a truth value as a float; None for text."""
    try:
        written = str(value).strip().lower() if isinstance(value, str | bool) else value
        return None if isinstance(written, str) and "_" in written else float(TRUTH.get(written, written))
    except (TypeError, ValueError, OverflowError):
        return None


def plain(name: str) -> str:
    """A column's name without quotes, and without the unit or note that tools append to it."""
    return re.sub(r"\s+(\[[^\]]*\]|\([^)]*\)|/.*)$", "", name.strip(" \"'"))


def by_name(given: Mapping[str, Sequence[Any]]) -> dict[str, list[Any]]:
    """Columns under each name that they may be asked for. `cradle.x[1]` is also `x[1]`, unless another column has that
    name; an array in one column, `x`, is also `x[1]`, `x[2]`, ..."""
    every: list[tuple[int, str, Sequence[Any]]] = []
    for name, values in given.items():
        own = "time" if plain(name).lower() in ("time", "t") else plain(name)
        ends = [0, *(match.end() for match in re.finditer(r"[.:/]", own))]
        every += [(cut, own[end:], values) for cut, end in enumerate(ends) if own[end:]]
    found: dict[str, list[Any]] = {}
    for _, name, values in sorted(every, key=lambda one: one[0]):
        if name not in found:
            found[name] = list(values)
            for index, element in enumerate(elements(values) if "[" not in name else (), start=1):
                found.setdefault(f"{name}[{index}]", element)
    return found


def elements(values: Sequence[Any]) -> list[list[Any]]:
    """The elements of an array in one column, whose cells have all of them; None where a row has fewer. Empty if the
    column is no array."""
    if len(values) and isinstance(values[0], str):
        rows = [re.sub(r"[\[\],]", " ", cell).split() for cell in values]
        rows = rows if len(rows[0]) > 1 else []
    else:
        rows = [list(cell) for cell in values if hasattr(cell, "__len__")]
    if any(as_number(cell) is None for cell in (rows[0] if rows else ())):
        return []
    longest = max(map(len, rows), default=0)
    return [[row[index] if index < len(row) else None for row in rows] for index in range(longest)]


def digits(columns: Mapping[str, Sequence[Any]]) -> int:
    """The largest number of digits that a number in these columns has; 17 if the columns are not text."""
    found = [0]
    for value in (value for values in columns.values() for value in values):
        if not isinstance(value, str):
            return 17
        if as_number(value) is not None and re.search(r"[.eE]", value):
            found.append(len(re.sub(r"[eEdD].*|[^\d]", "", value.strip()).lstrip("0")))
    return max(found)
