"""An FMU of FMI 3.0, call by call, with the names of its variables."""

import numpy as np

BOTH = {"eventModeUsed": True, "earlyReturnAllowed": True}
RESOLVED, MAPPED = 1, 2  # exchange.contacts


class Cradle:
    """A run of an FMU of FMI 3.0, of so many balls; calls go to its slave. With event mode it goes on to step mode: the
    first ticks are in `told`, the time of the next event in `due`."""

    def __init__(self, fmu, parameters=None, balls=None, initialize=True, **options):
        self.run = fmu.start(initialize=False, **options)
        self.lines = self.run.log
        if balls is not None:
            self.resize(balls)
        self.run.set(parameters or {})
        if initialize:
            self.run.initialize()
        if options.get("eventModeUsed"):
            self.told, self.due = self.events()

    def __getattr__(self, name):
        return getattr(self.run.slave, name)

    def derivative(self, kind, unknowns, knowns, seed, length):
        """The directional or adjoint derivative, by names."""
        call = getattr(self, f"get{kind}Derivative")
        return np.array(call(self.references(*unknowns), self.references(*knowns), list(seed), length))

    def csv(self):
        """The pulses of log.pulses: contact, onset, release, peak, impulse, peakTime."""
        (data,) = self.getBinary(self.references("log.pulses"))
        assert len(data) <= 65536  # maxSize
        header, *lines = data.decode().splitlines()
        assert header == "contact,onset,release,peak,impulse,peakTime"
        return [tuple(float(part) for part in line.split(",")) for line in lines]

    def update(self):
        """UpdateDiscreteStates: whether it is to be called again, and when the next event is due."""
        again, _, _, _, defined, time = self.updateDiscreteStates()
        return again, time if defined else None

    def tick(self):
        """The active clocks with their variables."""
        told = {}
        if self.get("onset.clock"):
            told["onset"] = (self.get("onset.time"), tuple(np.flatnonzero(self.get("onset.closed"))))
        if self.get("release.clock"):
            which = np.flatnonzero(self.get("release.opened"))
            values = [self.get(f"release.{name}") for name in ("impulse", "peak", "peakTime", "duration")]
            ended = [(i, *(value[i] for value in values)) for i in which]
            told["release"] = (self.get("release.time"), ended)
        return told

    def events(self):
        """All ticks from Event Mode on to step mode, and when the next event is due."""
        ticks, again = [], True
        while again:
            ticks.append(self.tick())
            again, due = self.update()
        self.enterStepMode()
        return [tick for tick in ticks if tick], due

    def step(self, time, length):
        """A step: needs events, early, time reached."""
        needed, terminate, early, reached = self.doStep(time, length)
        assert not terminate
        return needed, early, reached

    def walk(self, time, until):
        """Steps to a time, taking part in every event; the ticks."""
        told = []
        while time < until:
            needed, early, time = self.step(time, until - time)
            assert needed or not early
            if needed:
                self.enterEventMode()
                told += self.events()[0]
        return told
