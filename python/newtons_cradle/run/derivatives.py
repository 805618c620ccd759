"""The FMU's own derivatives of a run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import FmuError, InvalidValue, needed
from ..pulses import Array
from .calls import Group

if TYPE_CHECKING:
    from .instance import Run

OVER = ("run", "step")
SELECTED = {"run": "run", "step": "lastStep"}  # items of `derivatives.of`, in FMI 3.0


def matrix(run: "Run", of: str | Sequence[str], by: str | Sequence[str], over: str) -> Array:
    """The derivatives of outputs at the current time by parameters or inputs, as an array with the dimension of `of`,
    then of `by`.

    `of`, `by`: a variable, which has no dimension, an array, or a list of names. `over`: either the whole `run` so far
    (FMI 3.0), through all contacts, by real parameters, start values and inputs; or the last `step`, by inputs. The
    change is the same at all times of the run or step. Select the run, by this call or `{"derivatives.of": "run"}`,
    before an input or a parameter changes. Raises UnknownName, InvalidValue, FmuError.
    """
    outputs, knowns = names_of(run, "of", of), names_of(run, "by", by)
    select(run, over)
    slave = run._instance
    rows, columns = places(run, outputs), places(run, knowns)
    picks = [list(map(group.columns.__getitem__, names)) for group, names in ((rows, outputs), (columns, knowns))]
    if run.fmu.fmi2 or len(knowns) <= len(outputs):
        found = np.empty((len(outputs), len(knowns)))
        ask, length = slave.getDirectionalDerivative, [] if run.fmu.fmi2 else [rows.length]
        for k, name in enumerate(knowns):
            answer = run._call(ask, rows.references, columns.references, seed(columns, name), *length)
            found[:, k] = np.array(answer)[picks[0]]
    else:
        ask, sets = slave.getAdjointDerivative, (rows.references, columns.references)
        answers = (run._call(ask, *sets, seed(rows, name), columns.length) for name in outputs)
        found = np.array([np.array(answer)[picks[1]] for answer in answers])
    lengths = [len(names) for given, names in ((of, outputs), (by, knowns)) if is_several(run, given)]
    return found.reshape(lengths)


def gradient(run: "Run", of: str, by: Sequence[str], over: str) -> dict[str, Any]:
    """The derivatives of one output by these parameters or inputs: a dict by name, with an array for an array; see
    `matrix`. With `over="run"` any number of them costs the same, as far as the FMU computes backwards (adjoint)."""
    if len(names_of(run, "of", of)) != 1 or not isinstance(of, str):
        raise InvalidValue(
            f"of = {of!r} is refused; allowed: one output, such as 'E_total'; `derivative` takes several"
        )
    by = [by] if isinstance(by, str) else list(by)
    flat = iter(matrix(run, of, by, over).ravel())
    found = {}
    for name in by:
        values = np.array([next(flat) for _ in run.fmu.elements(name)])
        found[name] = values if name in run.fmu.arrays else float(values[0])
    return found


def is_several(run: "Run", names: str | Sequence[str]) -> bool:
    return not isinstance(names, str) or names in run.fmu.arrays


def names_of(run: "Run", what: str, names: str | Sequence[str]) -> list[str]:
    """These variables, by element. Raises UnknownName, InvalidValue."""
    if not isinstance(names, str):
        needed(what, names, Sequence, "a name, or a list of names,")
    found = run.fmu.names([names] if isinstance(names, str) else names)
    if not found:
        raise InvalidValue(f"{what}: at least one name is needed")
    return found


def select(run: "Run", over: str) -> None:
    """Makes the FMU answer for the run or the last step. Raises InvalidValue, FmuError."""
    if over not in OVER:
        raise InvalidValue(f"over = {over!r} is refused; allowed: 'run', 'step'")
    if not run.fmu.fmi2:
        wanted = run.fmu.items("derivatives.of")[SELECTED[over]]
        if run.get("derivatives.of") != wanted:
            run.set({"derivatives.of": wanted})
    elif over == "run":
        cure = "`nc.build(fmi=3)` makes an FMU that has them; `over='step'` is for the last step"
        raise FmuError(f"derivatives over the run need FMI 3.0; {cure}")
    if over == "step" and run._parts.means:
        raise FmuError("the last step was so long that it was made in parts; make shorter steps for its derivatives")


def places(run: "Run", names: Sequence[str]) -> Group:
    """Where these variables are in calls: arrays of FMI 3.0 are passed as a whole."""
    group = Group("Real", run._instance.balls)
    for name in names:
        group.add(name, run.fmu.variables.place(name))
    return group


def seed(group: Group, name: str) -> list[float]:
    """1 for this variable, 0 for the others."""
    return [float(i == group.columns[name]) for i in range(group.length)]
