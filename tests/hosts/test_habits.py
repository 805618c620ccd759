"""What hosts do differently: each of their ways to call the FMU gives the same run.

The habits were read from the sources of FMPy, fmusim, fmi-sim, OMSimulator, the FMU Compliance Checker, MasterSim and
PyFMI.
"""

import math
from collections.abc import Callable, Iterator
from ctypes import byref
from dataclasses import dataclass
from pathlib import Path

import newtons_cradle as nc
import pytest
from newtons_cradle.run import log as router

pytestmark = pytest.mark.all

STOP, STEP = 3.0, 0.01  # s
SHOWN = ["x", "v", "impulse", "pulses"]
POINTS = range(1, round(STOP / STEP) + 1)
Steps = Iterator[tuple[float, float]]  # current communication points and step sizes, s


def differences() -> Steps:
    """To start + n h from where the FMU is: the sizes differ by rounding."""
    time = 0.0
    for n in POINTS:
        yield time, n * STEP - time
        time = n * STEP


def constant() -> Steps:
    """Always h from n h."""
    for n in POINTS:
        yield (n - 1) * STEP, STEP


def accumulated() -> Steps:
    """The host adds up h; the last step is whatever is left."""
    time = 0.0
    while time + 1.5 * STEP < STOP:
        yield time, STEP
        time += STEP
    yield time, STOP - time


@dataclass
class Habit:
    """How a host calls the FMU."""

    location: str = "{uri}"
    name: str = "cradle"
    visible: bool = False
    logging: bool = False
    environment: bool = False
    before: bool = True  # start values are set before fmi2SetupExperiment
    again: bool = False  # and set again in Initialization Mode
    tolerance: tuple[bool, float] = (False, 0.0)
    stop: tuple[bool, float] = (True, STOP)
    steps: Callable[[], Steps] = differences
    doubling: bool = False  # steps are made whole, taken back, and made again in halves
    reads_all: bool = False


ON, OFF = True, False
HABITS = {
    "FMPy": Habit(before=False, again=True),
    "fmusim": Habit("{uri}/", "instance1", environment=True, stop=(OFF, 0.0), reads_all=True),
    "fmi-sim": Habit(name="inst1", visible=True, logging=True, steps=constant),
    "OMSimulator": Habit("file:///{path}", visible=True, logging=True, again=True, tolerance=(ON, 1e-4),
                         stop=(OFF, 0.0), reads_all=True),
    "FMU Compliance Checker": Habit(name="Test FMI 2.0 CS", environment=True, tolerance=(OFF, 1e-4),
                                    stop=(OFF, STOP), steps=accumulated, reads_all=True),
    "MasterSim": Habit("file://{path}", tolerance=(ON, 1e-6), doubling=True),
    "PyFMI": Habit(environment=True, tolerance=(ON, 1e-4), stop=(OFF, math.nan), steps=constant,
                   reads_all=True),
}  # fmt: skip


def end_of_run(fmu: nc.Fmu, habit: Habit) -> list:
    """Runs as the host would; positions, velocities, impulses and counts at the end."""
    log: list[nc.LogLine] = []
    with fmu.start(initialize=False) as run:  # for its names and getters; the instance is made anew
        slave = run.slave
        slave.fmi2FreeInstance(slave.component)  # FMPy's own would unload the library
        callbacks = router.callbacks(log)
        if not habit.environment:
            callbacks.componentEnvironment = None
        resources = Path(fmu.folder) / "resources"
        location = habit.location.format(uri=resources.as_uri(), path=resources.as_posix())
        texts = [text.encode() for text in (habit.name, fmu.description.guid, location)]
        slave.component = slave.fmi2Instantiate(
            texts[0], 1, texts[1], texts[2], byref(callbacks), habit.visible, habit.logging
        )
        assert slave.component
        values = nc.figure5()
        if habit.before:
            run.set(values)
        slave.fmi2SetupExperiment(slave.component, *habit.tolerance, 0.0, *habit.stop)
        if not habit.before:
            run.set(values)
        slave.enterInitializationMode()
        everything = run.recorder(fmu.variables)
        if habit.again:
            run.set(values)
            everything.row()
        slave.exitInitializationMode()
        for time, size in habit.steps():
            if habit.doubling:
                state = slave.getFMUstate()
                slave.doStep(time, size)
                slave.setFMUstate(state)
                slave.freeFMUstate(state)
                slave.doStep(time, 0.5 * size)
                slave.doStep(time + 0.5 * size, time + size - (time + 0.5 * size))
            else:
                slave.doStep(time, size)
            if habit.reads_all:
                everything.row()
        assert slave.getRealStatus(2) == STOP  # fmi2LastSuccessfulTime
        end = [run.get(name) for name in fmu.names(SHOWN)]
        slave.terminate()
        everything.row()
        assert [line for line in log if line.status != 0] == []
    return end


@pytest.mark.parametrize("host", HABITS)
def test_every_habit_gives_the_same_run(fmu, host):
    with fmu.start(nc.figure5()) as run:
        run.step_to(STOP)
        wanted = [run.get(name) for name in fmu.names(SHOWN)]
    assert end_of_run(fmu, HABITS[host]) == wanted
