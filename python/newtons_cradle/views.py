"""Views that show a run at two time scales at once; how much pulses overlap; balances of energy and momentum."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from .errors import MOST_STEPS, InvalidValue, whole
from .fmu import Fmu, equal_steps
from .pulses import Array, impact_sequences
from .recording import LARGEST, Recording, RecordingError, known_of, of_columns
from .run import Result
from .run.model import Values

Told = Callable[[float], None] | None  # called with the fraction done


RESOLVED = 4  # samples that a pulse needs for its impulse


def sample_times(pulses: Array, stop: float, step: float, per_pulse: int = 32) -> Array:
    """Communication points (s) every `step` up to `stop` and `per_pulse` of them, at least 2, in every pulse.

    Pulses without duration, such as those of rigid contacts, get points from a nanosecond before them. Raises
    InvalidValue.
    """
    whole("per_pulse", per_pulse, 2, MOST_STEPS)
    begins = np.minimum(pulses["onset"], pulses["release"] - 1e-9)
    inside = [np.linspace(*ends, per_pulse) for ends in zip(begins, pulses["release"], strict=True)]
    times = np.unique(np.concatenate([[0.0], equal_steps(stop, step), *inside]))
    return times[(times >= 0.0) & (times <= stop)]


def resolved(
    fmu: Fmu,
    values: Values | None = None,
    *,
    stop: float,
    step: float = 0.01,
    per_pulse: int = 32,
    record: Iterable[str] | None = None,
    progress: Told = None,
) -> Result:
    """A run whose samples resolve every pulse, from seconds down to nanoseconds.

    It is run twice: once in large steps for the table of pulses, then with communication points in every pulse. The
    trajectory does not depend on communication points, so both runs have the same pulses.
    """
    pulses, then = first_pass(fmu, values, stop, progress)
    return fmu.simulate(values, times=sample_times(pulses, stop, step, per_pulse), record=record, progress=then)


def first_pass(fmu: Fmu, values: Values | None, stop: float, progress: Told) -> tuple[Array, Told]:
    """The pulses of a first run, and the progress function of a second run: each run is half of the work."""
    first = None if progress is None else lambda done: progress(done / 2)
    then = None if progress is None else lambda done: progress((1 + done) / 2)
    return fmu.simulate(values, stop=stop, step=stop / 100, record=[], progress=first).pulses, then


def overlaps(result: Result) -> Array:
    """Overlap of each contact's pulse with the next contact's, shape (contacts - 1,), 0 to 1.

    The impulse that they share, the integral of min(F_i, F_(i+1)), divided by the smaller of their impulses. Uses
    the trapezoidal rule, so the samples must resolve the pulses. 0 where one of the two never closed. Raises
    InvalidValue where a pulse has fewer than 4 samples.
    """
    force, time = result["F"], result["time"]
    pulses = result.pulses[result.pulses["release"] > result.pulses["onset"]]  # rigid contacts have no force
    onset, release = pulses["onset"], pulses["release"]
    samples = np.searchsorted(time, release, side="right") - np.searchsorted(time, onset)
    for i in np.flatnonzero((onset >= time[:1]) & (release <= time[-1:]) & (samples < RESOLVED))[:1]:
        raise InvalidValue(
            f"the samples do not resolve the pulses: contact {pulses['contact'][i]} has {samples[i]} in its pulse at "
            f"{onset[i]:.9g} s; allowed: at least {RESOLVED}, as in results of `nc.resolved`"
        )
    shared = np.trapezoid(np.minimum(force[:, :-1], force[:, 1:]), time, axis=0)
    impulse = np.trapezoid(force, time, axis=0)
    smaller = np.minimum(impulse[:-1], impulse[1:])
    shares: Array = np.divide(shared, smaller, out=np.zeros_like(shared), where=smaller > 0)
    return shares


def energy_error(result: Result) -> float:
    """Largest |E_residual| of a run, divided by its largest |E_total|; 0 if there is no error. E_residual and E_total
    must be recorded.

    E_residual is E_total + E_dissipated - W_external - E_total(start): the solver's own error.
    """
    error, largest = (np.max(np.abs(result[name])) for name in ("E_residual", "E_total"))
    return float(error / largest) if error else 0.0


def momentum_of_sequences(result: Result, pause: float = 0.01) -> Array:
    """p_total(after) - p_total(before) + the integral of F_support_mean over each impact sequence, kg.m/s.

    Zero for a cradle without external forces, because only the support changes its momentum. Each sequence is taken
    over the whole communication steps around it; those that have no communication point on either side are left out.
    """
    time = result["time"]
    supported = np.concatenate([[0.0], np.cumsum(np.diff(time) * result["F_support_mean"][1:])])
    defects = []
    for sequence in impact_sequences(result.pulses, pause):
        before = np.searchsorted(time, sequence["onset"].min(), side="left") - 1
        after = np.searchsorted(time, sequence["release"].max(), side="right")
        if before >= 0 and after < len(time):
            defects.append(result["p_total"][after] - result["p_total"][before] + supported[after] - supported[before])
    return np.array(defects)


def from_fmu(
    path: str | Path | None,
    values: Values | None = None,
    *,
    stop: float = 10.0,
    step: float = 0.02,
    progress: Told = None,
) -> Recording:
    """Runs an FMU with these start values for `stop` (s); samples every `step` (s) and within every pulse.

    The run is made twice, as in `resolved`. Raises FileMissing, RecordingError, FmuError, InvalidValue or UnknownName.
    """
    with Fmu(path) as fmu:
        if missing := [name for name in ("x[1]", "v[1]") if name not in fmu.variables]:
            raise RecordingError(f"{fmu.path}: the FMU is no cradle; missing: {', '.join(missing)}")
        pulses, then = first_pass(fmu, values, stop, progress)
        n = fmu.balls
        shown = ("x", "v", "F", "E_kinetic", "E_gravity", "E_contact")
        # As many samples in each pulse as fit; where not even four do, the later pulses go without.
        room = max(4, LARGEST // (3 * n + 3) - len(equal_steps(stop, step)))
        per_pulse = int(np.clip(room // max(1, len(pulses)), 4, 48))
        times = sample_times(pulses[: room // per_pulse], stop, step, per_pulse)
        result = fmu.simulate(values, times=times, record=[name for name in shown if name in fmu.arrays], progress=then)
    columns = {name: result[name] for name in result}
    title = f"{n} ball{'s' if n > 1 else ''}, {stop:g} s"
    return of_columns(title, columns, n, pulses=pulses, **known_of(result.model, result.given))
