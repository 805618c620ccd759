"""The modelDescription.xml of an FMU, read only where it is asked for: 10,000 balls are 250,000 variables in FMI 2.0,
100 MB.

Both versions give their variables the same names and types. An array of FMI 3.0 has elements, `x[1]`, as in FMI 2.0.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from html import unescape
from typing import Any
from xml.etree import ElementTree

from ..errors import FmuError

#: Types of FMI 3.0 that have one in FMI 2.0. Clocks and binaries have none.
TYPES = {"Float64": "Real", "UInt64": "Integer", "Enumeration": "Enumeration", "Boolean": "Boolean"}

#: Causalities of variables that the cradle has in FMI 3.0 only.
OTHERS = ("independent", "structuralParameter")

#: How the description of an array over contacts ends: in FMI 3.0 it has an element for each ball.
OF_LAST_ELEMENT = "; the last element belongs to no contact"

_NAME = re.compile(rb'<ScalarVariable name="([^"]*)"')
_CAUSALITY = re.compile(rb'[^<]*?\scausality="(\w+)"')
_PLACE = re.compile(rb'name="[^"]*" valueReference="(\d+)"[^<]*<(\w+)')


@contextmanager
def reading(source: object) -> Iterator[None]:
    """Turns errors of parsing into FmuError."""
    try:
        yield
    except (ElementTree.ParseError, ValueError, LookupError) as problem:
        raise FmuError(f"{source} is not an FMU that can be read: its modelDescription.xml: {problem}") from problem


@dataclass(frozen=True)
class Declared:
    """A type that variables share: unit, range, and the items of an enumeration with their integers."""

    unit: str | None
    min: str | None
    max: str | None
    items: dict[str, int]


NOTHING_DECLARED = Declared(None, None, None, {})


@dataclass(frozen=True)
class Variable:
    """One variable as it is described, with what its type declares. `index`: of an array's element in FMI 3.0, from 0;
    `length`: of a whole array, else 0."""

    name: str
    type: str
    valueReference: int
    causality: str
    variability: str
    description: str
    unit: str
    min: str | None
    max: str | None
    start: str | None
    items: Mapping[str, int]
    index: int | None = None
    length: int = 0
    clocks: str | None = None

    @property
    def is_real_input(self) -> bool:
        return self.type == "Real" and self.causality == "input"


@dataclass(frozen=True)
class Place:
    """Where a value is read and set: by its type and reference, in an array of FMI 3.0 also by its index, from 0."""

    type: str
    reference: int
    index: int | None = None


class Description:
    """The content of the modelDescription.xml of the FMU `source`. Its members raise FmuError where the text is
    damaged."""

    def __init__(self, text: bytes, source: object):
        self.source = source
        begin, last = text.find(b"<ModelVariables"), text.find(b"</ModelVariables")
        end = text.find(b">", last) + 1
        with reading(source):
            if not 0 <= begin < last < end:
                raise ValueError("it has no ModelVariables")
            structure = text.find(b"<ModelStructure", end)
            after = b"</fmiModelDescription>" if structure > 0 else text[end:]
            self.root = ElementTree.fromstring(text[:begin] + after)
        found = self.root.get
        self.version, self.model = found("fmiVersion", ""), found("modelName", "")
        self.token = found("guid" if self.fmi2 else "instantiationToken", "")
        self.identifiers = {kind.tag: kind.get("modelIdentifier", "") for kind in self.root}
        self._variables = text[begin:end]

    @property
    def fmi2(self) -> bool:
        return self.version.startswith("2.")

    @cached_property
    def types(self) -> dict[str, Declared]:
        """The declared types by name."""
        found = {}
        with reading(self.source):
            for declared in self.root.iterfind("TypeDefinitions/*"):
                of = declared[0] if self.fmi2 and len(declared) else declared
                items = {item.get("name", ""): int(item.get("value", "0")) for item in of.iterfind("Item")}
                found[declared.get("name", "")] = Declared(of.get("unit"), of.get("min"), of.get("max"), items)
        return found

    @cached_property
    def units(self) -> dict[str, dict[str, tuple[float, float]]]:
        """By unit, its display units with factor and offset: shown = factor * value + offset."""
        found = {}
        with reading(self.source):
            for unit in self.root.iterfind("UnitDefinitions/Unit"):
                shown = {of.get("name", ""): of for of in unit.iterfind("DisplayUnit")}
                ways = {
                    name: (float(of.get("factor", "1")), float(of.get("offset", "0"))) for name, of in shown.items()
                }
                found[unit.get("name", "")] = {unit.get("name", ""): (1.0, 0.0)} | ways
        return found

    @cached_property
    def variables(self) -> "Variables":
        """The variables that both versions have, arrays by element."""
        with reading(self.source):
            return _Scalars(self, self._variables) if self.fmi2 else _Elements(self)

    @cached_property
    def described(self) -> Mapping[str, Variable]:
        """All variables as they stand in the description, arrays as a whole."""
        if self.fmi2:
            return self.variables
        with reading(self.source):
            section = ElementTree.fromstring(self._variables)
            starts = {found.get("valueReference"): found.get("start", "1") for found in section}
            return {found.get("name", ""): self._whole(found, starts) for found in section if found.get("name")}

    def _whole(self, found: ElementTree.Element, starts: Mapping[str | None, str]) -> Variable:
        length = 0
        for dimension in found.iterfind("Dimension"):
            length = int(dimension.get("start") or starts[dimension.get("valueReference")])
        return self.variable(found, found, TYPES.get(found.tag, found.tag), length)

    def variable(self, named: ElementTree.Element, typed: ElementTree.Element, kind: str, length: int = 0) -> Variable:
        """A variable from the XML elements that have its name and its type."""
        declared = self.types.get(typed.get("declaredType", ""), NOTHING_DECLARED)
        return Variable(
            named.get("name", ""),
            kind,
            int(named.get("valueReference", "0")),
            named.get("causality", "local"),
            named.get("variability", "continuous"),
            named.get("description", ""),
            typed.get("unit") or declared.unit or "",
            typed.get("min") or declared.min,
            typed.get("max") or declared.max,
            typed.get("start"),
            declared.items,
            length=length,
            clocks=named.get("clocks"),
        )


class Variables(Mapping[str, Variable]):
    """Variables by name, in the order of the description, each made when it is asked for."""

    #: Names of the elements by array: x: x[1], x[2], ...
    arrays: Mapping[str, Sequence[str]]

    def named(self, *causalities: str) -> list[str]:
        """The names of the variables of these causalities."""
        raise NotImplementedError

    def place(self, name: str) -> Place:
        """Where this variable is read and set. Raises KeyError."""
        found = self[name]
        return Place(found.type, found.valueReference, found.index)


class _Scalars(Variables):
    """The variables of FMI 2.0, each parsed from its place in the text."""

    def __init__(self, description: Description, section: bytes):
        self._description, self._made = description, dict[str, Variable]()
        names = _NAME.findall(section)
        if len(names) != section.count(b"<ScalarVariable") or b"<!--" in section:
            # Not formatted as `cradle-fmu` writes it: parse it, and format it so.
            read = map(_name_first, ElementTree.fromstring(section).iterfind("ScalarVariable"))
            section = b"\n".join(read)
            names = _NAME.findall(section)
        text = b"\n".join(names).decode("utf-8", "replace")
        names = (unescape(text) if "&" in text else text).split("\n") if names else []
        self._texts = dict(zip(names, section.split(b"<ScalarVariable ")[1:], strict=True))

    def __iter__(self) -> Iterator[str]:
        return iter(self._texts)

    def __len__(self) -> int:
        return len(self._texts)

    def __contains__(self, name: object) -> bool:
        return name in self._texts

    def __getitem__(self, name: str) -> Variable:
        if name not in self._made:
            text, end, _ = self._texts[name].partition(b"</ScalarVariable>")
            with reading(self._description.source):
                named = ElementTree.fromstring(b"<ScalarVariable " + text + (end or b"</ScalarVariable>"))
                typed = next((part for part in named if part.tag != "Annotations"), named)
                self._made[name] = self._description.variable(named, typed, typed.tag)
        return self._made[name]

    def named(self, *causalities: str) -> list[str]:
        found = ((name, _CAUSALITY.match(text)) for name, text in self._texts.items())
        return [name for name, match in found if (match[1].decode() if match else "local") in causalities]

    def place(self, name: str) -> Place:
        found = _PLACE.match(self._texts[name])
        return Place(found[2].decode(), int(found[1])) if found else super().place(name)

    @cached_property
    def arrays(self) -> Mapping[str, Sequence[str]]:  # type: ignore[override]
        found: dict[str, list[str]] = {}
        for name in self._texts:
            if name.endswith("]"):
                found.setdefault(name.partition("[")[0], []).append(name)
        return found


def _name_first(variable: ElementTree.Element) -> bytes:
    """The text of a variable as `cradle-fmu` writes it."""
    variable.attrib = {"name": variable.get("name", "")} | variable.attrib
    return ElementTree.tostring(variable)


@dataclass(frozen=True)
class Names(Sequence[str]):
    """The names of an array's elements: x[1], x[2], ..., der(x[1])."""

    array: str
    many: int

    def __len__(self) -> int:
        return self.many

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(self.many))]
        if not -self.many <= index < self.many:
            raise IndexError(index)
        bare, end, _ = self.array.partition(")")
        return f"{bare}[{index % self.many + 1}]{end}"

    def index(self, name: str, *_: Any) -> int:
        digits = name[name.rfind("[") + 1 :].partition("]")[0]
        place = int(digits) - 1 if digits.isdecimal() and digits[0] != "0" else -1
        if 0 <= place < self.many and self[place] == name:
            return place
        raise ValueError(name)


class _Elements(Variables):
    """The variables of FMI 3.0 that FMI 2.0 has, too, arrays by element."""

    def __init__(self, description: Description):
        self._made: dict[str, Variable] = {}
        # Variables of clocks can be read in event mode only.
        self._wholes = {
            whole.name: whole
            for whole in description.described.values()
            if whole.type in TYPES.values() and whole.causality not in OTHERS and not whole.clocks
        }
        self._elements = {
            whole.name: Names(whole.name, whole.length - whole.description.endswith(OF_LAST_ELEMENT))
            for whole in self._wholes.values()
            if whole.length
        }
        #: As in FMI 2.0, where `der(x[1])` is no element of an array, and scalars may have names of elements.
        self.arrays = {name: names for name, names in self._elements.items() if not name.endswith(")") and len(names)}
        scalars: dict[str, list[str]] = {}
        for name in self._wholes:
            if name.endswith("]"):
                scalars.setdefault(name.partition("[")[0], []).append(name)
        self.arrays |= scalars

    def __iter__(self) -> Iterator[str]:
        for name in self._wholes:
            yield from self._elements.get(name, (name,))

    def __len__(self) -> int:
        return sum(len(self._elements.get(name, (name,))) for name in self._wholes)

    def __contains__(self, name: object) -> bool:
        try:
            return isinstance(name, str) and bool(self[name])
        except KeyError:
            return False

    def __getitem__(self, name: str) -> Variable:
        if name not in self._made:
            self._made[name] = self._make(name)
        return self._made[name]

    def _make(self, name: str) -> Variable:
        whole, index = self._located(name)
        if index is None:
            return whole
        starts = (whole.start or "").split()
        start = starts[index % len(starts)] if starts else None
        meaning = whole.description.removesuffix(OF_LAST_ELEMENT)
        return replace(whole, name=name, start=start, description=meaning, index=index, length=0)

    def _located(self, name: str) -> tuple[Variable, int | None]:
        """A scalar and None, or an element's array and its index. Raises KeyError."""
        if name in self._wholes and name not in self._elements:
            return self._wholes[name], None
        bare, _, end = name.rpartition("[")
        array = bare + end.partition("]")[2]
        if array not in self._elements:
            raise KeyError(name)
        try:
            return self._wholes[array], self._elements[array].index(name)
        except ValueError:
            raise KeyError(name) from None

    def place(self, name: str) -> Place:
        whole, index = self._located(name)
        return Place(whole.type, whole.valueReference, index)

    def named(self, *causalities: str) -> list[str]:
        wanted = (name for name, whole in self._wholes.items() if whole.causality in causalities)
        return [element for name in wanted for element in self._elements.get(name, (name,))]
