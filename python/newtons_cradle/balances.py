"""What must not change: energy and momentum over a run, as numbers to compare with a tolerance."""

import numpy as np

from .pulses import Array, impact_sequences
from .run import Result


def energy_error(result: Result) -> float:
    """Largest |E_residual| of a run, divided by its start energy. E_residual and E_total must be recorded.

    E_residual is E_total + E_dissipated - W_external - E_total(start). Damping and external work are
    accounted for; what is left is the solver's own error.
    """
    return float(np.max(np.abs(result["E_residual"])) / result["E_total"][0])


def momentum_of_sequences(result: Result, pause: float = 0.01) -> Array:
    """p_total(after) - p_total(before) + the integral of F_support_mean over each impact sequence, kg.m/s.

    Zero for a cradle without external forces, because only the support changes its momentum.

    Each sequence is taken over the whole communication steps around it; sequences that begin before
    the first or end after the last communication point are left out.
    """
    time = result["time"]
    supported = np.concatenate([[0.0], np.cumsum(np.diff(time) * result["F_support_mean"][1:])])
    defects = []
    for sequence in impact_sequences(result.pulses, pause):
        before = np.searchsorted(time, sequence["onset"].min(), side="left") - 1
        after = np.searchsorted(time, sequence["release"].max(), side="right")
        if before >= 0 and after < len(time):
            change = result["p_total"][after] - result["p_total"][before]
            defects.append(change + supported[after] - supported[before])
    return np.array(defects)
