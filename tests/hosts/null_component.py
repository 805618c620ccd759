"""Calls every function of an FMU's binary on a NULL component and prints `name status` for each.

    python null_component.py FILE.fmu null|valid      (what the other pointers are)

Run by test_bad_input.py in a process of its own, because a careless FMU crashes here.
"""

import ctypes
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))

from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from newtons_cradle import Fmu

NUMBERS = (ctypes.c_int, ctypes.c_uint, ctypes.c_size_t)


def argument(kind, valid: bool):
    """A harmless argument of a ctypes type: 1 for numbers, a buffer or NULL for pointers."""
    if kind in NUMBERS:
        return 1
    if kind is ctypes.c_double:
        return 1.0
    if not valid:
        return None
    if kind is ctypes.c_void_p:
        return ctypes.create_string_buffer(64)
    if kind is ctypes.c_char_p:
        return b"text"
    return (kind._type_ * 8)()


def main() -> None:
    """Goes through the functions FMPy has bound."""
    valid = sys.argv[2] == "valid"
    with Fmu(sys.argv[1]) as fmu:
        slave = FMU2Slave(guid="", modelIdentifier="NewtonsCradle", unzipDirectory=fmu.folder)
        for name, function in slave._functions.items():
            if function.argnames[:1] != ["c"]:
                continue
            arguments = [argument(kind, valid) for kind in function.argtypes[1:]]
            try:
                status = slave._call(name, None, *arguments)
            except FMICallException as error:
                status = error.status
            print(name, status, flush=True)


if __name__ == "__main__":
    main()
