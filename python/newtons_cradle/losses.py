"""Damping from a coefficient of restitution, as `cradle-fmu build --restitution` computes it."""

import subprocess
from pathlib import Path
from typing import Any

from . import files
from .building import build, refused
from .errors import InvalidValue, needed, number, whole
from .fmu import Fmu
from .run.model import Values

#: Parameters on which the force between two balls depends, besides its damping.
OF_ALL = (
    "ball.mass",
    "ball.radius",
    "ball.youngModulus",
    "ball.poissonRatio",
    "contact.stiffness",
    "contact.overlapRef",
    "contact.exponent",
)
OF_BALLS = ("ball.massRatio", "ball.radiusRatio", "ball.youngModulusRatio")
OF_CONTACT = ("contact.stiffnessRatio", "contact.lossRatio")


def damping(
    law: str,
    values: Values | None = None,
    *,
    restitution: float,
    speed: float | None = None,
    contact: int = 1,
    fmu: Fmu | None = None,
) -> dict[str, Any]:
    """Start values of a damping law: two free balls that close at `speed` (m/s) part with `restitution` times that
    speed.

    `nc.damping("huntCrossley", nc.preset("steel"), restitution=0.9, speed=1.0)` is a dict with `contact.dampingLaw` and
    its coefficient; merge it with the other start values. Only `constantRestitution` needs no speed. `restitution`:
    above 0, at most 1. `values` describe the cradle; what they leave out is as built into `fmu`, or, if that is None,
    into the default one of five balls. `contact`, from 1, chooses the two balls. In a row in touch all press
    at once, and less energy is lost than by impacts of two, one after the other. Raises InvalidValue, UnknownName, and
    FileMissing where the program `cradle-fmu` is missing.
    """
    if fmu is None:
        with build() as built:
            return damping(law, values, restitution=restitution, speed=speed, contact=contact, fmu=built)
    needed("fmu", fmu, Fmu, "an FMU as `nc.build()` makes it")
    at = whole("contact", contact, 1, max(fmu.balls - 1, 1))
    fmu.require(balls=max(fmu.balls, 2))
    laws = fmu.items("contact.dampingLaw")
    needed("law", law, str, f"one of {', '.join(laws)}")
    if law not in laws:
        raise InvalidValue(f"law = {law!r} is refused; allowed: {', '.join(laws)}")
    asked = [number("restitution", restitution, positive=True, most=1.0)]
    if speed is not None:
        asked.append(number("speed", speed, "m/s", positive=True))
    elif law != "constantRestitution":
        raise InvalidValue(f"speed is missing: by {law} the coefficient of restitution depends on it; allowed: in m/s")
    given = fmu.settings(values or {})

    def value(name: str) -> float:
        return given.get(name, fmu.built_with(name))

    model = next(name for name, item in fmu.items("contact.model").items() if item == value("contact.model"))
    if model == "rigid":
        raise InvalidValue("contact.model = rigid is refused: its coefficient is contact.restitution; allowed: others")
    if value(ratio := f"contact.lossRatio[{at}]") == 0.0 and asked[0] < 1.0:
        raise InvalidValue(
            f"{ratio} = 0 is refused; allowed: above 0 where the balls of this contact are to lose energy"
        )
    pair = {name: value(name) for name in OF_ALL}
    pair |= {f"{name}[{1 + k}]": value(f"{name}[{at + k}]") for name in OF_BALLS for k in (0, 1)}
    pair |= {f"{name}[1]": value(f"{name}[{at}]") for name in OF_CONTACT}
    chosen = {"contact.model": model, "contact.dampingLaw": law}
    command: list[str | Path] = [files.producer(), "damping", "@".join(map(repr, asked))]
    for name, start in {**pair, **chosen}.items():
        command += ["--set", f"{name}={start}"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="surrogateescape")
    if done.returncode:
        raise InvalidValue(str(refused(done.stderr)))
    name, found = done.stdout.split("=")
    return {"contact.dampingLaw": law, name: float(found)}
