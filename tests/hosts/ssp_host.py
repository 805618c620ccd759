"""Runs an SSP, unpacked, in libcosim or ecos and prints the values at the ends of the steps, as JSON.

    python ssp_host.py libcosim|ecos FOLDER PARAMETER-SET STEP COUNT COMPONENT.VARIABLE ...

Ends with code 77 if the package cannot be imported.
"""

import ctypes
import importlib
import json
import os
import sys
from pathlib import Path

MODULES = {"libcosim": "libcosimpy.CosimExecution", "ecos": "ecospy"}


def by_libcosim(folder: str, _parameter_set: str, step: float, count: int, names: list) -> list:
    """It takes the parameter sets that are bound to components."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_ssp_file(folder, round(step * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places = []
    for component, variable in names:
        slave = execution.slave_index_from_instance_name(component)
        (reference,) = (
            known.reference for known in execution.slave_variables(slave) if known.name.decode() == variable
        )
        places.append((slave, reference))
    rows = []
    for _ in range(count):
        if not execution.step():
            sys.exit("libcosim refuses the step")
        rows.append([observer.last_real_values(slave, [reference])[0] for slave, reference in places])
    return rows


def by_ecos(folder: str, parameter_set: str, step: float, count: int, names: list) -> list:
    """It takes, from those bound to components, the parameter set of the name that it is told."""
    from ecospy import EcosSimulation

    rows = []
    with EcosSimulation(step, ssp_path=folder) as simulation:
        if not simulation.init(parameter_set=parameter_set):
            sys.exit("ecos cannot initialize")
        for _ in range(count):
            simulation.step(1)
            rows.append([simulation.get_real(f"{component}::{variable}") for component, variable in names])
    return rows


def load(host: str) -> None:
    """Loads the libraries of a host, or ends with code 77."""
    threads = Path(sys.prefix) / "lib/libtbb.so.12"  # needed by ecos, and where pip puts it
    try:
        if threads.exists():
            ctypes.CDLL(str(threads), mode=ctypes.RTLD_GLOBAL)
        importlib.import_module(MODULES[host])
    except (ImportError, OSError) as problem:  # OSError: a library that does not fit this machine
        print(problem, file=sys.stderr)
        sys.exit(77)


def main() -> None:
    """Runs the host named first."""
    host, folder, parameter_set, step, count, *names = sys.argv[1:]
    run = {"libcosim": by_libcosim, "ecos": by_ecos}[host]
    parts = [name.split(".", 1) for name in names]
    load(host)
    print(json.dumps(run(folder, parameter_set, float(step), int(count), parts)), flush=True)
    if host == "ecos":
        os._exit(0)  # What ecos has loaded for an FMU in Python now and then crashes when it is unloaded.


if __name__ == "__main__":
    main()
