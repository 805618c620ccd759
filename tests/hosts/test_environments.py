"""Hosts whose floating-point environment is not the default one, and whose threads have small stacks."""

import re
import shutil
import sys
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
    "constantRestitution": {"contact.dampingLaw": "constantRestitution", "contact.restitution": 0.8},
}
# Balls that are struck within the first step, by a fast one; or that touch, some of them pressed together.
SCENES = {
    "apart": {"contact.deadBand": 2e-6, "v_start[1]": 1},
    "touching": {"contact.deadBand": 0, "v_start[2]": 1, "F_ext[5]": -2, "pendulum.lengthRatio[4]": 1.2},
}
SHORT = {"pendulum.length": 0.4, "contact.stiffness": 1e7, "solver.fixedStep": 2e-5}


def cases(balls: int) -> dict[str, dict]:
    """Start values for all laws, losses and models, for all methods, and the presets with this many balls."""
    found, short = {}, SHORT | {"x_start": [-0.0005] + [0] * (balls - 1)}
    for law, loss, scene, model in product(LAWS, LOSSES, SCENES, ("linear", "circular")):
        if law != "rigid" or loss == "elastic":
            values = short | LAWS[law] | LOSSES[loss] | SCENES[scene] | {"pendulum.model": model}
            found[f"{law}-{loss}-{scene}-{model}"] = values | {"exchange.contacts": "mapped"}
    for method, law in product(("bdf", "adams", "rk4"), ("linear", "p=1.5", "hertz", "rigid")):
        found[f"{method}-{law}"] = short | LAWS[law] | SCENES["touching"] | {"solver.method": method}
    for law, scene, model in product(LAWS, SCENES, ("linear", "circular")):
        values = short | LAWS[law] | SCENES[scene] | {"pendulum.model": model}
        found[f"resolved-{law}-{scene}-{model}"] = values | {"exchange.contacts": "resolved"}
    presets = {name: nc.preset(name) for name in nc.presets()}
    of_as_many = [name for name in presets if sum(key.startswith("x_start[") for key in presets[name]) == balls]
    return found | {name: presets[name] for name in of_as_many}


def for_host(fmu, scalars, cases) -> str:
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
    for name, values in cases.items():
        settings = fmu.settings(values).items()
        lines.append(" ".join([name, *(f"{types[key]}:{references[key]}={value}" for key, value in settings)]))
    return "\n".join(lines)


@pytest.fixture(scope="module")
def host(producer, tmp_path_factory):
    """Compiles the C host; runs cases with an FMU, in so many environments, in a thread with the stack that limits.md
    allows. Returns the names of the cases with refused calls."""
    if not (compiler := shutil.which("cc")) or sys.platform != "linux":
        pytest.skip("the C host needs Linux and a C compiler")
    folder = tmp_path_factory.mktemp("environments")
    program, headers = folder / "environments", Path(fmpy.__file__).with_name("c-code")
    flags = ["-O1", "-Wall", "-Wextra", "-Werror", f"-I{headers}", "-o", program]
    ended(compiler, *flags, ROOT / "tests/hosts/environments.c", "-ldl", "-lpthread")
    stack = int(re.search(r"stack of (\d+) KiB", (ROOT / "docs/limits.md").read_text(encoding="utf-8"))[1]) << 10

    def host(fmu, cases, environments) -> set[str]:
        scalars = folder / f"{fmu.balls}.fmu"
        repacked(producer, fmu.path, scalars, "--fmi", "3", "--scalars", "--balls", fmu.balls)
        scalars = fmpy.read_model_description(str(scalars))
        library, resources = (
            Path(fmu.folder, f"binaries/{fmpy.platform}/NewtonsCradle.so"),
            Path(fmu.folder, "resources"),
        )
        arguments = [library, resources.as_uri(), resources, fmu.description.guid, scalars.instantiationToken]
        done = ended(program, *arguments, stack, environments, input=for_host(fmu, scalars, cases))
        return set(done.stdout.split())

    return host


# Balls of unequal pendulums that would have to stay in contact, and general-purpose solvers without forces.
REFUSED = {
    "rigid-elastic-touching-circular",
    "resolved-rigid-touching-circular",
    "bdf-rigid",
    "adams-rigid",
    "rk4-rigid",
}


def test_floating_point_environment_changes_no_bit_and_is_left_alone(fmu, host):
    """The derivative of a step in which rigid balls stay in touch is refused as well."""
    assert host(fmu, cases(5), environments=7) == REFUSED | {"rigid"}


def test_stack_does_not_grow_with_the_balls(cradle, fmu_path, host):
    """Forty balls in touch have natural modes, more have none."""
    touching = {name: values for name, values in cases(40).items() if "touching" in name}
    assert host(cradle(balls=40, binaries=fmu_path), touching, environments=1) >= REFUSED & touching.keys()
