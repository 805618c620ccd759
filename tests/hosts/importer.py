"""A small importer with planted mistakes, to put the judge of `newtons_cradle.trial` on trial. It shares no code with
the judge's own master: FMPy's calls, and loops of its own."""

import math
from ctypes import POINTER, c_double
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Slave

RIGHT = (1 / 6, 1 / 3, 1 / 3, 1 / 6)  # weights of Runge and Kutta's method
CLOCKED = ("onset.", "release.")


class Importer:
    """An FMU, unpacked here, and a run of it with a mistake, or none."""

    def __init__(self, case, fmu: Path, folder: Path, mistake: str = ""):
        self.case, self.mistake = case, mistake
        self.description = read_model_description(str(fmu))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        kind = FMU2Model if case.exchange else FMU2Slave if case.fmi == 2 else FMU3Slave
        interface = self.description.modelExchange if case.exchange else self.description.coSimulation
        self.fmu = kind(
            guid=self.description.guid,
            unzipDirectory=extract(str(fmu), unzipdir=str(folder)),
            modelIdentifier=interface.modelIdentifier,
            instanceName="importer",
        )

    def table(self) -> dict:
        """The result, by name."""
        case, fmu = self.case, self.fmu
        fmu.instantiate(**({"eventModeUsed": case.events, "earlyReturnAllowed": case.early} if case.fmi == 3 else {}))
        if "n" in case.settings:
            self.settings()
        if case.fmi == 2:
            fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        self.rows = []
        (self.exchange if case.exchange else self.steps)()
        fmu.terminate()
        fmu.freeInstance()
        return dict(zip(("time", *case.record), map(list, zip(*self.rows, strict=True)), strict=True))

    def settings(self) -> None:
        wanted = dict(self.case.settings)
        self.fmu.enterConfigurationMode()
        self.fmu.setUInt64([self.variables["n"].valueReference], [wanted.pop("n")])
        self.fmu.exitConfigurationMode()
        for name, values in wanted.items():
            values = values[::-1] if self.mistake == "reversed" else values
            self.fmu.setFloat64([self.variables[name].valueReference], values)

    def get(self, name: str):
        array, _, index = (name, "", "") if name in self.variables else name.removesuffix("]").partition("[")
        variable = self.variables[array]
        getter = getattr(self.fmu, f"get{variable.type}")
        if not index:
            return getter([variable.valueReference])[0]
        return getter([variable.valueReference], self.case.settings.get("n", self.case.balls))[int(index) - 1]

    def record(self, time: float, clocked=None) -> None:
        self.rows.append([time, *(clocked[name] if name in (clocked or ()) else self.get(name) for name in self.names)])

    @property
    def names(self):
        return self.case.record

    def give(self, time: float) -> None:
        """The inputs for what begins at a time (s): linear between their points, after a jump."""
        for name, points in self.case.inputs.items():
            name = name.replace("1", "2") if self.mistake == "element" else name
            times, values = zip(*points, strict=True)
            at = max(index for index, point in enumerate(times) if point <= time)
            later = min(at + 1, len(times) - 1)
            span = times[later] - times[at]
            value = values[at] if not span else values[at] + (time - times[at]) / span * (values[later] - values[at])
            value = values[at] if self.case.exchange else value
            value *= {"sign": -1.0, "kilonewtons": 1e-3}.get(self.mistake, 1.0)
            self.fmu.setReal([self.variables[name].valueReference], [value])

    def steps(self) -> None:
        """Co-simulation, in FMI 3.0 with event mode."""
        case, fmu = self.case, self.fmu
        clocked = {name: self.get(name) for name in case.record if name.startswith(CLOCKED)}
        if case.events:
            self.update(clocked)
        self.record(0.0, clocked)
        for k in range(round(case.stop / case.step)):
            time, end, ticked = k * case.step, (k + 1) * case.step, []
            while time < end:
                self.give(time)
                told = fmu.doStep(time, end - time)
                event, _, early, reached = told or (False, False, False, end)
                time = reached if early else end
                if event:
                    fmu.enterEventMode()
                    self.update(ticked if self.mistake == "queued" else clocked)
            self.record(end, clocked)
            clocked |= dict(ticked)

    def update(self, clocked) -> None:
        """Event Mode to its end, with what belongs to a clock that ticks."""
        again = True
        while again:
            for clock in ("onset.clock", "release.clock"):
                if self.fmu.getClock([self.variables[clock].valueReference])[0]:
                    own = [name for name in self.names if name.startswith(clock.removesuffix("clock"))]
                    read = [(name, self.get(name)) for name in own]
                    clocked.extend(read) if isinstance(clocked, list) else clocked.update(read)
            again = self.fmu.updateDiscreteStates()[0]
        self.fmu.enterStepMode()

    def vector(self, what: str, length: int):
        values = np.zeros(length)
        getattr(self.fmu, what)(values.ctypes.data_as(POINTER(c_double)), length)
        return values

    def at(self, time: float, x) -> None:
        self.fmu.setTime(time)
        self.fmu.setContinuousStates(np.ascontiguousarray(x).ctypes.data_as(POINTER(c_double)), len(x))

    def slopes(self, time: float, x):
        self.at(time, x)
        return self.vector("getDerivatives", len(x))

    def indicators(self, time: float, x):
        self.at(time, x)
        return self.vector("getEventIndicators", self.description.numberOfEventIndicators)

    def moved(self, time: float, x, h: float):
        """Runge and Kutta's step of order 4."""
        k = [self.slopes(time, x)]
        for part in (0.5, 0.5, 1.0):
            k.append(self.slopes(time + part * h, x + part * h * k[-1]))
        weights = (1 / 6, 1 / 2, 1 / 6, 1 / 6) if self.mistake == "weights" else RIGHT
        x = x + h * sum(weight * slope for weight, slope in zip(weights, k, strict=True))
        return x.astype(np.float32).astype(float) if self.mistake == "single" else x

    def length(self, time: float, x, h: float) -> float:
        """At most h (s), so that two halves of a step agree with it."""
        if not self.case.tolerance:
            return h
        half = self.moved(time, x, h / 2)
        error = np.abs(self.moved(time, x, h) - self.moved(time + h / 2, half, h / 2))
        error = (error / self.nominals).max() / self.case.tolerance
        return h if error < 1 or h < 1e-12 else self.length(time, x, h * max(0.2, 0.9 * error**-0.2))

    def discrete(self) -> float:
        """Event Mode to its end: the time of the next event (s)."""
        again = True
        while again:
            again, _, _, _, defined, due = self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()
        return due if defined else math.inf

    def exchange(self) -> None:
        """Model exchange."""
        case, fmu, size = self.case, self.fmu, self.description.numberOfContinuousStates
        jumps = {time for points in case.inputs.values() for time, _ in points}
        self.give(0.0)
        x = self.vector("getContinuousStates", size)
        due = self.discrete()
        x = x if self.mistake == "kept" else self.vector("getContinuousStates", size)
        self.nominals = self.vector("getNominalsOfContinuousStates", size)
        time, longest = 0.0, case.step / case.parts
        z, h = self.indicators(time, x), case.step / case.parts
        self.record(0.0)
        for k in range(round(case.stop / case.step)):
            end = (k + 1) * case.step
            while time < end:
                dated = min([due, *(jump for jump in jumps if jump > time)])
                stop = end if self.mistake == "overrun" else min(end, dated)
                h = self.length(time, x, min(4 * h, longest, stop - time))
                after = self.moved(time, x, h)
                crossed = (z > 0) != (self.indicators(time + h, after) > 0)
                if crossed.any() and self.mistake != "overrun":
                    low, high = 0.0, h
                    while high - low > (1e-6 if self.mistake == "microsecond" else 1e-14):
                        middle = (low + high) / 2
                        if middle in (low, high):
                            break
                        z_middle = self.indicators(time + middle, self.moved(time, x, middle))
                        low, high = (low, middle) if ((z > 0) != (z_middle > 0))[crossed].any() else (middle, high)
                    h, after, stop = high, self.moved(time, x, high), time + high
                x, time = after, stop if stop - time <= h * (1 + 1e-9) else time + h
                z = self.indicators(time, x)
                asked, _ = fmu.completedIntegratorStep()
                if asked or crossed.any() or time >= dated:
                    fmu.enterEventMode()
                    self.give(time)
                    due = self.discrete()
                    x = x if self.mistake == "kept" else self.vector("getContinuousStates", size)
                    z, h = self.indicators(time, x), longest
            self.record(end)
