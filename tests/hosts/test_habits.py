"""What hosts do differently: each of their ways to call the FMU gives the same run.

The habits were read from the sources of FMPy, fmusim, fmi-sim, OMSimulator, the FMU Compliance Checker, MasterSim and PyFMI.
"""

import math
import shutil
import subprocess
from collections.abc import Callable, Iterator
from ctypes import byref
from dataclasses import dataclass
from pathlib import Path

import newtons_cradle as nc
import pytest
from fmpy.simulation import instantiate_fmu
from newtons_cradle.run import log as router

pytestmark = pytest.mark.all

STOP, STEP = 3.0, 0.01  # s
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


HABITS = {
    "FMPy": Habit(before=False, again=True),
    "fmusim": Habit("{uri}/", "instance1", environment=True, stop=(False, 0.0), reads_all=True),
    "fmi-sim": Habit(name="inst1", visible=True, logging=True, steps=constant),
    "OMSimulator": Habit(
        "file:///{path}",
        visible=True,
        logging=True,
        again=True,
        tolerance=(True, 1e-4),
        stop=(False, 0.0),
        reads_all=True,
    ),
    "FMU Compliance Checker": Habit(
        name="Test FMI 2.0 CS",
        environment=True,
        tolerance=(False, 1e-4),
        stop=(False, STOP),
        steps=accumulated,
        reads_all=True,
    ),
    "MasterSim": Habit("file://{path}", tolerance=(True, 1e-6), doubling=True),
    "PyFMI": Habit(
        environment=True, tolerance=(True, 1e-4), stop=(False, math.nan), steps=constant, reads_all=True
    ),
}


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
        families = ("x", "v", "impulse", "pulses")
        end = [run.get(name) for name in fmu.outputs if name.split("[")[0] in families]
        slave.terminate()
        everything.row()
        assert [line for line in log if line.status != 0] == []
    return end


@pytest.mark.parametrize("host", HABITS)
def test_every_habit_gives_the_same_run(fmu, host):
    with fmu.start(nc.figure5()) as run:
        run.step_to(STOP)
        families = ("x", "v", "impulse", "pulses")
        wanted = [run.get(name) for name in fmu.outputs if name.split("[")[0] in families]
    assert end_of_run(fmu, HABITS[host]) == wanted


def test_a_step_beyond_the_stop_time_is_made(fmu):
    """fmi-sim makes a whole last step where the stop time is no multiple of the step."""
    with fmu.start(initialize=False) as run:
        run.slave.setupExperiment(startTime=0.0, stopTime=1.0)
        run.slave.enterInitializationMode()
        run.slave.exitInitializationMode()
        for n in range(4):
            run.slave.doStep(n * 0.3, 0.3)
        assert run.slave.getRealStatus(2) == pytest.approx(1.2)
        assert [line for line in run.log if line.status != 0] == []


def test_exactly_the_functions_of_the_standard_are_exported(fmu, make3):
    """All of them, for hosts that look for every one; no others, which could clash with those of the host."""
    libraries = list(Path(fmu.folder).glob("binaries/linux*/*.so"))
    if not libraries or shutil.which("nm") is None:
        pytest.skip("needs nm and a Linux binary")
    command = ["nm", "-D", "--defined-only", libraries[0]]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    names = {line.split()[-1] for line in lines}
    with fmu.start(initialize=False) as run:
        known = set(run.slave._functions)
    exchange = instantiate_fmu(fmu.folder, fmu.description, "ModelExchange")
    known |= set(exchange._functions)
    exchange.freeInstance()
    known |= set(make3().make()._functions)
    assert names == known and len(names) == 44 + 75
