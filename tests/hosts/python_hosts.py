"""Runs an FMU in a host that is a Python package, by itself, and prints rows, the time (s) first, as JSON.

    python python_hosts.py HOST REQUEST

REQUEST is JSON with the arguments of the functions below: the path of the FMU, the step (s), the number of steps, and
names of outputs. Ends with code 77 if the package cannot be imported; checkout/requirements/hosts.txt says how to install it.
"""

import contextlib
import importlib
import json
import sys
import tempfile
from pathlib import Path

MODULES = {
    "pathsim": "pathsim_fmi",
    "pathsim-exchange": "pathsim_fmi",
    "cofmupy": "cofmupy",
    "gemseo": "gemseo_fmu",
    "fmuloader": "fmuloader",
    "syssimx": "syssimx",
}


def by_pathsim(path: str, step: float, count: int, names: list) -> list:
    """Co-simulation as a block of PathSim: it reads all outputs after each step."""
    from pathsim import Simulation
    from pathsim_fmi import CoSimulationFMU

    block = CoSimulationFMU(path, dt=step)
    places = [[*block.fmu_wrapper.output_refs].index(name) for name in names]
    simulation = Simulation([block], [], dt=step / 2, log=False)
    rows = []
    for k in range(count + 1):
        values = block.fmu_wrapper.get_outputs_as_array()
        rows.append([k * step, *(float(values[place]) for place in places)])
        simulation.run(step if k else step / 2, reset=False)  # to between the points, where it makes its steps
    return rows


def by_pathsim_exchange(path: str, step: float, count: int, names: list) -> list:
    """Model exchange: PathSim's Dormand and Prince's method, and its search for events."""
    from pathsim import Simulation
    from pathsim.solvers import RKDP54
    from pathsim_fmi import ModelExchangeFMU

    block = ModelExchangeFMU(path)
    places = [[*block.fmu_wrapper.output_refs].index(name) for name in names]
    options = {"Solver": RKDP54, "tolerance_lte_abs": 1e-12, "tolerance_lte_rel": 1e-10}
    simulation = Simulation([block], [], dt=step / 16, dt_max=step, log=False, **options)
    rows = []
    for k in range(count + 1):
        if k:
            simulation.run(step, reset=False, adaptive=True)
        values = block.fmu_wrapper.get_outputs_as_array()
        rows.append([k * step, *(float(values[place]) for place in places)])
    return rows


def by_cofmupy(path: str, step: float, count: int, names: list) -> list:
    """CofmuPy's coordinator with one FMU: it reads all outputs after each step."""
    from cofmupy import Coordinator

    config = {"fmus": [{"id": "cradle", "path": path}], "connections": [], "cosim_method": "jacobi"}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "config.json")
        file.write_text(json.dumps(config | {"root": folder}))
        coordinator = Coordinator()
        coordinator.start(str(file))
        rows = []
        for k in range(count):
            coordinator.do_step(step)
            rows.append([(k + 1) * step, *(coordinator.get_variable(("cradle", name))[0] for name in names)])
    return rows


def by_gemseo(path: str, step: float, count: int, names: list) -> list:
    """GEMSEO's discipline of an FMU; it runs through FMPy's simulation loop."""
    from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline

    options = {
        "input_names": None,
        "output_names": names,
        "initial_time": 0.0,
        "final_time": count * step,
        "time_step": step,
    }
    discipline = FMUDiscipline(path, **options)
    result = discipline.execute()
    time = next(values for name, values in result.items() if name.endswith("time"))
    columns = [time, *(result[name] for name in names)]
    return [[float(value) for value in row] for row in zip(*columns, strict=True)]


def by_fmuloader(path: str, step: float, count: int, names: list) -> list:
    """The loader's calls, in the loop of its README."""
    import re
    import zipfile

    from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
    from fmuloader.fmi3 import Fmi3Slave

    text = zipfile.ZipFile(path).read("modelDescription.xml").decode()
    token = re.search(r'(?:guid|instantiationToken)="([^"]+)"', text)[1]
    references = [int(re.search(rf'name="{re.escape(name)}" valueReference="(\d+)"', text)[1]) for name in names]
    if 'fmiVersion="2' in text:
        slave = Fmi2Slave(path, model_identifier="NewtonsCradle")
        slave.instantiate("one", Fmi2Type.CO_SIMULATION, guid=token)
        slave.setup_experiment(start_time=0.0)
        slave.enter_initialization_mode()
        read = slave.get_real
    else:
        slave = Fmi3Slave(path, model_identifier="NewtonsCradle")
        slave.instantiate_co_simulation("one", instantiation_token=token)
        slave.enter_initialization_mode(start_time=0.0)
        read = slave.get_float64
    slave.exit_initialization_mode()
    rows = [[0.0, *read(references)]]
    for k in range(count):
        slave.do_step(k * step, step)
        rows.append([(k + 1) * step, *read(references)])
    slave.terminate()
    slave.free_instance()
    return rows


def by_syssimx(path: str, step: float, count: int, names: list) -> list:
    """A component of SysSimX."""
    from syssimx.components.fmu import FMUComponent

    component = FMUComponent("cradle", path)
    component.initialize(0.0)

    def row(time: float) -> list:
        values = component.get_outputs()
        return [time, *(float(getattr(values[name], "magnitude", values[name])) for name in names)]

    rows = [row(0.0)]
    for k in range(count):
        component.do_step(k * step, step)
        rows.append(row((k + 1) * step))
    return rows


if __name__ == "__main__":
    host = sys.argv[1]
    try:
        importlib.import_module(MODULES[host])
    except ImportError as problem:
        print(problem, file=sys.stderr)
        sys.exit(77)
    run = globals()[f"by_{host.replace('-', '_')}"]
    with contextlib.redirect_stdout(sys.stderr):
        rows = run(**json.loads(sys.argv[2]))
    print(json.dumps(rows))
