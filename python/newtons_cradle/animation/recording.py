"""What an animation shows: motion, forces, energies and pulses of a run, from an FMU or from a CSV file."""

import csv
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..fmu import Fmu
from ..pulses import FIELDS, PULSE, Array
from ..run import Run
from ..run.model import Values
from ..views import sample_times

#: As many numbers as an animation may hold, so that its page stays below 5 MB.
LARGEST = 1_200_000

#: How FMPy writes Booleans.
TRUTH = {"True": "1", "False": "0"}

#: How far a ball may be, between two samples, from where their velocities take it: this part of the largest excursion.
COARSE = 0.05

#: A velocity that changes by this part of the largest from one sample to the next has been struck.
STRUCK = 0.3


Columns = dict[str, Array]  # by name


class RecordingError(ValueError):
    """A result that cannot be shown; the message says what is needed."""


@dataclass(frozen=True)
class Recording:
    """A run, ready to be drawn. SI units; arrays of shape (samples,) or (samples, balls or contacts).

    `energy`: by name, what is known of kinetic, gravity, contact and total energy. `parameters`: rows of name, value,
    unit and meaning, as far as known. `length` and `radius`: of pendulum 1 and of a ball, for the drawing.
    """

    title: str
    time: Array
    x: Array
    v: Array
    F: Array
    pulses: Array
    energy: Columns = field(default_factory=dict)
    parameters: list[tuple[str, str, str, str]] = field(default_factory=list)
    length: float = 1.962
    radius: float = 0.0313


def from_fmu(
    path: str | Path | None,
    values: Values | None = None,
    *,
    stop: float = 10.0,
    step: float = 0.02,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Runs an FMU with these start values for `stop` (s); samples every `step` (s) and within every pulse.

    The run is made twice, as in `views.resolved`. Raises FileNotFoundError, FmuError or KeyError.
    """
    with Fmu(path) as fmu:
        pulses = fmu.simulate(values, times=[0.0, stop], record=[]).pulses
        n = fmu.balls
        names = [f"{name}[{i}]" for name in ("x", "v", "E_kinetic", "E_gravity") for i in range(1, n + 1)]
        names += [f"{name}[{i}]" for name in ("F", "E_contact") for i in range(1, n)]
        steps = max(1, round(stop / step))
        # As many samples in each pulse as fit; where not even four do, the later pulses go without.
        room = max(4, LARGEST // (3 * n + 3) - steps)
        per_pulse = int(np.clip(room // max(1, len(pulses)), 4, 48))
        times = sample_times(pulses[: room // per_pulse], stop, step, per_pulse)
        result = fmu.simulate(values, times=times, record=names, progress=progress)
        with fmu.start(values) as run:
            length, radius = run.get("pendulum.length"), run.get("ball.radius")
            parameters = _parameters(fmu, run)
    columns = {name: result[name] for name in ("time", *names)}
    title = f"{n} ball{'s' if n > 1 else ''}, {stop:g} s"
    return of_columns(title, columns, n, pulses, parameters, length, radius)


def from_csv(
    path: str | Path,
    pulses: str | Path | None = None,
    *,
    balls: int | None = None,
    length: float = 1.962,
    radius: float = 0.0313,
) -> Recording:
    """Reads a result in the layout that FMPy writes: time, x[i], v[i] of all balls, F[i] of all contacts; energies if
    there.

    `pulses`: CSV file of the pulse table. Without it, pulses are taken from F_peak, else from F. `balls`: how many
    there are, None for as many as the file names. `length` and `radius` (m): for the drawing. Raises RecordingError,
    OSError.
    """
    path = Path(path)
    columns = _read_columns(path)
    n = _number_of_balls(path, columns, balls)
    run = of_columns(path.stem, columns, n, np.zeros(0, PULSE), [], length, radius)
    if len(run.time) < 2 or np.any(np.diff(run.time) <= 0):
        raise RecordingError(f"{path}: at least two rows are needed, with times that rise")
    _refuse_coarse(path, run)
    if pulses is not None:
        table = _pulse_table(Path(pulses), n)
    elif all(f"F_peak[{i}]" in columns for i in range(1, n)):
        table = _guessed_pulses(run.time, vector(columns, "F_peak", n - 1))
    else:
        _refuse_missed_clicks(path, run)
        table = _guessed_pulses(run.time, run.F)
    return replace(run, pulses=table)


def _number_of_balls(path: Path, columns: Columns, wanted: int | None) -> int:
    """The number of balls in the file, once all their columns are there."""

    def highest(names: str) -> int:
        found = (re.fullmatch(rf"(?:{names})\[(\d+)\]", name) for name in columns)
        return max((int(match[1]) for match in found if match), default=0)

    contacts = highest("F|F_peak|F_mean|impulse|E_contact|gap")
    n = wanted or max(highest(r"\w+"), contacts + 1 if contacts else 0)
    counts = {"x": max(n, 1), "v": max(n, 1), "F": n - 1}
    needed = ["time", *(f"{name}[{i}]" for name, count in counts.items() for i in range(1, count + 1))]
    missing = [name for name in needed if name not in columns]
    if missing:
        shown = ", ".join(missing[:6]) + (", ..." if len(missing) > 6 else "")
        whose = f" of {n} balls" if n > 1 else ""
        raise RecordingError(
            f"{path}: not a whole result{whose}; missing: {shown}. Needed: time, x[i] and v[i] of every ball and "
            "F[i] of every contact; F_peak[i] as well, unless the samples resolve every pulse"
        )
    if n == 1 and wanted is None:
        raise RecordingError(
            f"{path}: the file has only one ball. If the cradle has one, say `--balls 1`; else record x[i] and v[i] "
            "of every ball and F[i] and F_peak[i] of every contact"
        )
    return n


def _refuse_coarse(path: Path, run: Recording) -> None:
    """Raises RecordingError where the motion between samples cannot be told from them."""
    time, x, v = run.time, run.x, run.v
    step, extent = np.diff(time)[:, None], np.ptp(x)
    away = np.abs(np.diff(x, axis=0) - 0.5 * step * (v[1:] + v[:-1]))
    worst = np.unravel_index(np.argmax(away), away.shape)
    if extent > 0 and away[worst] > COARSE * extent:
        h = step[worst[0], 0]
        finer = float(f"{0.9 * h * COARSE * extent / away[worst]:.1g}")
        raise RecordingError(
            f"{path}: too coarse. The samples at t = {time[worst[0]]:g} s are {h:g} s apart, and ball {worst[1] + 1} "
            f"cannot be followed between them. Needed: samples at most about {finer:g} s apart"
        )


def _refuse_missed_clicks(path: Path, run: Recording) -> None:
    """Raises RecordingError where a ball was struck between samples and neither of them shows a force."""
    time, v = run.time, run.v
    struck = np.abs(np.diff(v, axis=0)) > STRUCK * np.abs(v).max(initial=0.0)
    padded = np.pad(run.F != 0, ((0, 0), (1, 1)))
    pressed = padded[:, 1:] | padded[:, :-1]
    missed = np.argwhere(struck & ~(pressed[1:] | pressed[:-1]))
    if v.shape[1] > 1 and len(missed):
        row, ball = missed[0]
        raise RecordingError(
            f"{path}: too coarse for the clicks. Ball {ball + 1} is struck between t = {time[row]:g} s and "
            f"{time[row + 1]:g} s, and F is 0 at both. Needed: F_peak[i] of every contact, or the run's "
            "table of pulses (`--pulses FILE.csv`)"
        )


def _guessed_pulses(time: Array, force: Array) -> Array:
    """Pulses as far as samples of the force show them: as long as a contact's samples are not 0."""
    rows = []
    for contact, column in enumerate(force.T, start=1):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column > 0, [0]])))
        for first, end in edges.reshape(-1, 2):
            rows.append((contact, time[max(0, first - 1)], time[end - 1], column[first:end].max(), 0.0))
    return np.sort(np.array(rows, dtype=PULSE), order=["onset", "contact"])


def _read_columns(path: Path) -> Columns:
    """A CSV file of numbers below one line of names."""
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:
        lines = csv.reader(file)
        names = [name.strip() for name in next(lines, [])]
        rows = []
        for row in lines:
            try:
                rows.append([float(TRUTH.get(cell, cell)) for cell in row])
            except ValueError as problem:
                raise RecordingError(f"{path}, line {lines.line_num}: {problem}") from None
            if len(row) != len(names):
                wrong = f"{len(row)} numbers for {len(names)} names"
                raise RecordingError(f"{path}, line {lines.line_num}: {wrong}")
    table = np.array(rows, dtype=float).reshape(len(rows), len(names))
    if not np.isfinite(table).all():
        raise RecordingError(f"{path}: NaN or infinite numbers cannot be drawn")
    return dict(zip(names, table.T, strict=True))


def _pulse_table(path: Path, balls: int) -> Array:
    columns = _read_columns(path)
    if missing := [name for name in FIELDS if name not in columns]:
        needed = f"a table of pulses has the columns {', '.join(FIELDS)}"
        raise RecordingError(f"{path}: {needed}; missing: {', '.join(missing)}")
    table = np.array(list(zip(*(columns[name] for name in FIELDS), strict=True)), dtype=PULSE)
    contacts = table["contact"]
    if len(table) and not (contacts.min() >= 1 and contacts.max() < balls):
        own = f"{balls} balls have contacts 1 to {balls - 1}"
        raise RecordingError(f"{path}: pulses of contacts {contacts.min()} to {contacts.max()}; {own}")
    return np.sort(table, order=["onset", "contact"])


def of_columns(title: str, columns: Columns, n: int, pulses: Array, *others: Any) -> Recording:
    """The recording of n balls whose variables are in these columns."""
    x, v, force = vector(columns, "x", n), vector(columns, "v", n), vector(columns, "F", n - 1)
    return Recording(title, columns["time"], x, v, force, pulses, energies(columns), *others)


def vector(columns: Columns, name: str, count: int) -> Array:
    """Columns name[1] to name[count] side by side, shape (samples, count)."""
    found = [columns[f"{name}[{i}]"] for i in range(1, count + 1)]
    return np.column_stack(found) if found else np.zeros((len(columns["time"]), 0))


def energies(columns: Columns) -> Columns:
    """The sums of what is stored where, else the total (J)."""
    sums = {}
    for name in ("kinetic", "gravity", "contact"):
        parts = [column for key, column in columns.items() if key.startswith(f"E_{name}[")]
        if parts:
            sums[name] = np.sum(parts, axis=0)
    return sums or ({"total": columns["E_total"]} if "E_total" in columns else {})


def _parameters(fmu: Fmu, run: Run) -> list[tuple[str, str, str, str]]:
    """Name, value, unit and meaning of each parameter; a vector whose elements are equal takes one row."""
    names = [v.name for v in fmu.variables.values() if v.causality == "parameter"]
    values: dict[str, list[str]] = {}
    for name, value in zip(names, run.recorder(names).row(), strict=True):
        values.setdefault(name.partition("[")[0], []).append(fmu.written(name, value))
    rows = []
    for name, texts in values.items():
        vector = name in fmu.arrays
        first = fmu.variables[f"{name}[1]" if vector else name]
        value = texts[0] if len(set(texts)) == 1 else ", ".join(texts)
        unit = "" if first.unit in (None, "1") else first.unit
        rows.append(
            (f"{name}[i]", value, unit, "") if vector else (name, value, unit, first.description or "")
        )
    return rows
