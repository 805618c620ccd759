"""System structures (SSP 1.0): the machine of this example, and the cradle alone with its presets.

FMPy's runner ignores the parameter bindings of an SSP, starts every connector at 0, and steps the FMUs side by side. So
the parameter set is read from the SSP and passed to it. Other tools read the bindings themselves, some only the
bindings of a component. So the cradle's parameters are bound both to the system and to the component. All are numbers:
some tools cannot set an enumeration, and others silently ignore it. Enumerations keep the values that the FMU was built
with.
"""

import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv
from lxml import etree
from lxml.builder import ElementMaker
from machine import CRADLE, STOP, Fmus, nc

NAMESPACES = {
    prefix: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for prefix, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}
SSD, SSC, SSV = (ElementMaker(namespace=space, nsmap=NAMESPACES) for space in NAMESPACES.values())
TO_PLANT = {  # cradle's output: plant's input
    "F_support_mean": "F_support",
    "v[1]": "v_coil",
    "F_mean[4]": "F_sensor",
    "pulses[4]": "pulses",
}
TO_CRADLE = {"a_mean": "a_support", "F_coil_mean": "F_ext[1]"}  # plant's output: cradle's input
SHOWN = ["p_total", *(f"x[{i}]" for i in range(1, 6))]  # outputs of the cradle that are not connected
SHOWN_PLANT = ["s", "v", "sensed", "impacts"]
PRESETS = {"default": {}, "figure5_overlapping": nc.figure5(0.0)}
# Presets that need no other enumerations than the FMU was built with.
PRESETS |= {name: nc.preset(name) for name in ("textbook", "figure5", "figure6")}


def save_machine(path: Path, fmus: Fmus) -> None:
    """The cradle and its plant, connected."""
    cradle = component("cradle", fmus.cradle, [*TO_PLANT, *TO_CRADLE.values(), *SHOWN], "start")
    plant = component("plant", fmus.plant, [*TO_PLANT.values(), *TO_CRADLE, *SHOWN_PLANT])
    lines = [
        SSD.Connection(startElement=of, startConnector=start, endElement=to, endConnector=end)
        for of, to, names in (("cradle", "plant", TO_PLANT), ("plant", "cradle", TO_CRADLE))
        for start, end in names.items()
    ]
    files = {"SystemStructure.ssd": system("Machine", fmus, [cradle, plant], "start", STOP, SSD.Connections(*lines))}
    files |= parameter_sets("start", CRADLE, fmus.cradle)
    write(path, files, [fmus.cradle.path, fmus.plant.path])


def save_presets(path: Path, fmus: Fmus) -> None:
    """The cradle alone: SystemStructure.ssd with the default values, and an .ssd and an .ssv for each preset.

    It has no connectors of inputs, which stay 0: FMPy's runner wants them all connected.
    """
    files = {}
    for preset, values in PRESETS.items():
        elements = [component("cradle", fmus.cradle, fmus.cradle.outputs, preset)]
        name = "SystemStructure" if preset == "default" else preset
        files[f"{name}.ssd"] = system(preset, fmus, elements, preset, 10.0)
        files |= parameter_sets(preset, values, fmus.cradle)
    write(path, files, [fmus.cradle.path])


def run(path: Path, h: float, values: dict | None = None) -> np.ndarray:
    """FMPy's result for a machine, with steps of h (s); each row is at the end of its step.

    `values`: start values in addition to those of the SSP, such as {"plant.damping": 0.0}.
    """
    start = read_ssv(path, "resources/start.ssv")
    for name, value in (values or {}).items():
        start.parameters.append(SimpleNamespace(name=name, value=value))  # FMPy's runner reads only name and value
    result = simulate_ssp(path, stop_time=STOP - 0.5 * h, step_size=h, parameter_set=start)
    result["time"] = h * np.arange(1, len(result) + 1)  # FMPy writes the start of the step
    return result


def unit_of(variable) -> dict:
    """The attribute `unit` of a value, if the variable has one."""
    return {"unit": variable.unit} if variable.unit else {}


def component(name: str, fmu: nc.Fmu, shown: list[str], parameter_set: str | None = None):
    """A component with connectors for these variables; its FMU is in the folder resources. Its parameter set is named
    after the system's set and the component."""
    source = {"type": "application/x-fmu-sharedlibrary", "source": f"resources/{fmu.path.name}"}
    connectors = [
        SSD.Connector(SSC(one.type, **unit_of(one)), name=one.name, kind=one.causality)
        for one in map(fmu.variables.get, shown)
    ]
    parts = [SSD.Connectors(*connectors)]
    if parameter_set:
        parts.append(bindings(f"{parameter_set}_{name}"))
    return SSD.Component(*parts, name=name, implementation="CoSimulation", **source)


def bindings(parameter_set: str):
    """The binding of a parameter set in the folder resources."""
    source = f"resources/{parameter_set}.ssv"
    return SSD.ParameterBindings(SSD.ParameterBinding(type="application/x-ssp-parameter-set", source=source))


def system(name: str, fmus: Fmus, components: list, parameter_set: str, stop: float, *lines):
    """A system structure description of these components, with one parameter set for the whole system."""
    return SSD.SystemStructureDescription(
        SSD.System(bindings(parameter_set), SSD.Elements(*components), *lines, name=name),
        SSD.Units(*units(fmus.cradle)),
        SSD.DefaultExperiment(startTime="0", stopTime=f"{stop:g}"),
        version="1.0",
        name=name,
    )


def parameter_sets(name: str, values: dict, fmu: nc.Fmu) -> dict:
    """Files with the cradle's start values: one parameter set for the system, one for the component."""
    files = {}
    for file, prefix in ((name, "cradle."), (f"{name}_cradle", "")):
        found = []
        for of_fmu, value in fmu.settings(values).items():
            if (variable := fmu.variables[of_fmu]).type != "Enumeration":
                number = SSV(variable.type, value=repr(value), **unit_of(variable))
                found.append(SSV.Parameter(number, name=prefix + of_fmu))
        parts = SSV.Parameters(*found), SSV.Units(*units(fmu))
        files[f"resources/{file}.ssv"] = SSV.ParameterSet(*parts, version="1.0", name=name)
    return files


def units(fmu: nc.Fmu) -> list:
    """The FMU's units, expressed in base units."""
    described = etree.parse(Path(fmu.folder, "modelDescription.xml")).iterfind("UnitDefinitions/Unit")
    return [SSC.Unit(SSC.BaseUnit(dict(unit.find("BaseUnit").attrib)), name=unit.get("name")) for unit in described]


def write(path: Path, files: dict, fmus: list[Path]) -> None:
    """Writes the archive: these XML files, and the FMUs in the folder resources."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, root in files.items():
            archive.writestr(name, etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8"))
        for fmu in fmus:
            archive.write(fmu, f"resources/{fmu.name}")
