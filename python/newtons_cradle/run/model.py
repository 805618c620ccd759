"""An FMU's description: its variables by name and as tables, and checks of values."""

import copy
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from fmpy.model_description import ModelDescription

from ..errors import FmuError, InvalidValue, UnknownName, did_you_mean, needed, optional

if TYPE_CHECKING:
    import pandas as pd

Value = float | int | bool | str  #: of a variable; an item of an enumeration may be named
Values = Mapping[str, Any]  #: by name: a `Value`, or for an array a sequence of them

GIVEN = ("parameter", "input")  # what can be set at any time; other causalities only with a start value

#: Types of FMI 3.0 that have one in FMI 2.0. Clocks and binaries have none.
TYPES = {"Float64": "Real", "UInt64": "Integer", "Enumeration": "Enumeration", "Boolean": "Boolean"}

#: Causalities of what FMI 2.0 does not have.
OTHERS = ("independent", "structuralParameter")

#: How the descriptions of arrays over contacts end: in FMI 3.0 they have as many elements as there are balls.
OF_LAST_ELEMENT = "; the last element belongs to no contact"

PLACING = ("x_start", "v_start", "pendulum.length", "contact.gap")  # how names begin that place the balls


def split(name: str) -> tuple[str, int | None]:
    """x[3] as ("x", 3), any other name as (name, None)."""
    match = re.fullmatch(r"(.+)\[(-?\d+)\]", name)
    return (match[1], int(match[2])) if match else (name, None)


@dataclass(frozen=True)
class Variable:
    """One variable. `range`: which values are allowed; `default`: the start value, an item of an enumeration by its
    name; "" where there is none."""

    name: str
    unit: str
    range: str
    default: str
    text: str

    @classmethod
    def of(cls, described: Any) -> "Variable":
        """From FMPy's description."""
        declared = described.declaredType
        items = {str(item.value): item.name for item in (declared and declared.items) or ()}
        low, high = (getattr(described, end, None) or getattr(declared, end, None) for end in ("min", "max"))
        ends = [f"{sign} {end}" for sign, end in ((">=", low), ("<=", high)) if end is not None]
        start = "" if described.start is None else str(described.start)
        return cls(
            described.name,
            "" if described.unit in (None, "1") else described.unit,
            ", ".join(items.values() or ends),
            items.get(start, start),
            described.description or "",
        )


class Table(dict[str, Variable]):
    """Variables by name: `table["gravity"].unit`. Printed, elements of an array that are alike share a line."""

    def __missing__(self, name: object) -> Variable:
        raise UnknownName(f"{name!r} is no name in this table{did_you_mean(str(name), self)}")

    def to_dataframe(self) -> "pd.DataFrame":
        """As a pandas data frame, index `name`. Raises PackageMissing without pandas."""
        frame: pd.DataFrame = optional("pandas", "data").DataFrame(map(asdict, self.values()))
        return frame.set_index("name")

    def __repr__(self) -> str:
        """A line for each variable, or for neighbours in an array that differ in their number alone."""
        lines = [["name", "unit", "range", "default", "text"]]
        for row in self.values():
            array, index = split(row.name)
            rest = [row.unit, row.range, row.default, general(row.text, index)]
            if index and lines[-1][0].startswith(f"{array}[") and lines[-1][1:] == rest:
                lines[-1][0] = f"{lines[-1][0].partition(' ')[0]} to [{index}]"
            else:
                lines.append([row.name, *rest])
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)


def general(text: str, index: int | None) -> str:
    """The description of an array's element with i and i+1 for the numbers."""
    numbers = {} if index is None else {str(index): "i", str(index + 1): "i+1"}
    return re.sub(r"\b\d+\b", lambda number: numbers.get(number[0], number[0]), text)


class Preset(dict[str, Any]):
    """Start values of a preset, which are meant; `preset | others` places the balls as `others` do, if they do."""

    def __or__(self, others: dict[str, Any]) -> dict[str, Any]:  # type: ignore[override]
        merged = super().__or__(others)
        return Preset(merged) if isinstance(others, dict) and meant(others) else merged


def meant(values: Values) -> bool:
    """Whether nothing is doubtful in these values: the balls stay where a preset, or the FMU's maker, placed them."""
    return isinstance(values, Preset) or not any(name.startswith(PLACING) for name in values)


class Model:
    """The description of an FMU, unpacked into `folder`. Arrays of FMI 3.0 have elements with the names and types of
    2.0."""

    def __init__(self, path: Path, description: ModelDescription, folder: str):
        self.path, self.description, self.folder = path, description, folder
        self.fmi2 = description.fmiVersion.startswith("2.")
        self.described = {variable.name: variable for variable in description.modelVariables}
        self.variables = self.described if self.fmi2 else elements(description)
        self.arrays: dict[str, list[str]] = {}  # x: x[1], x[2], ...
        for name in self.variables:
            if name.endswith("]"):
                self.arrays.setdefault(name.partition("[")[0], []).append(name)

        #: What there is to set and to see, in the description's order: names with unit, range, default and meaning.
        self.parameters, self.inputs, self.outputs = (
            Table({v.name: Variable.of(v) for v in self.variables.values() if v.causality == kind})
            for kind in ("parameter", "input", "output")
        )

    def __repr__(self) -> str:
        what = f"{self.balls} balls, " if self.balls else ""
        return f"Fmu({self.path.name}: {what}FMI {self.description.fmiVersion}, {len(self.variables)} variables)"

    @property
    def balls(self) -> int:
        """Number of balls n."""
        return len(self.arrays.get("x", []))

    def items(self, name: str) -> dict[str, int]:
        """The items of an enumeration and their integers: `items("contact.model")["hertz"]` is 2. Raises UnknownName,
        FmuError."""
        declared = self.variable(name).declaredType
        if not declared or not declared.items:
            raise FmuError(f"{name} is no enumeration: it has no items")
        return {item.name: int(item.value) for item in declared.items}

    def variable(self, name: str) -> Any:
        """FMPy's description of one variable. Raises UnknownName."""
        needed("name", name, str, "a variable's, such as 'x[1]',")
        if name not in self.variables:
            raise UnknownName(self._unknown(name))
        return self.variables[name]

    def unit(self, name: str) -> str:
        """Unit of a variable, "" if it has none. Raises UnknownName."""
        return self.variable(name).unit or ""

    def number(self, name: str, value: Value) -> float | int | bool:
        """A value in the type of this variable; an item of an enumeration may be given by name. Raises FmuError."""
        kind = self.variable(name).type
        try:
            if kind == "Enumeration" and isinstance(value, str):
                return self.items(name)[value]
            number = float(value)
            if kind != "Real" and not number.is_integer():
                raise FmuError(f"{name} = {value} is refused; allowed: whole numbers")
            return number if kind == "Real" else int(number)
        except KeyError:
            items = self.items(name)
            hint = did_you_mean(str(value), items)
            raise FmuError(f"{name} = {value} is refused; allowed: {', '.join(items)}{hint}") from None
        except (TypeError, ValueError):
            unit = self.unit(name) if isinstance(value, (str, tuple, list)) else ""
            cure = "" if unit in ("", "1") else f"; give it in {unit}, as one number without the unit"
            raise FmuError(f"{name} = {value} is not a number{cure}") from None

    def built_with(self, name: str) -> float | int | bool:
        """The start value in the description; the integer of an enumeration. Raises UnknownName, FmuError if there is
        none."""
        variable = self.variable(name)
        if variable.start is None:
            raise FmuError(f"{name} has no start value: the FMU computes it")
        if variable.type == "Boolean":
            return variable.start in ("true", "1", True)
        return float(variable.start) if variable.type == "Real" else int(variable.start)

    def written(self, name: str, value: float, digits: str = ".6g") -> str:
        """A value of a variable as text, an item of an enumeration by its name."""
        kind = self.variable(name).type
        if kind == "Enumeration":
            return next(item for item, number in self.items(name).items() if number == value)
        return f"{value:{digits}}" if kind == "Real" else str(value)

    def names(self, record: Iterable[str]) -> list[str]:
        """These variables; where an array x is named, its elements x[1], x[2], ... Raises UnknownName."""
        if isinstance(record, str) or not isinstance(record, Iterable):
            raise InvalidValue(f"record: a list of names such as ['x[1]'] is needed, not {record!r}")
        found: list[str] = []
        for name in record:
            needed("record", name, str, "a name such as 'x[1]'")
            found += self.arrays[name] if name in self.arrays else [self.variable(name).name]
        return found

    def settings(self, values: Values) -> dict[str, float | int | bool]:
        """A value for each variable, arrays by element, in the FMU's types. Raises UnknownName or FmuError."""
        needed("values", values, Mapping, 'a dict such as {"ball.mass": 0.5}')
        single: dict[str, Any] = {}
        for name, value in values.items():
            needed("values", name, str, "the name of a variable")
            array, index = split(name)
            if index is not None and name not in self.variables:
                last = max(i or 0 for base, i in map(split, values) if base == array)
                raise UnknownName(self._unknown(name, _cure(array, last)))
            elements = self.arrays.get(name)
            self._check_settable(elements[0] if elements else name, name)
            single |= {name: value} if elements is None else self._elements(name, value)
        return {name: self.number(name, value) for name, value in single.items()}

    def _elements(self, name: str, value: Any) -> dict[str, Any]:
        elements = self.arrays[name]
        if np.ndim(value) != 1:
            allowed = f"{name} has {len(elements)} elements; allowed: {name}[i], or a list"
            raise FmuError(f"{name} = {value} is refused: {allowed}")
        if len(value) != len(elements):
            needed = f"{name} takes {len(elements)} values in {self._shape()}"
            raise FmuError(f"{needed}, not {len(value)}{_cure(name, len(value))}")
        return dict(zip(elements, value, strict=True))

    def _check_settable(self, name: str, shown: str) -> None:
        variable = self.variable(name)
        if variable.causality in GIVEN or variable.start is not None:
            return
        array, index = split(shown)
        meant = "; allowed: parameters and inputs"
        if f"{array}_start" in self.arrays:
            meant = f"; did you mean {array}_start[{index or 'i'}]?"
        kind = "an output" if variable.causality == "output" else f"a {variable.causality} variable"
        raise FmuError(f"{shown} is refused: it is {kind}, which the FMU computes{meant}")

    def _shape(self) -> str:
        return f"{self.path.name}, a cradle of {self.balls} balls" if self.balls else self.path.name

    def _unknown(self, name: str, cure: str = "") -> str:
        array, index = split(name)
        if array in self.arrays:
            last = len(self.arrays[array])
            if index is None:
                return f"{name} is an array: a single variable is {name}[i], i from 1 to {last}"
            return f"{name} is refused: {array}[1] to {array}[{last}] are in {self._shape()}{cure}"
        known = [*(f"{array}[i]" for array in self.arrays), *(v for v in self.variables if v[-1] != "]")]
        hint = did_you_mean(array if index is None else f"{array}[i]", known)
        return f"{self.path.name} has no variable {name!r}{hint}"


def _cure(array: str, count: int) -> str:
    """Advice how to get an FMU with this many elements in arrays over balls."""
    return f"; `nc.build(balls={count})` makes one of {count}" if array.endswith("_start") and count > 0 else ""


Place = tuple[str, int]  #: Where FMI 3.0 has an element: the name of its array, and its index from 0.


def elements(description: ModelDescription) -> dict[str, Any]:
    """Of FMI 3.0, FMPy's descriptions of all variables that FMI 2.0 knows, by name. Each element gets one; its
    reference is a `Place`."""
    known = [v for v in description.modelVariables if v.type in TYPES and v.causality not in OTHERS]
    # Clocks tick in event mode only.
    return {element.name: element for v in known if not v.clocks for element in _elements(v)}


def _elements(variable: Any) -> Iterator[Any]:
    """The variable itself, or its elements that belong to a ball or contact."""
    length = variable.shape[0] if variable.shape else 1
    starts = (variable.start or "").split()
    meaning = variable.description or ""
    bare, end, _ = variable.name.partition(")")  # der(x) has der(x[1])
    for index in range(length - meaning.endswith(OF_LAST_ELEMENT)):
        element = copy.copy(variable)
        element.name = f"{bare}[{index + 1}]{end}" if variable.shape else variable.name
        element.type = TYPES[variable.type]
        element.valueReference = variable.name, index
        element.start = starts[index % len(starts)] if starts else None
        element.description = meaning.removesuffix(OF_LAST_ELEMENT)
        if variable.declaredType is not None:
            element.unit = variable.unit or variable.declaredType.unit
        yield element
