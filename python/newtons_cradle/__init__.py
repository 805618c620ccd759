"""Run the cradle FMU through FMPy and read what happened at each impact.

    import newtons_cradle as nc

    with nc.Fmu("target/fmu/NewtonsCradle.fmu") as fmu:
        result = fmu.simulate({"contact.deadBand": 2.6e-6}, stop=10.0)

    result["x[1]"]      # one value per communication point
    result.pulses       # one row per contact pulse, however short

Modules: `fmu` (open, start and step an FMU), `pulses` (the log of pulses as a table, impact sequences,
pulse order), `views` (runs that resolve every pulse), `balances` (energy and momentum), `setups` (start
values of the paper's experiments), `progress` (a progress bar).
"""

from .balances import energy_error, momentum_defect, momentum_of_sequences
from .fmu import NEVER, Fmu, FmuError, LogLine, Result, Run, Saved
from .progress import Progress
from .pulses import PULSE, impact_sequences, overlapping_neighbours, parse_pulse, pulse_order
from .setups import chain, figure3, figure5, figure6, lifted, power_law, steel
from .views import overlaps, resolved, sample_times

__all__ = [
    "NEVER",
    "PULSE",
    "Fmu",
    "FmuError",
    "LogLine",
    "Progress",
    "Result",
    "Run",
    "Saved",
    "chain",
    "energy_error",
    "figure3",
    "figure5",
    "figure6",
    "impact_sequences",
    "lifted",
    "momentum_defect",
    "momentum_of_sequences",
    "overlapping_neighbours",
    "overlaps",
    "parse_pulse",
    "power_law",
    "pulse_order",
    "resolved",
    "sample_times",
    "steel",
]
