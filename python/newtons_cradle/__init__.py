"""Run the cradle FMU through FMPy and read what happened at each impact.

    import newtons_cradle as nc

    with nc.Fmu() as fmu:
        result = fmu.simulate({"contact.deadBand": 2.6e-6}, stop=10.0)

    result["x[1]"]      # one value per communication point, m
    result.pulses       # one row per contact pulse, however short: contact (from 1), onset and release in s, peak
                        # force in N, impulse in N.s
    result.plot("x")    # a picture, with the extra `plot`

What there is to set and to see is in `fmu.parameters`, `fmu.inputs` and `fmu.outputs`: names with unit, range, default
and meaning. `fmu.start()` gives a run to step oneself: `run.step(0.01)`, `run["v[1]"]`, `run["F_ext[1]"] = 0.2`,
`run.time` (s), `run.pulses`, and `run.log`, the FMU's messages.

Modules: `fmu` (open, make and run FMUs), `run` (its instances, steps, log and results), `pulses`
(the log of pulses as a table, impact sequences, pulse order), `views` (runs that resolve every pulse, and how much
pulses overlap in them; balances of energy and momentum), `setups` (start values: presets, the paper's experiments),
`calibration` (a real cradle's losses from a video), `cases` (the benchmark for rows of balls), `trial` (cases that put
hosts on trial, and their judge), `progress` (a progress bar), `recording` and `page` (a run as a page for a browser),
`errors` (what all functions raise), `testing` (pytest fixtures and assertions), `look` (colours and fonts).
"""

from . import files, look
from .calibration import Calibration, calibrate
from .cases import Case, Judgement, benchmark, benchmarks
from .errors import CradleError, DoubtfulStart, FileMissing, FmuError, InvalidValue, PackageMissing, UnknownName
from .fmu import Fmu, build
from .progress import Progress
from .pulses import PULSE, impact_sequences, overlapping_neighbours, parse_pulse, pulse_order
from .recording import RecordingError
from .run import NEVER, LogLine, Result, Run, Saved
from .setups import chain, figure5, lifted, power_law, preset, presets, steel
from .views import energy_error, momentum_of_sequences, overlaps, resolved, sample_times

__version__ = files.version()

__all__ = ["NEVER", "Fmu", "LogLine", "Result", "Run", "Saved", "build", "look"]
__all__ += ["CradleError", "DoubtfulStart", "FileMissing", "FmuError"]
__all__ += ["InvalidValue", "PackageMissing", "RecordingError", "UnknownName"]
__all__ += ["PULSE", "impact_sequences", "overlapping_neighbours", "parse_pulse", "pulse_order"]
__all__ += ["chain", "figure5", "lifted", "power_law", "preset", "presets", "steel"]
__all__ += ["Calibration", "Case", "Judgement", "Progress", "benchmark", "benchmarks", "calibrate"]
__all__ += ["energy_error", "momentum_of_sequences", "overlaps", "resolved", "sample_times"]
