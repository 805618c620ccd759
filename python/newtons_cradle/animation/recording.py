"""What an animation shows: motion, forces, energies and pulses, from a run of an FMU or from a CSV file."""

import csv
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..fmu import Fmu
from ..pulses import FIELDS, PULSE, Array
from ..run.model import Values
from ..views import sample_times

#: As many numbers as an animation may hold, so that its page stays below 5 MB.
LARGEST = 1_200_000

Columns = dict[str, Array]  # by name

#: How FMPy writes Booleans.
TRUTH = {"True": "1", "False": "0"}


class RecordingError(ValueError):
    """A result that cannot be shown; the message says what is missing."""


@dataclass(frozen=True)
class Recording:
    """A run, ready to be drawn. SI units; arrays of shape (samples,) or (samples, balls or contacts).

    `energy`: by name, what is known of kinetic, gravity, contact and total energy. `length` and `radius`:
    of pendulum 1 and of a ball, for the drawing.
    """

    title: str
    time: Array
    x: Array
    v: Array
    F: Array
    pulses: Array
    energy: Columns = field(default_factory=dict)
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
    columns = {name: result[name] for name in ("time", *names)}
    return _recording(
        f"{n} ball{'s' if n > 1 else ''}, {stop:g} s", columns, pulses, length=length, radius=radius
    )


def from_csv(
    path: str | Path, pulses: str | Path | None = None, *, length: float = 1.962, radius: float = 0.0313
) -> Recording:
    """Reads a result in the layout that FMPy writes: `time`, `x[1]`, ..., as far as there v, F, F_peak and energies.

    `pulses`: CSV file of the pulse table. Without it, pulses are taken from F_peak, else from F. `length` and
    `radius` (m): for the drawing. Raises RecordingError, OSError.
    """
    table = None if pulses is None else _pulse_table(Path(pulses))
    return _recording(Path(path).stem, _read_columns(Path(path)), table, length=length, radius=radius)


def _recording(title: str, columns: Columns, pulses: Array | None, **drawing: float) -> Recording:
    time, x = columns.get("time"), _vector(columns, "x")
    if time is None or x is None:
        raise RecordingError(
            f"{title}: the columns time, x[1], x[2], ... are needed; there are {', '.join(columns)}"
        )
    if len(time) < 2 or np.any(np.diff(time) <= 0):
        raise RecordingError(f"{title}: at least two rows are needed, with times that rise")
    v, force = _vector(columns, "v"), _vector(columns, "F")
    if v is None:
        v = np.gradient(x, time, axis=0)
    if force is None:
        force = np.zeros((len(time), max(0, x.shape[1] - 1)))
    for name, array, wanted in (("v", v, x.shape[1]), ("F", force, x.shape[1] - 1)):
        if array.shape[1] != wanted:
            raise RecordingError(
                f"{title}: {x.shape[1]} positions need {wanted} of {name}, not {array.shape[1]}"
            )
    if pulses is None:
        peak = _vector(columns, "F_peak")
        pulses = _guessed_pulses(time, force if peak is None or peak.shape != force.shape else peak)
    return Recording(title, time, x, v, force, pulses, _energies(columns), **drawing)


def _vector(columns: Columns, name: str) -> Array | None:
    """Columns name[1], name[2], ... side by side."""
    found: list[Array] = []
    while (column := columns.get(f"{name}[{len(found) + 1}]")) is not None:
        found.append(column)
    return np.column_stack(found) if found else None


def _energies(columns: Columns) -> Columns:
    """The sums of what is stored where, else the total."""
    parts = {name: _vector(columns, f"E_{name}") for name in ("kinetic", "gravity", "contact")}
    if any(part is not None for part in parts.values()):
        return {name: part.sum(axis=1) for name, part in parts.items() if part is not None}
    return {"total": columns["E_total"]} if "E_total" in columns else {}


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
                raise RecordingError(
                    f"{path}, line {lines.line_num}: {len(row)} numbers for {len(names)} names"
                )
    table = np.array(rows, dtype=float).reshape(len(rows), len(names))
    if not np.isfinite(table).all():
        raise RecordingError(f"{path}: NaN or infinite numbers cannot be drawn")
    return dict(zip(names, table.T, strict=True))


def _pulse_table(path: Path) -> Array:
    columns = _read_columns(path)
    missing = [name for name in FIELDS if name not in columns]
    if missing:
        raise RecordingError(f"{path}: a table of pulses has the columns {', '.join(FIELDS)}")
    table = np.zeros(len(columns["onset"]), dtype=PULSE)
    for name in FIELDS:
        table[name] = columns[name]
    return np.sort(table, order=["onset", "contact"])
