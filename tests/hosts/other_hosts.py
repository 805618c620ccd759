"""Runs an FMU, or an SSP that is unpacked, in libcosim or ecos and prints rows, the time (s) first, as JSON.

    python other_hosts.py libcosim|ecos REQUEST

REQUEST is JSON with the arguments of the functions below: the path of the FMU, whose name is then `cradle`, or of the
SSP's folder, names as COMPONENT.VARIABLE, inputs as points in time (s) and value by these names. Ends with code 77 if
the package cannot be imported.
"""

import ctypes
import importlib
import json
import os
import shutil
import sys
from pathlib import Path

import numpy as np

MODULES = {"libcosim": "libcosimpy.CosimExecution", "ecos": "ecospy"}


def is_whole(name: str) -> bool:
    """Whether a variable is an integer."""
    return ".pulses" in name


def by_libcosim(path: str, step: float, count: int, names: list, inputs: dict, parameter_set=None) -> list:
    """It takes the parameter sets that are bound to components, and knows nothing before the first step."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.WARNING)
    step = round(step * 1e9)  # ns
    if path.endswith(".fmu"):
        execution = CosimExecution.from_step_size(step)
        execution.add_local_slave(CosimLocalSlave(path, "cradle"))
    else:
        execution = CosimExecution.from_ssp_file(path, step)
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)

    def place(name: str) -> tuple[int, list[int]]:
        component, variable = name.split(".", 1)
        slave = execution.slave_index_from_instance_name(component)
        known = execution.slave_variables(slave)
        (reference,) = (one.reference for one in known if one.name.decode() == variable)
        return slave, [reference]

    places, rows = {name: place(name) for name in (*names, *inputs)}, []
    for k in range(count):
        for name, points in inputs.items():
            manipulator.slave_real_values(*places[name], [np.interp(k * step / 1e9, *zip(*points, strict=True))])
        if not execution.step():
            sys.exit("libcosim refuses the step")
        reads = [observer.last_integer_values if is_whole(name) else observer.last_real_values for name in names]
        values = [read(*places[name])[0] for read, name in zip(reads, names, strict=True)]
        rows.append([(k + 1) * step / 1e9, *values])
    return rows


def by_ecos(path: str, step: float, count: int, names: list, inputs: dict, parameter_set=None) -> list:
    """It takes, from those bound to components, the parameter set of the name that it is told; with the start."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    given = {"ssp_path": path}
    if path.endswith(".fmu"):
        given = {"structure": EcosSimulationStructure()}
        given["structure"].add_model("cradle", path)
    with EcosSimulation(step, **given) as simulation:
        if not simulation.init(parameter_set=parameter_set):
            sys.exit("ecos cannot initialize")

        def row() -> list[float]:
            reads = [simulation.get_integer if is_whole(name) else simulation.get_real for name in names]
            values = [read(name.replace(".", "::", 1)) for read, name in zip(reads, names, strict=True)]
            return [simulation.get_time(), *values]

        rows = [row()]
        for _ in range(count):
            for name, points in inputs.items():
                value = np.interp(simulation.get_time(), *zip(*points, strict=True))
                simulation.set_real(name.replace(".", "::", 1), value)
            simulation.step(1)
            rows.append(row())
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


def command(host: str, path, **request) -> list:
    """What runs a host in a process of its own."""
    return [sys.executable, __file__, host, json.dumps({"path": str(path), "inputs": {}} | request)]


def container(fmu: Path, folder: Path, step: float, inputs, outputs) -> list:
    """What makes, in this folder, an FMU outer.fmu around another, by the FMU Manipulation Toolbox; its steps (s) are
    the container's."""
    shutil.copy(fmu, folder / "inner.fmu")
    recipe = {
        "name": "outer.fmu",
        "fmu": ["inner.fmu"],
        "step_size": step,
        "input": [[name, "inner.fmu", name] for name in inputs],
        "output": [["inner.fmu", name, name] for name in outputs],
        "auto_input": False,
        "auto_output": False,
    }
    (folder / "outer.json").write_text(json.dumps(recipe))
    return [Path(sys.executable).parent / "fmucontainer", "-container", "outer.json"]


if __name__ == "__main__":
    host = sys.argv[1]
    load(host)
    print(json.dumps({"libcosim": by_libcosim, "ecos": by_ecos}[host](**json.loads(sys.argv[2]))), flush=True)
    if host == "ecos":
        os._exit(0)  # What ecos has loaded for an FMU in Python now and then crashes when it is unloaded.
