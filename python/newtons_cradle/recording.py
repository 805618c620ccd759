"""What a page shows of a finished run: motion, forces, energies and pulses."""

import re
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import MOST_BALLS, CradleError, number, whole
from .pulses import COLUMNS, FIELDS, NEEDED, PULSE, Array
from .tables import as_number, by_name, read_csv

if TYPE_CHECKING:
    from .run.model import Model

LARGEST = 1_200_000  # numbers that a recording may hold, so that its page stays below 5 MB
DERIVATIVES = "derivatives.of"  # a parameter of FMI 3.0 that changes no run
LENGTH, RADIUS = 1.962, 0.0313  # m, for the drawing, where nothing else is said
COARSE = 0.05  # of the range of all x: how far a ball may be from where its velocities at two samples take it
HUGE = 1e30  # the largest number that is drawn: pages hold numbers in single precision
STRUCK = 0.3  # of the largest speed: a velocity that changes more between two samples has changed by an impact
OF_CONTACTS = ("F", "F_peak", "F_mean", "impulse", "E_contact", "gap")  # vectors with an element for each

OF_PULSES = {*FIELDS, *(name for name, *_ in COLUMNS.values())}

SHOWN = rf"(time|x|v|{'|'.join(OF_CONTACTS)}|E_\w+|{'|'.join(OF_PULSES)})(\[\d+\])?"  # names of columns

Columns = dict[str, Array]  # by name


class RecordingError(CradleError, ValueError):
    """A result that cannot be shown; the message says what is needed."""


@dataclass(frozen=True)
class Recording:
    """A run, ready to be drawn. SI units; arrays of shape (samples,) or (samples, balls or contacts).

    `energy`: E_kinetic, E_gravity and E_contact, each summed over its elements, else E_total; empty if none was
    recorded. `parameters`: rows of name, value, unit and meaning, one row for a vector; empty if unknown. `length` and
    `radius`: of pendulum 1 and of a ball, for the drawing. `start`: the parameters by name, vectors as lists, if a live
    run can start with them.
    """

    title: str
    time: Array
    x: Array
    v: Array
    F: Array
    pulses: Array = field(default_factory=lambda: np.zeros(0, PULSE))
    energy: Columns = field(default_factory=dict)
    parameters: list[tuple[str, str, str, str]] = field(default_factory=list)
    length: float = LENGTH
    radius: float = RADIUS
    start: dict[str, Any] | None = None


def from_csv(
    path: str | Path,
    pulses: str | Path | None = None,
    *,
    balls: int | None = None,
    length: float = LENGTH,
    radius: float = RADIUS,
) -> Recording:
    """Reads a result in CSV: time, x[i], v[i] of all balls, F[i] of all contacts; energies if there.

    `pulses`: CSV file of the pulse table; without it, they are taken from F_peak, else from F. `balls`: how many there
    are; None: as many as the columns name. `length`, `radius` (m): for the drawing. Raises RecordingError,
    InvalidValue, OSError.
    """
    number("length", length, "m", positive=True)
    number("radius", radius, "m", positive=True)
    if balls is not None:
        whole("balls", balls, 1, MOST_BALLS)
    path = Path(path)
    columns = _read_columns(path)
    run = replace(_checked(path, columns, balls, length=length, radius=radius), title=path.stem)
    n = run.x.shape[1]
    if pulses is not None:
        return replace(run, pulses=_pulse_table(Path(pulses), n))
    known = all(f"F_peak[{i}]" in columns for i in range(1, n))
    if not known:
        _refuse_missed_clicks(path, run)
    return replace(run, pulses=_guessed_pulses(run.time, vector(columns, "F_peak", n - 1) if known else run.F))


def from_result(columns: Columns, pulses: Array, model: "Model | None", given: dict[str, Any]) -> Recording:
    """The recording of a run whose samples are these columns; see `known_of`. Raises RecordingError."""
    balls = 1 if "x[2]" not in columns else None
    return _checked("the result", columns, balls, pulses=pulses, **known_of(model, given))


def known_of(model: "Model | None", given: dict[str, Any]) -> dict[str, Any]:
    """The fields of a `Recording` that follow from the model and its parameters and inputs, as far as these are
    known."""
    if model is None or not given:
        return {}
    rows, start = [], {}
    parameters = (name for name in given if name in model.parameters)
    for base, group in groupby(parameters, key=lambda name: name.partition("[")[0]):
        names, vector = list(group), base in model.arrays
        texts = [model.written(name, given[name]) for name in names]
        value = texts[0] if len(set(texts)) == 1 else ", ".join(texts)
        first = model.parameters[names[0]]
        rows.append((f"{base}[i]" if vector else base, value, first.unit, "" if vector else first.text))
        exact = texts if model.variables[names[0]].type == "Enumeration" else [given[name] for name in names]
        if base != DERIVATIVES:
            start[base] = exact if vector else exact[0]
    own = model.is_cradle
    free = not any(given[name] for name in given if name not in model.parameters)
    drawing = {"length": start["pendulum.length"], "radius": start["ball.radius"]} if own else {}
    return {"parameters": rows, "start": start if own and free else None, **drawing}


def _checked(source: object, columns: Columns, balls: int | None, **others: Any) -> Recording:
    """The recording of these columns, if complete and fine enough; see `of_columns`."""
    run = of_columns(str(source), columns, _number_of_balls(source, columns, balls), **others)
    time, x, v = run.time, run.x, run.v
    if len(time) < 2 or np.any(np.diff(time) <= 0):
        raise RecordingError(f"{source}: at least two rows are needed, with times that rise")
    step, extent = np.diff(time)[:, None], np.ptp(x)
    away = np.abs(np.diff(x, axis=0) - 0.5 * step * (v[1:] + v[:-1]))
    worst = np.unravel_index(np.argmax(away), away.shape)
    if extent > 0 and away[worst] > COARSE * extent:
        h = step[worst[0], 0]
        finer = float(f"{0.9 * h * COARSE * extent / away[worst]:.1g}")
        raise RecordingError(
            f"{source}: too coarse. The samples at t = {time[worst[0]]:g} s are {h:g} s apart, and ball {worst[1] + 1} "
            f"cannot be followed between them. Needed: samples at most about {finer:g} s apart"
        )
    return run


def _number_of_balls(source: object, columns: Columns, wanted: int | None) -> int:
    """The number of balls in the file, once all their columns are there."""
    ends = [re.fullmatch(r"(\w+)\[(\d+)\]", name) for name in columns]
    n = wanted or max([1, *(int(end[2]) + (end[1] in OF_CONTACTS) for end in ends if end)])
    if n > MOST_BALLS:
        name = max((end for end in ends if end), key=lambda end: int(end[2]))[0]
        raise RecordingError(f"{source}: it has a column {name}; allowed: up to {MOST_BALLS} balls")
    counts = {"x": n, "v": n, "F": n - 1}
    needed = ["time", *(f"{name}[{i}]" for name, count in counts.items() for i in range(1, count + 1))]
    missing = [name for name in needed if name not in columns]
    if missing:
        shown = ", ".join(missing[:6]) + (", ..." if len(missing) > 6 else "")
        whose = f" of {n} balls" if n > 1 else ""
        raise RecordingError(
            f"{source}: the result{whose} is incomplete; missing: {shown}. Needed: time, x[i] and v[i] of every ball "
            "and F[i] of every contact; F_peak[i] as well, unless the samples resolve every pulse"
        )
    if n == 1 and wanted is None:
        raise RecordingError(
            f"{source}: the file has only one ball. If the cradle has one, say `--balls 1`; else record x[i] and v[i] "
            "of every ball and F[i] and F_peak[i] of every contact"
        )
    return n


def _refuse_missed_clicks(source: object, run: Recording) -> None:
    """Raises RecordingError where a ball was struck between samples and neither of them shows a force."""
    time, v = run.time, run.v
    struck = np.abs(np.diff(v, axis=0)) > STRUCK * np.abs(v).max(initial=0.0)
    padded = np.pad(run.F != 0, ((0, 0), (1, 1)))
    pressed = padded[:, 1:] | padded[:, :-1]
    missed = np.argwhere(struck & ~(pressed[1:] | pressed[:-1]))
    if v.shape[1] > 1 and len(missed):
        row, ball = missed[0]
        raise RecordingError(
            f"{source}: too coarse for the clicks. Ball {ball + 1} is struck between t = {time[row]:g} s and "
            f"{time[row + 1]:g} s, and F is 0 at both. Needed: F_peak[i] of every contact, or the run's "
            "table of pulses (`--pulses FILE.csv`)"
        )


def _guessed_pulses(time: Array, force: Array) -> Array:
    """Pulses from samples of the force: one for each series of samples above 0 in a contact."""
    rows = []
    for contact, column in enumerate(force.T, start=1):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column > 0, [0]])))
        for first, end in edges.reshape(-1, 2):
            highest = first + column[first:end].argmax()
            rows.append((contact, time[max(0, first - 1)], time[end - 1], column[highest], 0.0, time[highest]))
    return np.sort(np.array(rows, dtype=PULSE), order=["onset", "contact"])


def _read_columns(path: Path, what: str = "a run", first: tuple[str, ...] = ("time", "x[1]", "...")) -> Columns:
    """The columns of a CSV file that a page shows, as numbers, by name; `first`: the first column, which is required,
    and others for the message. Raises RecordingError."""
    table = read_csv(path)
    columns = by_name(table.columns)
    if first[0] not in columns:
        needed = f"its first line must name {', '.join(first)}, separated by commas"
        raise RecordingError(f"{path}: this is not a table of {what}: {needed}")
    found = {}
    # In FMI 3.0 the last element of an array over contacts belongs to no contact.
    arrays = [name for name in OF_CONTACTS if name in columns and f"{name}[1]" in columns]
    padding = [f"{name}[{sum(other.startswith(f'{name}[') for other in columns)}]" for name in arrays]
    left_out = {*arrays, *padding, "x", "v"}
    for name in (name for name in columns if re.fullmatch(SHOWN, name) and name not in left_out):
        numbers = [as_number(cell) for cell in columns[name]]
        if None in numbers:
            row = numbers.index(None)
            wrong = f"{name} is {columns[name][row]!r}; a number is needed"
            raise RecordingError(f"{path}, line {table.lines[row]}: {wrong}")
        found[name] = np.array(numbers, dtype=float)
        if not np.all(np.abs(found[name]) <= HUGE):
            raise RecordingError(
                f"{path}: {name} has numbers that cannot be drawn; allowed: finite ones up to {HUGE:g}"
            )
    return found


def _pulse_table(path: Path, balls: int) -> Array:
    columns = _read_columns(path, "pulses", NEEDED)
    if missing := [name for name in NEEDED if name not in columns]:
        needed = f"a table of pulses has the columns {', '.join(NEEDED)}"
        raise RecordingError(f"{path}: {needed}; missing: {', '.join(missing)}")
    table = np.empty(len(columns["contact"]), PULSE)
    for name in FIELDS:
        table[name] = columns.get(name, columns.get(COLUMNS[name][0], np.nan))
    contacts = table["contact"]
    if len(table) and not (contacts.min() >= 1 and contacts.max() < balls):
        own = f"{balls} balls have contacts 1 to {balls - 1}"
        raise RecordingError(f"{path}: pulses of contacts {contacts.min()} to {contacts.max()}; {own}")
    return np.sort(table, order=["onset", "contact"])


def of_columns(title: str, columns: Columns, n: int, **others: Any) -> Recording:
    """The recording of n balls whose variables are in these columns; `others`: further fields."""
    motion = vector(columns, "x", n), vector(columns, "v", n), vector(columns, "F", n - 1)
    energy = {}
    for name in ("E_kinetic", "E_gravity", "E_contact"):
        parts = [column for key, column in columns.items() if key.startswith(f"{name}[")]
        if parts:
            energy[name] = np.sum(parts, axis=0)
    if not energy and "E_total" in columns:
        energy["E_total"] = columns["E_total"]
    return Recording(title, columns["time"], *motion, energy=energy, **others)


def vector(columns: Columns, name: str, count: int) -> Array:
    """Columns name[1] to name[count] side by side, shape (samples, count)."""
    found = [columns[f"{name}[{i}]"] for i in range(1, count + 1)]
    return np.column_stack(found) if found else np.zeros((len(columns["time"]), 0))
