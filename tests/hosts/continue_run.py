"""Goes on from saved states in a process of its own and prints what it reads, bit by bit.

    python continue_run.py FILE.fmu      (JSON on standard input: a list of [file of the state, steps])

Run by test_states.py. `steps`: a list of [step size in s, input derivatives as [[name, order, value], ...]].
"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))

import newtons_cradle as nc


def steps_of(run: nc.Run, steps: list) -> list:
    """Makes the steps; after each every variable as text without loss, and the log lines."""
    recorder = run.recorder(run.fmu.variables)
    seen = []
    for size, derivatives in steps:
        for name, order, value in derivatives:
            reference = run.fmu.variables[name].valueReference
            run.slave.setRealInputDerivatives([reference], [order], [value])
        before = len(run.log)
        run.step(size)
        values = [float(value).hex() for value in recorder.row()]
        seen.append([values, [line.text for line in run.log[before:]]])
    return seen


def continued(fmu: nc.Fmu, state: str, steps: list) -> list:
    """Loads the state into an instance that was only instantiated, and makes the steps."""
    with fmu.start(initialize=False) as run:
        run.load(nc.Saved(0.0, Path(state).read_bytes()))
        run.time = run.slave.getRealStatus(2)  # fmi2LastSuccessfulTime
        return steps_of(run, steps)


if __name__ == "__main__":
    with nc.Fmu(sys.argv[1]) as fmu:
        json.dump([continued(fmu, *state) for state in json.load(sys.stdin)], sys.stdout)
