"""Variables as a table: unit, range, default and meaning of each."""

import re
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from ..errors import UnknownName, did_you_mean, optional

if TYPE_CHECKING:
    import pandas as pd


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
