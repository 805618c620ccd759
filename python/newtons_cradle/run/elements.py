"""The elements of an FMU's arrays, under the names that FMI 2.0 has for them."""

import copy
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from fmpy.model_description import ModelDescription

#: Types of FMI 3.0 that have one in FMI 2.0. Clocks and binaries have none.
TYPES = {"Float64": "Real", "UInt64": "Integer", "Enumeration": "Enumeration", "Boolean": "Boolean"}

#: Causalities of what FMI 2.0 does not have.
OTHERS = ("independent", "structuralParameter")

#: How the descriptions of arrays over contacts end: in FMI 3.0 they have as many elements as there are balls.
OF_LAST_ELEMENT = "; the last element belongs to no contact"


@dataclass(frozen=True)
class Place:
    """Where FMI 3.0 has an element: type of its accessors, value reference, index from 0, length of the array."""

    type: str
    reference: int
    index: int
    length: int


def variables(description: ModelDescription) -> dict[str, Any]:
    """FMPy's descriptions of all variables that FMI 2.0 knows, by name. In FMI 3.0 each element gets one; its reference is a `Place`."""
    if description.fmiVersion.startswith("2."):
        return {variable.name: variable for variable in description.modelVariables}
    kept = [v for v in description.modelVariables if v.type in TYPES and v.causality not in OTHERS]
    known = [v for v in kept if not v.clocks]  # clocks tick in event mode only
    return {element.name: element for variable in known for element in _elements(variable)}


def _elements(variable: Any) -> Iterator[Any]:
    """The variable itself, or those of its elements that belong to something."""
    length = variable.shape[0] if variable.shape else 1
    starts = (variable.start or "").split()
    stored = "Int64" if variable.type == "Enumeration" else variable.type
    meaning = variable.description or ""
    for index in range(length - meaning.endswith(OF_LAST_ELEMENT)):
        element = copy.copy(variable)
        element.name = _name(variable.name, index) if variable.shape else variable.name
        element.type = TYPES[variable.type]
        element.valueReference = Place(stored, variable.valueReference, index, length)
        element.start = starts[index % len(starts)] if starts else None
        element.description = meaning.removesuffix(OF_LAST_ELEMENT)
        if variable.declaredType is not None:
            element.unit = variable.unit or variable.declaredType.unit
        yield element


def _name(array: str, index: int) -> str:
    """x and 0 to x[1], der(x) and 0 to der(x[1])."""
    bare = array.removesuffix(")")
    return f"{bare}[{index + 1}]{array[len(bare) :]}"
