"""Judges the result of a tool in a case: by the run itself, made rightly and with each known mistake."""

import csv
import re
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..building import build
from ..errors import InvalidValue, did_you_mean, needed
from ..files import FMU, in_folder, newest, text
from ..fmu import Fmu
from .cases import CASES, Case
from .master import Table, run

SAME_TIME = 1e-5  # s, within which rows belong to a communication point: times may have six digits
CLEAR = 0.2  # of the distance from the right result: at most that of a mistake which is named


@dataclass(frozen=True)
class Distance:
    """How far a result is from a run. `worst`: largest difference, relative to the variable's largest value; `largest`:
    in words, where that is; `first`: where the limit is first exceeded, if it is; `missing`: times without a row, s."""

    worst: float
    largest: str
    first: str
    missing: list[float]


def write_cases(folder: str | Path, binaries: str | Path | None = None) -> list[Path]:
    """Writes each case into a folder of its own: its FMU, what to do (case.txt), inputs.csv if it has inputs, and the
    right result (expected.csv). `binaries`: the FMU whose binaries they get, if not the package's. Returns the folders.
    Raises FmuError, FileMissing."""
    needed("folder", folder, str | Path, "the path of a folder")
    folders: list[Path] = []
    binaries = binaries or newest(FMU)
    for name, case in CASES.items():
        place = Path(folder, name)
        place.mkdir(parents=True, exist_ok=True)
        with build(balls=case.balls, set=case.start, fmi=case.fmi, out=place / "cradle.fmu", binaries=binaries) as fmu:
            write_csv(place / "expected.csv", run(fmu, case))
        for input, points in case.inputs.items():
            columns = {"time": [time for time, _ in points], input: [value for _, value in points]}
            write_csv(place / "inputs.csv", columns)
        lines = [f"{name}: {case.title}", "", case.instructions(), "", case.meaning, "", "Known mistakes:"]
        lines += [f"- {words}" for words in case.wrong.values()]
        in_folder(place / "case.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        folders.append(place)
    return folders


def write_csv(path: Path, table: Mapping[str, list[Any]]) -> None:
    """Writes a table, whose numbers read back as the same doubles."""
    with in_folder(path).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))


def judge(folder: str | Path, result: Any) -> list[str]:
    """Verdicts on a result in the case of this folder, which `write_cases` has written, one a line.

    `result`: a CSV file with columns named as tools name them, or columns by name: a dict, a NumPy structured array,
    a `Result`. Raises FileMissing, InvalidValue.
    """
    needed("folder", folder, str | Path, "the path of a case's folder")
    name = Path(folder).resolve().name
    if name not in CASES:
        allowed = f"; allowed: folders named {', '.join(CASES)}{did_you_mean(name, CASES)}"
        raise InvalidValue(f"{folder} is not the folder of a case{allowed}")
    case = CASES[name]
    table = columns(result, case)
    with Fmu(Path(folder, "cradle.fmu")) as fmu:
        runs = {wrong: run(fmu, case, wrong) for wrong in (None, *case.other, *case.wrong)}
    return verdicts(case, table, runs)


def columns(result: Any, case: Case) -> Table:
    """The columns of a result that the case asks for. Raises FileMissing, InvalidValue if time or all others are
    missing, or if time goes back."""
    given = from_csv(Path(result)) if isinstance(result, str | Path) else by_name(result)
    times = [name for name in given if plain(name).lower() in ("time", "t")]
    found = {name: values for name in case.record if (values := column(given, name)) is not None}
    if not times or not found:
        needs = "no column time" if not times else f"none of the columns {', '.join(case.record)}"
        raise InvalidValue(f"the result has {needs}; its columns: {', '.join(given) or 'none'}")
    table: Table = {"time": [float(time) for time in given[times[0]]], **found}
    for before, time in pairwise(table["time"]):
        if not time >= before:
            raise InvalidValue(f"the rows are out of order: after {before:.9g} s comes {time:.9g} s")
    return table


def by_name(result: Any) -> dict[str, list[Any]]:
    """The columns of a dict, of a `Result`, or of a structured array."""
    samples = getattr(result, "samples", result)
    names = list(result) if isinstance(result, Mapping) else getattr(getattr(samples, "dtype", None), "names", None)
    if not names:
        needed("result", result, Mapping, "the path of a CSV file, or a dict of columns by name,")
    return {name: list(samples[name]) for name in names or ()}


def from_csv(path: Path) -> dict[str, list[Any]]:
    """The columns of a CSV file: separated by commas, semicolons or tabs; a line of units is left out. Raises
    FileMissing, InvalidValue."""
    lines = [line for line in text(path).splitlines() if line.strip()]
    separator = max(",;\t", key=(lines or [""])[0].count)
    header, *rows = list(csv.reader(lines, delimiter=separator, skipinitialspace=True)) or [[]]
    point = separator != "," and not any("." in line for line in lines[1:])  # decimals may have a comma
    rows = [[cell.replace(",", ".") for cell in row] if point else row for row in rows]
    rows = [row for row in rows if row and len(row) >= len(header) and number(row[0]) is not None]
    if not rows:
        raise InvalidValue(f"{path}: a header and rows of numbers are needed, separated by commas, semicolons or tabs")
    return {name: list(values) for name, values in zip(header, zip(*rows, strict=False), strict=False)}


def plain(name: str) -> str:
    """A column's name without quotes, and without what tools put behind it: a unit, or what they know of it."""
    return re.sub(r"\s+(\[[^\]]*\]|\([^)]*\)|/.*)$", "", name.strip(" \"'"))


def column(given: Mapping[str, list[Any]], name: str) -> list[Any] | None:
    """The values of a variable, behind any name of its component; of an array in one column, those of its element."""
    array, _, index = name.removesuffix("]").partition("[")
    for wanted in (name, array) if index.isdigit() else (name,):
        for own, values in given.items():
            if re.search(rf"(^|[.:/]){re.escape(wanted)}$", plain(own)):
                if wanted != name:
                    cells = [cell.split() if isinstance(cell, str) else list(cell) for cell in values]
                    values = [cell[int(index) - 1] if len(cell) >= int(index) else None for cell in cells]
                return [value if (read := number(value)) is None else read for value in values]
    return None


def number(value: Any) -> float | None:
    """A number or a truth value as a float; None for text."""
    try:
        return float({"true": 1.0, "false": 0.0}.get(str(value).strip().lower(), value))
    except (TypeError, ValueError):
        return None


def verdicts(case: Case, table: Table, runs: Mapping[str | None, Table]) -> list[str]:
    """What these runs, by their mistakes, say about the table."""
    right, names = runs[None], [name for name in case.record if name in table]
    lines = [f"not judged: no column {name}" for name in case.record if name not in table]
    distances = {wrong: distance(table, run, scales(names, right, run), case) for wrong, run in runs.items()}
    own = distances[None]
    known = {**case.other, **case.wrong}
    near = min(known, key=lambda wrong: distances[wrong].worst)
    if distances[near].worst <= case.within and distances[near].worst < CLEAR * own.worst:
        if near in case.other:
            return [*lines, f"right, but {known[near]}; {own.largest}"]
        if own.worst > case.within:
            return [*lines, f"wrong: {known[near]}; {own.first}"]
    last, stop, count = table["time"][-1], right["time"][-1], len(right["time"])
    if last < stop - case.step / 2:
        lines.append(f"wrong: the result ends at {last:.9g} s, where it is to end at {stop:.9g} s")
        count = bisect_right(right["time"], last + SAME_TIME)
        part = {name: values[:count] for name, values in right.items()}
        own = distance(table, part, scales(names, right), case)
    if own.missing:
        few = f"{len(own.missing)} of {count} points"
        lines.append(f"not judged: no rows at {few}, the first at {own.missing[0]:.9g} s")
    if len(own.missing) > count / 2 and own.worst <= case.within:
        return lines  # too few to call it right
    if own.worst == 0:
        lines.append(f"right to the last bit: {', '.join(names)}")
    elif own.worst <= case.within:
        lines.append(f"right within the method: {own.largest}")
    else:
        hint = "; if finer steps change that, it is the solver's error" if case.exchange else ""
        lines.append(f"wrong, and by no known mistake: {own.first}{hint}")
    return lines


def scales(names: list[str], *runs: Table) -> dict[str, float]:
    """The largest values of variables in these runs, 1 where all are 0."""
    sizes = {name: [abs(v) for run in runs for v in run[name] if not isinstance(v, str)] for name in names}
    return {name: max(values, default=0.0) or 1.0 for name, values in sizes.items()}


def distance(table: Table, other: Table, scales: Mapping[str, float], case: Case) -> Distance:
    """From the table to a run. At a communication point the row counts that is nearest: an event may give several."""
    worst, largest, first, times = 0.0, "", "", np.array(table["time"])
    missing: list[float] = []
    for k, time in enumerate(other["time"]):
        rows = np.flatnonzero(np.abs(times - time) <= SAME_TIME)
        if not len(rows):
            missing.append(time)
            continue
        found = [{name: off(table[name][row], other[name][k], scale) for name, scale in scales.items()} for row in rows]
        errors, row = min(zip(found, rows, strict=True), key=lambda one: max(one[0].values()))
        for name, error in errors.items():
            if error > worst:
                worst = error
                largest = f"{name} differs by up to {error:.1e} of its largest value, at {time:.9g} s"
            if error > case.within and not first:
                first = f"{name} differs first, at {time:.9g} s{contrast(table[name][row], other[name][k])}"
    end = times[-1]
    if abs(min(end, case.stop) - other["time"][-1]) > case.step / 2:
        worst, first = np.inf, first or f"it ends at {end:.9g} s"
    return Distance(float(worst), largest, first or largest, missing)


def off(value: Any, other: Any, scale: float) -> float:
    """The difference of two values, relative to a scale; that of different texts is 1."""
    if isinstance(value, str) or isinstance(other, str) or value is None:
        return 0.0 if value == other else 1.0
    error = abs(float(value) - float(other)) / scale
    return error if np.isfinite(error) else np.inf


def contrast(value: Any, right: Any) -> str:
    """In words, how a value differs from the right one, unless that is text."""
    value = f"{value:.9g}" if isinstance(value, float) else repr(value)
    return "" if isinstance(right, str) else f": {value} where {right:.9g} is right"
