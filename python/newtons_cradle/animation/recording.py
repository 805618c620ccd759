"""What an animation shows: motion, forces, energies and pulses of a run."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..fmu import Fmu
from ..pulses import Array
from ..run import Run
from ..run.model import Values
from ..views import sample_times

#: As many numbers as an animation may hold, so that its page stays below 5 MB.
LARGEST = 1_200_000

Columns = dict[str, Array]  # by name


@dataclass(frozen=True)
class Recording:
    """A run, ready to be drawn. SI units; arrays of shape (samples,) or (samples, balls or contacts).

    `energy`: by name, what is known of kinetic, gravity, contact and total energy. `parameters`: rows of name, value, unit
    and meaning, as far as known. `length` and `radius`: of pendulum 1 and of a ball, for the drawing.
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
            (f"{name}[i]" if vector else name, value, unit, "" if vector else first.description or "")
        )
    return rows
