"""An FMU of FMI 3.0 through FMPy's low-level class, with the names of its variables."""

import ctypes
import re
import zipfile
from contextlib import contextmanager

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Model, FMU3Slave, fmi3Boolean, fmi3Float64

TYPES = {
    "Float64": ctypes.c_double,
    "UInt64": ctypes.c_uint64,
    "Int64": ctypes.c_int64,
    "Boolean": ctypes.c_bool,
}


class Cradle(FMU3Slave):
    """One instance. Variables are read and set by name, arrays as NumPy arrays."""

    def __init__(self, folder, description):
        super().__init__(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="cradle",
        )
        self.description = description
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.n = int(self.variables["n"].start)
        self.lines = []

    def start(self, parameters=None, balls=None, begin=0.0, **options):
        """Instantiates and goes through initialization with these parameters, in a cradle of so many balls."""
        self.make(**options)
        if balls is not None:
            self.enterConfigurationMode()
            self.set("n", balls)
            self.exitConfigurationMode()
            self.n = balls
        for name, value in self.arrays(parameters or {}).items():
            self.set(name, value)
        self.enterInitializationMode(startTime=begin)
        self.exitInitializationMode()
        return self

    def arrays(self, parameters):
        """Parameters by the names of FMI 3.0, from those that may have an index; other elements are those of the description."""
        arrays = {}
        for name, value in parameters.items():
            family, index = re.fullmatch(r"(.*?)(?:\[(\d+)])?", name).groups()
            if index is None:
                arrays[name] = value
                continue
            start = [float(text) for text in self.variables[family].start.split()]
            arrays.setdefault(family, start if len(start) == self.n else [start[-1]] * self.n)[
                int(index) - 1
            ] = value
        return arrays

    def make(self, **options):
        """Instantiates with logging; the lines are kept."""

        def log(_environment, status, category, message):
            self.lines.append((status, category.decode(), message.decode()))

        self.instantiate(**{"loggingOn": True, "logMessage": log} | options)
        return self

    def reference(self, *names):
        """Value references."""
        return [self.variables[name].valueReference for name in names]

    def _places(self, name, count):
        kind = self.variables[name].type
        kind = "Int64" if kind == "Enumeration" else kind
        return kind, (TYPES[kind] * count)()

    def get(self, name):
        """The value of a scalar, or the elements of an array."""
        array = bool(self.variables[name].dimensions)
        references = (ctypes.c_uint32 * 1)(*self.reference(name))
        if self.variables[name].type == "Clock":
            clock = (ctypes.c_bool * 1)()
            self.fmi3GetClock(self.component, references, 1, clock)
            return bool(clock[0])
        kind, places = self._places(name, self.n if array else 1)
        getattr(self, f"fmi3Get{kind}")(self.component, references, 1, places, len(places))
        return np.array(places[:]) if array else places[0]

    def csv(self):
        """The pulses of log.pulses: contact, onset, release, peak, impulse."""
        references, size = (ctypes.c_uint32 * 1)(*self.reference("log.pulses")), ctypes.c_size_t()
        data = ctypes.POINTER(ctypes.c_uint8)()
        self.fmi3GetBinary(self.component, references, 1, ctypes.byref(size), ctypes.byref(data), 1)
        assert size.value <= 65536  # maxSize
        header, *lines = ctypes.string_at(data, size.value).decode().splitlines()
        assert header == "contact,onset,release,peak,impulse"
        return [tuple(float(part) for part in line.split(",")) for line in lines]

    def set(self, name, value):
        """Sets a scalar, or all elements of an array; an enumeration also by the name of its item."""
        if isinstance(value, str):
            value = next(item.value for item in self.variables[name].declaredType.items if item.name == value)
        values = np.atleast_1d(int(value) if self.variables[name].type == "Enumeration" else value)
        kind, places = self._places(name, len(values))
        places[:] = values.tolist()
        references = (ctypes.c_uint32 * 1)(*self.reference(name))
        getattr(self, f"fmi3Set{kind}")(self.component, references, 1, places, len(places))

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
            values = [self.get(f"release.{name}") for name in ("impulse", "peak", "duration")]
            told["release"] = (
                self.get("release.time"),
                [(i, *(value[i] for value in values)) for i in which],
            )
        return told

    def events(self):
        """All ticks from Event Mode on to step mode, and when the next event is due."""
        ticks, again = [self.tick()], True
        while again:
            again, due = self.update()
            if again:
                ticks.append(self.tick())
        self.enterStepMode()
        return [tick for tick in ticks if tick], due

    def step(self, time, length):
        """A step: needs events, early, time reached. The raw call, for all of its answers."""
        needed, terminate, early, reached = (fmi3Boolean(), fmi3Boolean(), fmi3Boolean(), fmi3Float64())
        places = map(ctypes.byref, (needed, terminate, early, reached))
        self.fmi3DoStep(self.component, time, length, fmi3Boolean(True), *places)
        assert not terminate.value
        return needed.value, early.value, reached.value

    def derivative(self, kind, unknowns, knowns, seed, length):
        """fmi3GetDirectionalDerivative or fmi3GetAdjointDerivative, by names."""
        lists = [(ctypes.c_uint32 * len(names))(*self.reference(*names)) for names in (unknowns, knowns)]
        seed, found = (ctypes.c_double * len(seed))(*seed), (ctypes.c_double * length)()
        arguments = [part for references in lists for part in (references, len(references))]
        call = getattr(self, f"fmi3Get{kind}Derivative")
        call(self.component, *arguments, seed, len(seed), found, length)
        return np.array(found[:])

    def state(self):
        """The state as bytes."""
        state, size = self.getFMUState(), ctypes.c_size_t()
        self.fmi3SerializedFMUStateSize(self.component, state, ctypes.byref(size))
        data = (ctypes.c_uint8 * size.value)()
        self.fmi3SerializeFMUState(self.component, state, data, size)
        self.freeFMUState(state)
        return bytes(data)

    def go_back(self, data):
        """Back to a state given as bytes."""
        state = ctypes.c_void_p()
        self.fmi3DeserializeFMUState(
            self.component, (ctypes.c_uint8 * len(data))(*data), len(data), ctypes.byref(state)
        )
        self.setFMUState(state)
        self.freeFMUState(state)


def redescribed(path, out, change):
    """An FMU with another description, made of the text by `change`."""
    with zipfile.ZipFile(path) as entries, zipfile.ZipFile(out, "w") as written:
        for name in entries.namelist():
            contents = entries.read(name)
            if name == "modelDescription.xml":
                contents = change(contents.decode()).encode()
            written.writestr(name, contents)
    return out


@contextmanager
def opened(path, tmp):
    """A function that makes instances of the FMU; all of them are freed in the end."""
    folder, made = extract(str(path), unzipdir=str(tmp)), []
    description = read_model_description(folder, validate=False)

    def make():
        made.append(Cradle(folder, description))
        return made[-1]

    yield make
    for cradle in made:
        if cradle.component:
            cradle.freeInstance()


def walk(cradle, time, until):
    """Steps to a time, taking part in every event."""
    told = []
    while time < until:
        needed, early, time = cradle.step(time, until - time)
        assert needed or not early
        if needed:
            cradle.enterEventMode()
            told += cradle.events()[0]
    return told


@contextmanager
def started_exchange(path, tmp, balls, parameters=None):
    """An instance of model exchange with so many balls, in its first Event Mode."""
    folder = extract(str(path), unzipdir=str(tmp))
    description = read_model_description(folder, validate=False)
    cradle = FMU3Model(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="cradle",
    )
    cradle.variables = description.modelVariables
    cradle.instantiate()
    try:
        count = next(variable for variable in cradle.variables if variable.name == "n")
        cradle.enterConfigurationMode()
        cradle.setUInt64([count.valueReference], [balls])
        cradle.exitConfigurationMode()
        for variable in cradle.variables:
            if variable.name in (parameters or {}) and variable.type == "Float64":
                cradle.setFloat64([variable.valueReference], [parameters[variable.name]])
        cradle.enterInitializationMode()
        cradle.exitInitializationMode()
        yield cradle
    finally:
        cradle.freeInstance()


def read(cradle, name, balls):
    """A real array of an instance of model exchange."""
    reference = next(variable.valueReference for variable in cradle.variables if variable.name == name)
    return np.array(cradle.getFloat64([reference], balls))
