"""Run the cradle FMU through FMPy and read what happened at each impact.

    import newtons_cradle as nc

    with nc.Fmu() as fmu:
        result = fmu.simulate({"contact.deadBand": 2.6e-6}, stop=10.0)

    result["x[1]"]      # one value per communication point, m
    result.pulses       # one row per contact pulse, however short: contact (from 1), onset and release in s, peak
                        # force in N, impulse in N.s, time of the peak in s
    result.plot("x")    # a picture, with the extra `plot`

`fmu.parameters`, `fmu.inputs` and `fmu.outputs` list the variables with unit, range, default and meaning. `fmu.start()`
gives a run that you step yourself: `run.step(0.01)`, `run["v[1]"]`, `run["F_ext[1]"] = 0.2`, `run.time` (s),
`run.pulses`, and `run.log`, the FMU's messages.

Modules: `fmu` (open and run FMUs), `building` (make them), `run` (its instances, steps, log and results), `pulses` (the
log of pulses as a table, impact sequences, pulse order), `views` (runs with samples in every pulse, overlap of pulses,
balances of energy and momentum), `sweeps` (many runs), `workers` (the processes that run them), `fitting` (parameters
fitted to measurements), `setups` (start values: presets, the paper's experiments), `materials` (spheres of given sizes
and materials), `calibration` (a real cradle's losses from a video), `losses` (damping from a coefficient of
restitution), `cases` (the benchmark for rows of balls), `trial` (test cases for FMI hosts, and their judge), `progress`
(a progress bar), `recording` and `page` (a run as a page for a browser), `errors` (what all functions raise), `testing`
(pytest fixtures and assertions), `look` (colours and fonts).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers; `as` exports the names
    from . import look as look
    from .building import build as build
    from .calibration import Calibration as Calibration, calibrate as calibrate
    from .cases import Case as Case, Judgement as Judgement, benchmark as benchmark, benchmarks as benchmarks
    from .errors import (
        CradleError as CradleError,
        DoubtfulStart as DoubtfulStart,
        FileMissing as FileMissing,
        FmuError as FmuError,
        InvalidValue as InvalidValue,
        PackageMissing as PackageMissing,
        UnknownName as UnknownName,
    )
    from .fitting import Fit as Fit, fit as fit
    from .fmu import Fmu as Fmu
    from .losses import damping as damping
    from .materials import spheres as spheres
    from .progress import Progress as Progress
    from .pulses import (
        PULSE as PULSE,
        impact_sequences as impact_sequences,
        overlapping_neighbours as overlapping_neighbours,
        parse_pulse as parse_pulse,
        pulse_order as pulse_order,
    )
    from .recording import RecordingError as RecordingError
    from .run import NEVER as NEVER, LogLine as LogLine, Result as Result, Run as Run, Saved as Saved
    from .setups import (
        chain as chain,
        figure5 as figure5,
        lifted as lifted,
        power_law as power_law,
        preset as preset,
        presets as presets,
        steel as steel,
    )
    from .sweeps import Sweep as Sweep, sweep as sweep
    from .views import (
        energy_error as energy_error,
        momentum_of_sequences as momentum_of_sequences,
        overlaps as overlaps,
        resolved as resolved,
        sample_times as sample_times,
    )

#: Exported names by module. A module is imported at first use, because NumPy alone takes a tenth of a second.
NAMES = {
    "building": ["build"],
    "calibration": ["Calibration", "calibrate"],
    "cases": ["Case", "Judgement", "benchmark", "benchmarks"],
    "errors": [
        "CradleError",
        "DoubtfulStart",
        "FileMissing",
        "FmuError",
        "InvalidValue",
        "PackageMissing",
        "UnknownName",
    ],
    "fitting": ["Fit", "fit"],
    "fmu": ["Fmu"],
    "losses": ["damping"],
    "materials": ["spheres"],
    "progress": ["Progress"],
    "pulses": ["PULSE", "impact_sequences", "overlapping_neighbours", "parse_pulse", "pulse_order"],
    "recording": ["RecordingError"],
    "run": ["NEVER", "LogLine", "Result", "Run", "Saved"],
    "setups": ["chain", "figure5", "lifted", "power_law", "preset", "presets", "steel"],
    "sweeps": ["Sweep", "sweep"],
    "views": ["energy_error", "momentum_of_sequences", "overlaps", "resolved", "sample_times"],
}
HOMES = {name: module for module, names in NAMES.items() for name in names}
MODULES = [*NAMES, "files", "look", "markup", "page", "testing", "trial", "workers"]

__all__ = ["look", *HOMES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module(".files", __name__).version()
    if name in MODULES:
        return import_module(f".{name}", __name__)
    if name not in HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f".{HOMES[name]}", __name__), name)
    return found


def __dir__() -> list[str]:
    own = [name for name in globals() if name.startswith("__")]
    return sorted({*own, "__version__", *HOMES, *MODULES})
