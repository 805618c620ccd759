"""Hosts whose floating-point environment is not the default one, and whose threads have small stacks."""

import shutil
from itertools import product
from pathlib import Path

import fmpy
import newtons_cradle as nc
import pytest
from conftest import ROOT, ended, repacked

LAWS = {
    "linear": {},
    "p=1.5": {"contact.exponent": 1.5, "contact.overlapRef": 1e-4},
    "cubic": {"contact.exponent": 3, "contact.overlapRef": 1e-3},
    "hertz": {"contact.model": "hertz", "ball.youngModulus": 1e8},
    "rigid": {"contact.model": "rigid", "contact.restitution": 0.9},
}
LOSSES = {
    "elastic": {},
    "kelvinVoigt": {"contact.damping": 100, "pendulum.drag": 0.1},
    "kelvinVoigtNoPull": {"contact.dampingLaw": "kelvinVoigtNoPull", "contact.damping": 2e3},
    "huntCrossley": {"contact.dampingLaw": "huntCrossley", "contact.huntCrossley": 0.3},
    "viscoelastic": {"contact.dampingLaw": "viscoelastic", "contact.relaxationTime": 1e-5},
}
# Balls that are struck within the first step, by a fast one; or that touch, some of them pressed together.
SCENES = {
    "apart": {"contact.deadBand": 2e-6, "v_start[1]": 1},
    "touching": {"contact.deadBand": 0, "v_start[2]": 1, "F_ext[5]": -2, "pendulum.lengthRatio[4]": 1.2},
}
SHORT = {"pendulum.length": 0.4, "contact.stiffness": 1e7, "x_start": [-0.0005, 0, 0, 0, 0], "solver.fixedStep": 2e-5}


def cases() -> dict[str, dict]:
    """Start values for all laws, losses and models, for all methods, and the presets with five balls."""
    found = {}
    for law, loss, scene, model in product(LAWS, LOSSES, SCENES, ("linear", "circular")):
        if law != "rigid" or loss == "elastic":
            values = SHORT | LAWS[law] | LOSSES[loss] | SCENES[scene] | {"pendulum.model": model}
            found[f"{law}-{loss}-{scene}-{model}"] = values | {"exchange.contacts": "mapped"}
    for method, law in product(("bdf", "adams", "rk4"), ("linear", "p=1.5", "hertz", "rigid")):
        found[f"{method}-{law}"] = SHORT | LAWS[law] | SCENES["touching"] | {"solver.method": method}
    for law, scene, model in product(LAWS, SCENES, ("linear", "circular")):
        values = SHORT | LAWS[law] | SCENES[scene] | {"pendulum.model": model}
        found[f"resolved-{law}-{scene}-{model}"] = values | {"exchange.contacts": "resolved"}
    return found | {name: nc.preset(name) for name in nc.presets() if "x_start[6]" not in nc.preset(name)}


def for_host(fmu, scalars) -> str:
    """What the C host reads: variables that the descriptions of both versions have, and the cases."""
    variables = fmu.description.modelVariables
    common = {v.name for v in scalars.modelVariables}
    read = [v for v in variables if v.causality in ("output", "local", "calculatedParameter") and v.name in common]
    references = {v.name: v.valueReference for v in variables}
    types = {v.name: "r" if v.type == "Real" else "e" for v in variables}
    numbers = {
        "r": [v.valueReference for v in read if v.type == "Real"],
        "i": [v.valueReference for v in read if v.type == "Integer"],
        "b": [v.valueReference for v in read if v.type == "Boolean"],
        "u": [references[name] for name in ("x[1]", "v[4]", "F_support", "E_total", "impulse[1]")],
        "k": [references[name] for name in ("F_ext[1]", "F_ext[4]", "a_support")],
        "p": [references[name] for name in ("x_start[1]", "v_start[2]", "ball.massRatio[3]", "contact.stiffness")],
        "n": [fmu.description.numberOfContinuousStates, fmu.description.numberOfEventIndicators],
    }
    lines = [" ".join(map(str, (letter, *values))) for letter, values in numbers.items()]
    for name, values in cases().items():
        settings = fmu.settings(values).items()
        lines.append(" ".join([name, *(f"{types[key]}:{references[key]}={value}" for key, value in settings)]))
    return "\n".join(lines)


@pytest.fixture(scope="module")
def host(fmu, producer, tmp_path_factory):
    """Compiles the C host; runs all cases with the FMU in a thread with a stack of this many bytes."""
    folder = tmp_path_factory.mktemp("environments")
    if not (compiler := shutil.which("cc")):
        pytest.skip("there is no C compiler")
    headers = Path(fmpy.__file__).with_name("c-code")
    program = folder / "environments"
    ended(compiler, "-O1", "-Wall", "-Wextra", "-Werror", f"-I{headers}", "-o", program,
          ROOT / "tests/hosts/environments.c", "-ldl", "-lpthread")  # fmt: skip
    scalars = repacked(producer, fmu.path, folder / "scalars.fmu", "--fmi", "3", "--scalars")
    scalars = fmpy.read_model_description(str(scalars))
    library = Path(fmu.folder, "binaries/linux64/NewtonsCradle.so")
    resources = Path(fmu.folder, "resources")
    texts = for_host(fmu, scalars)
    command = program, library, resources.as_uri(), resources, fmu.description.guid, scalars.instantiationToken
    return lambda stack: ended(*command, stack, input=texts).stdout.split()


def test_every_call_gives_the_same_bits_in_any_environment_and_leaves_it(host):
    """Refused are balls of unequal pendulums that would have to stay in contact, general-purpose solvers without forces, and
    the derivative of a step with rigid impacts of balls in touch."""
    on_arcs = {"rigid-elastic-touching-circular", "resolved-rigid-touching-circular"}
    assert set(host(8 << 20)) == {*on_arcs, "bdf-rigid", "adams-rigid", "rk4-rigid", "rigid"}
