"""Judges a tool's result in a case: runs the FMU correctly and with each known mistake, and compares."""

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..building import build
from ..errors import CradleError, FmuError, InvalidValue, did_you_mean, needed
from ..files import FMU, in_folder, newest
from ..fmu import Fmu
from ..tables import as_number, by_name, digits, read_csv
from .cases import CASES, Case
from .master import Table, run

SAME_TIME = 1e-5  # s, within which rows belong to a communication point: times may have six digits
RESULT = "result.csv"  # in the folder of a case, if it is not named
SIX_DIGITS = 1e-5  # relative: the largest rounding of a result that is excused
MOST_NAMES = 20  # of columns that a message lists
CLEAR = 0.2  # of the distance from the right run: a mistake is named if the result is nearer to it than that


@dataclass(frozen=True)
class Distance:
    """How far a result is from a run. `worst`: largest difference, relative to the variable's largest value; `largest`:
    in words, where that is; `first`: where the limit is first exceeded, else `largest`; `missing`: times without a row,
    s."""

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


def judge(folder: str | Path, result: Any = None) -> list[str]:
    """Verdicts on a result in the case of this folder, which `write_cases` has written, one a line.

    `result`: a CSV file with columns named as tools name them, or columns by name: a dict, a NumPy structured array,
    a `Result`; if None, the file result.csv in the folder. Raises FileMissing, InvalidValue, and
    FmuError if the folder's FMU is not that of the case.
    """
    needed("folder", folder, str | Path, "the path of a case's folder")
    name = Path(folder).resolve().name
    if name not in CASES:
        allowed = f"; allowed: folders named {', '.join(CASES)}, or one that has them{did_you_mean(name, CASES)}"
        raise InvalidValue(f"{folder} is not the folder of a case{allowed}")
    case, given = CASES[name], own_columns(Path(folder, RESULT) if result is None else result)
    table = columns(given, case)
    with Fmu(Path(folder, "cradle.fmu")) as fmu:
        check_own(fmu, case)
        runs = {wrong: run(fmu, case, wrong) for wrong in (None, *case.other, *case.wrong)}
    return verdicts(case, table, runs, min(SIX_DIGITS, 5 * 10.0 ** -digits(given)))


def check_own(fmu: Fmu, case: Case) -> None:
    """Raises FmuError unless this FMU is the one of the case."""
    starts = fmu.settings(case.start) if fmu.is_cradle and fmu.balls == case.balls else {}
    own = fmu.balls == case.balls and fmu.fmi2 == (case.fmi == 2)
    if not own or any(fmu.built_with(name) != value for name, value in starts.items()):
        raise FmuError(f"{fmu.path} is another FMU than that of the case; write the cases anew")


def judge_all(folder: str | Path, results: str | Path | None = None) -> Iterator[tuple[str, list[str]]]:
    """The verdicts on each case in a folder of cases, by name. `results`: a folder with NAME.csv for each; if None,
    each is result.csv in the folder of its case."""
    for name in (name for name in CASES if Path(folder, name).is_dir()):
        try:
            yield name, judge(Path(folder, name), None if results is None else Path(results, f"{name}.csv"))
        except (CradleError, OSError) as problem:
            yield name, [f"not judged: {problem}"]


def columns(result: Any, case: Case) -> Table:
    """The columns of a result that the case asks for. Raises FileMissing, InvalidValue if time or all others are
    missing, or if time goes back."""
    own = own_columns(result)
    given = by_name(own)
    found = {name: given[name] for name in case.record if name in given}
    if "time" not in given or not found:
        needs = "no column time" if "time" not in given else f"none of the columns {', '.join(case.record)}"
        raise InvalidValue(f"the result has {needs}; its columns: {', '.join([*own][:MOST_NAMES]) or 'none'}")
    if not given["time"]:
        raise InvalidValue("the result has no rows of numbers")
    table: Table = {"time": list(map(as_number, given["time"]))}
    if None in table["time"]:
        raise InvalidValue(f"time = {given['time'][table['time'].index(None)]!r} is refused; allowed: a number (s)")
    for before, time in pairwise(table["time"]):
        if not time >= before:
            raise InvalidValue(f"the rows are out of order: after {before:.9g} s comes {time:.9g} s")
    for name, values in found.items():
        table[name] = [value if (read := as_number(value)) is None else read for value in values]
    return table


def own_columns(result: Any) -> dict[str, Any]:
    """The columns of a CSV file, of a dict, of a `Result`, or of a structured array."""
    if isinstance(result, str | Path):
        return dict(read_csv(Path(result)).columns)
    samples = getattr(result, "samples", result)
    names = list(result) if isinstance(result, Mapping) else getattr(getattr(samples, "dtype", None), "names", None)
    if not names:
        needed("result", result, Mapping, "the path of a CSV file, or a dict of columns by name,")
    return {name: list(samples[name]) for name in names or ()}


def verdicts(case: Case, table: Table, runs: Mapping[str | None, Table], rounding: float = 0.0) -> list[str]:
    """Verdicts on a table. `runs`: the judge's runs by mistake, None for the right one; `rounding`: relative, of the
    numbers in the table."""
    right, names = runs[None], [name for name in case.record if name in table]
    lines = [f"not judged: no column {name}" for name in case.record if name not in table]
    within = max(case.within, rounding)
    distances = {wrong: distance(table, run, scales(names, right, run), within, case) for wrong, run in runs.items()}
    own = distances[None]
    known = {**case.other, **case.wrong}
    near = min(known, key=lambda wrong: distances[wrong].worst)
    if distances[near].worst <= max(case.alike, within) and distances[near].worst < CLEAR * own.worst:
        if near in case.other:
            return [*lines, f"right, but {known[near]}; {own.largest}"]
        if own.worst > within:
            return [*lines, f"wrong: {known[near]}; {own.first}"]
    last, stop, count = table["time"][-1], right["time"][-1], len(right["time"])
    if last < stop - case.step / 2:
        return [f"wrong: the result ends at {last:.9g} s, where it is to end at {stop:.9g} s"]
    if own.missing:
        few = f"{len(own.missing)} of {count} points"
        lines.append(f"not judged: no rows at {few}, the first at {own.missing[0]:.9g} s")
    if len(own.missing) > count / 2 and own.worst <= within:
        return lines  # too few to call it right
    if own.worst == 0:
        lines.append(f"right to the last bit: {', '.join(names)}")
    elif own.worst <= within:
        lines.append(f"right within the method: {own.largest}")
    elif case.exchange and own.worst <= case.alike:
        allowed = f"allowed: {within:.0e}, with {case.solver()}"
        lines.append(f"wrong: less exact than the case asks for: {own.largest}; {allowed}")
    else:
        lines.append(f"wrong, and by no known mistake: {own.first}")
    return lines


def scales(names: list[str], *runs: Table) -> dict[str, float]:
    """The largest values of variables in these runs, 1 where all are 0."""
    sizes = {name: [abs(v) for run in runs for v in run[name] if not isinstance(v, str)] for name in names}
    return {name: max(values, default=0.0) or 1.0 for name, values in sizes.items()}


def distance(table: Table, other: Table, scales: Mapping[str, float], within: float, case: Case) -> Distance:
    """The distance from the table to a run; differences up to `within` do not count. Where an event gives several rows
    at a communication point, the nearest in value counts."""
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
            if error > within and not first:
                first = f"{name} differs first, at {time:.9g} s{contrast(table[name][row], other[name][k])}"
    end = times[-1]
    if abs(min(end, case.stop) - other["time"][-1]) > case.step / 2:
        worst, first = np.inf, first or f"it ends at {end:.9g} s"
    return Distance(float(worst), largest, first or largest, missing)


def off(value: Any, other: Any, scale: float) -> float:
    """The difference of two values, relative to a scale; 1 for different texts."""
    if isinstance(value, str) or isinstance(other, str) or value is None:
        return 0.0 if value == other else 1.0
    error = abs(float(value) - float(other)) / scale
    return error if np.isfinite(error) else np.inf


def contrast(value: Any, right: Any) -> str:
    """How a value differs from the right one, in words; "" for text."""
    value = f"{value:.9g}" if isinstance(value, float) else repr(value)
    return "" if isinstance(right, str) else f": {value} where {right:.9g} is right"
