"""The calls that a run makes again and again, prepared once, with arrays and arguments that are reused.

A status above 1 is an error. The methods here return it with the name of the FMI function, or ("", 0) for success.
"""

from collections.abc import Sequence
from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_uint, c_void_p, cast
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import InvalidValue
from ..pulses import Array
from .description import Description, Place

Failure = tuple[str, int]  #: The FMI function that failed, and its status.
FINE: Failure = ("", 0)
WARNING = 1  # the highest status that is no error
KEPT = 200  # groups of variables whose calls are kept

#: For each version, by type of variable: the ending of its getter's and setter's names, and the dtype of its values.
FMI2 = {"Real": ("Real", "f8"), "Integer": ("Integer", "i4"), "Enumeration": ("Integer", "i4")}
FMI2 |= {"Boolean": ("Boolean", "i4")}
FMI3 = {"Real": ("Float64", "f8"), "Integer": ("UInt64", "u8"), "Enumeration": ("Int64", "i8")}
FMI3 |= {"Boolean": ("Boolean", "?")}

LAST_SUCCESSFUL_TIME = 2  # of fmi2GetRealStatus


@dataclass
class Group:
    """Variables of one type, whose values are read and set in one call. `columns`: the index of each variable in the
    values, which have all elements of an array of FMI 3.0. `elements`: of an array, one for each ball."""

    type: str
    elements: int
    references: list[int] = field(default_factory=list)
    columns: dict[str, int] = field(default_factory=dict)
    length: int = 0
    _begins: dict[int, int] = field(default_factory=dict)

    def add(self, name: str, place: Place) -> None:
        """Adds a variable."""
        if place.reference not in self._begins:
            self._begins[place.reference] = self.length
            self.references.append(place.reference)
            self.length += 1 if place.index is None else self.elements
        self.columns[name] = self._begins[place.reference] + (place.index or 0)

    def is_whole(self) -> bool:
        """Whether the variables are all elements of their arrays."""
        return len(self.columns) == self.length


class Call:
    """A group with its getter and setter in one instance, and an array for the values."""

    def __init__(self, calls: "Calls", group: Group):
        self.group, (ending, kind) = group, calls.types[group.type]
        self.values = np.zeros(group.length, dtype=kind)
        self.address = self.values.ctypes.data
        self.names = [f"{calls.prefix}{verb}{ending}" for verb in ("Get", "Set")]
        self.functions = [calls.accessor(name) for name in self.names]
        self.count = len(group.references)
        self._references = (c_uint * self.count)(*group.references)
        self.references = cast(self._references, c_void_p)
        self.tail: tuple[int, ...] = () if calls.fmi2 else (group.length,)
        self.component = calls.component

    def get(self) -> Failure:
        """Reads all values."""
        status = self.functions[0](self.component, self.references, self.count, self.address, *self.tail)
        return FINE if status <= WARNING else (self.names[0], status)

    def set(self) -> Failure:
        """Sets all values."""
        status = self.functions[1](self.component, self.references, self.count, self.address, *self.tail)
        return FINE if status <= WARNING else (self.names[1], status)


class Access:
    """Reads and sets these variables, with one call for each type."""

    def __init__(self, calls: "Calls", names: Sequence[str]):
        groups: dict[Any, Group] = {}
        for name in names:
            place = calls.description.variables.place(name)
            if place.type not in calls.types:
                raise InvalidValue(f"{name} is a {place.type}, which this package does not read; see `run.slave`")
            groups.setdefault(place.type, Group(place.type, calls.balls)).add(name, place)
        self.calls = [Call(calls, group) for group in groups.values()]
        self.where = {
            name: (i, column) for i, call in enumerate(self.calls) for name, column in call.group.columns.items()
        }
        self.names = list(names)

    def read(self) -> Failure:
        """Reads all values; `values` returns them."""
        for call in self.calls:
            failed = call.get()
            if failed[1]:
                return failed
        return FINE

    def values(self) -> list[Any]:
        """The values read last, in the order of the names."""
        return self.listed([call.values for call in self.calls])

    def listed(self, read: Sequence[Array]) -> list[Any]:
        """Values in the order of the names; `read`: an array for each call."""
        lists = [
            values.astype("?").tolist() if call.group.type == "Boolean" else values.tolist()
            for call, values in zip(self.calls, read, strict=True)
        ]
        return [lists[i][column] for i, column in map(self.where.__getitem__, self.names)]

    def write(self, values: Sequence[float]) -> Failure:
        """Sets these values, in the order of the names; other elements of arrays keep theirs."""
        for call in self.calls:
            failed = FINE if call.group.is_whole() else call.get()
            if failed[1]:
                return failed
        for name, value in zip(self.names, values, strict=True):
            i, column = self.where[name]
            try:
                self.calls[i].values[column] = value
            except OverflowError:
                raise InvalidValue(f"{name} = {value} is refused; allowed: numbers that fit into 32 bits") from None
        for call in self.calls:
            failed = call.set()
            if failed[1]:
                return failed
        return FINE


class Calls:
    """The prepared calls of one instance, a `slave` of FMPy."""

    def __init__(self, slave: Any, description: Description):
        self.description, self.fmi2 = description, description.fmi2
        self.prefix, self.types = ("fmi2", FMI2) if self.fmi2 else ("fmi3", FMI3)
        self.component = c_void_p(slave.component)
        self.balls: int = slave.balls  # until `resized`
        self._dll = slave.dll
        self._accesses: dict[tuple[str, ...], Access] = {}
        self._early, self._reached, self._flags = c_bool(), c_double(), (c_bool(), c_bool())
        outcome = () if self.fmi2 else tuple(byref(each) for each in (*self._flags, self._early, self._reached))
        #: The function for a step. All its arguments are C types: the instance, time and length as `c_double`, and this
        #: tail.
        self.step = self._dll[f"{self.prefix}DoStep"]
        self.step_tail: tuple[Any, ...] = (c_int(1) if self.fmi2 else c_bool(True), *outcome)

    def function(self, name: str, *types: Any) -> Any:
        """A function of the FMU. `types`: of all arguments after the instance, because ctypes passes others as variadic
        ones."""
        found = self._dll[name]  # not FMPy's function, which checks its arguments
        found.argtypes, found.restype = [c_void_p, *types], c_int
        return found

    def accessor(self, name: str) -> Any:
        """A function that gets or sets values."""
        length = [] if self.fmi2 else [c_size_t]
        return self.function(name, c_void_p, c_size_t, c_void_p, *length)

    def access(self, names: Sequence[str]) -> Access:
        """The calls for these variables."""
        key = tuple(names)
        if key not in self._accesses:
            if len(self._accesses) >= KEPT:
                self._accesses.clear()
            self._accesses[key] = Access(self, key)
        return self._accesses[key]

    def resized(self, balls: int) -> None:
        """Notes that the instance now has another number of balls."""
        self.balls = balls
        self._accesses.clear()

    def reached(self, end: float) -> float:
        """The time (s) at which the last step, to `end` (s), has ended: in FMI 3.0 perhaps early."""
        return self._reached.value if self._early.value else end

    def time(self, known: float) -> float:
        """The time of the instance, s; `known` if the instance does not tell it."""
        reached = c_double()
        if self.fmi2:
            ask = self.function("fmi2GetRealStatus", c_int, c_void_p)
            status = ask(self.component, LAST_SUCCESSFUL_TIME, byref(reached))
        else:
            reference = c_uint(self.description.described["time"].valueReference)
            status = self.accessor("fmi3GetFloat64")(self.component, byref(reference), 1, byref(reached), 1)
        return reached.value if status <= WARNING else known
