"""An FMU's description: its variables by name and as tables, and checks of values."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidValue, UnknownName, did_you_mean, needed, optional, plain, shown
from ..files import MODEL
from ..markup import html_table
from .description import Description, Variable, Variables, reading

if TYPE_CHECKING:
    import pandas as pd

Value = float | int | bool | str | tuple[Any, str]  #: of a variable; an item by name; a number with a unit
Values = Mapping[str, Any]  #: by name: a `Value`, or for an array a sequence of them

GIVEN = ("parameter", "input")  # what can be set at any time; other causalities only with a start value

PLACING = ("x_start", "v_start", "pendulum.length", "contact.gap")  # beginnings of names that place the balls


def split(name: str) -> tuple[str, int | None]:
    """x[3] as ("x", 3), any other name as (name, None)."""
    match = re.fullmatch(r"(.+)\[(-?\d+)\]", name)
    return (match[1], int(match[2])) if match else (name, None)


def with_unit(value: Any) -> tuple[Any, str | None]:
    """A value such as `(2.6, "um")`, and its unit; any other value, and None."""
    return value if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str) else (value, None)


@dataclass(frozen=True)
class Row:
    """One variable in a table. `range`: which values are allowed; `default`: the start value, an item of an enumeration
    by its name; "" where there is none."""

    name: str
    unit: str
    range: str
    default: str
    text: str

    @classmethod
    def of(cls, described: Variable) -> "Row":
        items = {str(number): name for name, number in described.items.items()}
        low, high = described.min, described.max
        ends = [f"{sign} {end}" for sign, end in ((">=", low), ("<=", high)) if end is not None]
        start = described.start or ""
        unit = "" if described.unit == "1" else described.unit
        allowed = ", ".join(items.values() or ends)
        return cls(described.name, unit, allowed, items.get(start, start), described.description)


class Table(dict[str, Row]):
    """Variables by name: `table["gravity"].unit`. In print, elements of an array share a line if they differ in nothing
    else."""

    def __missing__(self, name: object) -> Variable:
        raise UnknownName(f"{name!r} is no name in this table{did_you_mean(str(name), self)}")

    def to_dataframe(self) -> "pd.DataFrame":
        """As a pandas data frame, index `name`. Raises PackageMissing without pandas."""
        frame: pd.DataFrame = optional("pandas", "data").DataFrame(map(asdict, self.values()))
        return frame.set_index("name")

    def __repr__(self) -> str:
        lines = self._lines()
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)

    def _repr_html_(self) -> str:
        return html_table(*self._lines())

    def _lines(self) -> list[list[str]]:
        """A line for each variable, or for neighbours in an array that differ in their number alone."""
        lines = [["name", "unit", "range", "default", "text"]]
        for row in self.values():
            array, index = split(row.name)
            rest = [row.unit, row.range, row.default, general(row.text, index)]
            if index and lines[-1][0].startswith(f"{array}[") and lines[-1][1:] == rest:
                lines[-1][0] = f"{lines[-1][0].partition(' ')[0]} to [{index}]"
            else:
                lines.append([row.name, *rest])
        return lines


def general(text: str, index: int | None) -> str:
    """The description of an array's element with i and i+1 for the numbers."""
    numbers = {} if index is None else {str(index): "i", str(index + 1): "i+1"}
    return re.sub(r"(?<![\^/.])\b\d+\b", lambda number: numbers.get(number[0], number[0]), text)


class Preset(dict[str, Any]):
    """Start values of a preset, which need no warnings. `preset | others` remembers the names of the `others`."""

    others: frozenset[str] = frozenset()

    def __or__(self, others: dict[str, Any]) -> dict[str, Any]:  # type: ignore[override]
        merged = super().__or__(others)
        if isinstance(others, dict):
            merged = Preset(merged)
            merged.others = self.others | given(others)
        return merged


def given(values: Values) -> frozenset[str]:
    """The names of the values that the user has chosen, without those of a preset."""
    return values.others if isinstance(values, Preset) else frozenset(values)


def concerns(warning: str, names: Iterable[str]) -> bool:
    """Whether values of these names may be the cause of a warning: of one about a parameter without effect, if it is
    among them; of any other, if one of them places balls."""
    about, no_effect = warning.partition(" = ")[0], " has no effect" in warning
    if no_effect:
        return split(about)[0] in {split(name)[0] for name in names}
    return any(name.startswith(PLACING) for name in names)


class Model:
    """The description of an FMU in the file `path`. Arrays of FMI 3.0 have elements with the names and types of 2.0."""

    def __init__(self, path: Path, described: Description):
        self.path, self.described = path, described
        self.fmi2 = described.fmi2

    @property
    def is_cradle(self) -> bool:
        """Whether it is this package's model."""
        return self.described.model == MODEL

    def machines(self) -> list[str]:
        """The platform folders in `binaries`."""
        return []

    @property
    def variables(self) -> Variables:
        """The variables by name."""
        return self.described.variables

    @property
    def arrays(self) -> Mapping[str, Sequence[str]]:
        """The names of the elements by array: x: x[1], x[2], ..."""
        return self.described.variables.arrays

    @cached_property
    def parameters(self) -> Table:
        """The parameters, in the description's order: names with unit, range, default and meaning."""
        return self._table("parameter")

    @cached_property
    def inputs(self) -> Table:
        """The inputs; see `parameters`."""
        return self._table("input")

    @cached_property
    def outputs(self) -> Table:
        """The outputs; see `parameters`."""
        return self._table("output")

    def _table(self, causality: str) -> Table:
        return Table({name: Row.of(self.variables[name]) for name in self.described.variables.named(causality)})

    def __repr__(self) -> str:
        what = f"{self.balls} balls, " if self.balls else ""
        return f"Fmu({self.path.name}: {what}FMI {self.described.version}, {len(self.variables)} variables)"

    @property
    def balls(self) -> int:
        """Number of balls n."""
        return len(self.arrays.get("x", ()))

    def items(self, name: str) -> dict[str, int]:
        """The items of an enumeration and their integers: `items("contact.model")["hertz"]` is 2. Raises UnknownName,
        InvalidValue."""
        if not (items := self.variable(name).items):
            raise InvalidValue(f"{name} is no enumeration: it has no items")
        return dict(items)

    def variable(self, name: str) -> Variable:
        """The variable of this name. Raises UnknownName."""
        needed("name", name, str, "a variable's, such as 'x[1]',")
        try:
            return self.variables[name]
        except KeyError:
            raise UnknownName(self._unknown(name)) from None

    def unit(self, name: str) -> str:
        """Unit of a variable, "" if it has none. Raises UnknownName."""
        return self.variable(name).unit

    def number(self, name: str, value: Any) -> float | int | bool:
        """A value in the type of this variable. An item of an enumeration may be given by name, a number with a unit
        as `(2.6, "um")`. Raises UnknownName, InvalidValue."""
        variable, (value, unit) = self.variable(name), with_unit(plain(value))
        if unit is not None:
            value = self._converted(variable, value, unit)
        if isinstance(value, str) and value in variable.items:
            return variable.items[value]
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise InvalidValue(self._no_number(variable, value)) from None
        except OverflowError:
            raise InvalidValue(f"{name} = {shown(value)} is refused; allowed: numbers up to 1.8e308") from None
        if variable.type == "Real":
            return number
        if not number.is_integer():
            raise InvalidValue(f"{name} = {shown(value)} is refused; allowed: whole numbers")
        return int(number)

    def _no_number(self, variable: Variable, value: Any) -> str:
        name, unit = variable.name, variable.unit
        if variable.items and isinstance(value, str):
            hint = did_you_mean(value, variable.items)
            return f"{name} = {value} is refused; allowed: {', '.join(variable.items)}{hint}"
        cure = f"; give it in {unit}, as one number without the unit, or as (1.0, {unit!r})"
        text = value if isinstance(value, str) else shown(value)
        return f"{name} = {text} is not a number{'' if unit in ('', '1') else cure}"

    def _converted(self, variable: Variable, value: Any, unit: str) -> float:
        """A number in `unit`, converted to the variable's own unit."""
        known = self.described.units.get(variable.unit, {})
        if unit not in known:
            name, units = variable.name, ", ".join(known) if known and variable.unit != "1" else "a number alone"
            raise InvalidValue(f"{name} = ({shown(value)}, {unit!r}) is refused; allowed: {units}")
        factor, offset = known[unit]
        number = self.number(variable.name, value)
        # A factor below 1 is 1 over a power of ten, and 1 / factor is that power exactly.
        return (number - offset) / factor if factor > 1.0 else (number - offset) * (1.0 / factor)

    def built_with(self, name: str) -> float | int | bool:
        """The start value in the description; the integer of an enumeration. Raises UnknownName, InvalidValue if there
        is none."""
        variable = self.variable(name)
        if variable.start is None:
            raise InvalidValue(f"{name} has no start value: the FMU computes it")
        if variable.type == "Boolean":
            return variable.start in ("true", "1")
        with reading(self.described.source):
            return float(variable.start) if variable.type == "Real" else int(variable.start)

    def written(self, name: str, value: float, digits: str = ".6g") -> str:
        """A value of a variable as text, an item of an enumeration by its name."""
        variable = self.variable(name)
        if variable.items:
            return next((item for item, number in variable.items.items() if number == value), str(value))
        return f"{value:{digits}}" if variable.type == "Real" else str(value)

    def names(self, record: Iterable[str]) -> list[str]:
        """These variables; where an array x is named, its elements x[1], x[2], ... Raises UnknownName."""
        if isinstance(record, str) or not isinstance(record, Iterable):
            raise InvalidValue(f"record: a list of names such as ['x[1]'] is needed, not {record!r}")
        found: list[str] = []
        for name in record:
            needed("record", name, str, "a name such as 'x[1]'")
            found += self.elements(name)
        return found

    def recorded(self, record: Iterable[str]) -> tuple[str, ...]:
        """The variables that are recorded, each once; `time` always is. Raises UnknownName, InvalidValue."""
        if not isinstance(record, str) and isinstance(record, Iterable):
            record = [name for name in record if not isinstance(name, str) or name != "time"]
        return tuple(dict.fromkeys(self.names(record)))

    def elements(self, name: str) -> Sequence[str]:
        """The elements of an array, or a variable alone. Raises UnknownName."""
        return self.arrays[name] if name in self.arrays else [self.variable(name).name]

    def settings(self, values: Values) -> dict[str, float | int | bool]:
        """A value for each variable, arrays by element, in the FMU's types. Raises UnknownName or InvalidValue."""
        needed("values", values, Mapping, 'a dict such as {"ball.mass": 0.5}')
        single: dict[str, Any] = {}
        for name, value in values.items():
            needed("values", name, str, "the name of a variable")
            array, index = split(name)
            if index is not None and name not in self.variables:
                last = max(i or 0 for base, i in map(split, values) if base == array)
                raise UnknownName(self._unknown(name, _cure(array, last)))
            elements = self.arrays.get(name)
            self.check_settable(elements[0] if elements else name, name)
            if elements is None:
                single[name] = value
            else:
                single |= self._elements(name, elements, value)
        return {name: self.number(name, value) for name, value in single.items()}

    def _elements(self, name: str, elements: Sequence[str], value: Any) -> dict[str, Any]:
        values = self.listed(name, value)
        if len(values) != len(elements):
            wanted = f"{name} takes {len(elements)} values in {self._shape()}"
            raise InvalidValue(f"{wanted}, not {len(values)}{_cure(name, len(values))}")
        return dict(zip(elements, values, strict=True))

    def listed(self, name: str, value: Any) -> Sequence[Any]:
        """The values of an array's elements, each with its unit, if it has one. Raises InvalidValue."""
        value, unit = with_unit(value)
        try:
            dimensions = np.ndim(value)
        except ValueError:  # lists of different lengths
            dimensions = 2
        if dimensions != 1:
            allowed = f"{name} has {len(self.arrays[name])} elements; allowed: {name}[i], or a list"
            raise InvalidValue(f"{name} = {shown(value)} is refused: {allowed}")
        each: Sequence[Any] = value if unit is None else [(one, unit) for one in value]
        return each

    def check_settable(self, name: str, given: str) -> None:
        """Raises InvalidValue if the FMU computes this variable; `given`: the name that the user gave, perhaps of its
        array."""
        variable = self.variable(name)
        if variable.causality in GIVEN or variable.start is not None:
            return
        array, index = split(given)
        meant = "; allowed: parameters and inputs"
        if f"{array}_start" in self.arrays:
            meant = f"; did you mean {array}_start[{index or 'i'}]?"
        kind = "an output" if variable.causality == "output" else f"a {variable.causality} variable"
        raise InvalidValue(f"{given} is refused: it is {kind}, which the FMU computes{meant}")

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
    """Advice on how to get an FMU with this many elements in arrays over balls."""
    return f"; `nc.build(balls={count})` makes one of {count}" if array.endswith("_start") and count > 0 else ""
