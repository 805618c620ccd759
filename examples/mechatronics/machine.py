"""The machine of this example: its start values, its plant FMU, and runs of it in either way."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from master import Master
from pack import pack
from support import nc

STOP = 5.0  # s
FREE = {"stiffness": 0.0, "damping": 0.0}  # no spring and damper to ground
CRADLE = {  # what the equations in reference.py assume
    "gravity": 9.81,
    "pendulum.length": 1.962,
    "pendulum.drag": 0.0,
    "ball.mass": 1.0,
    "contact.stiffness": 1e10,
    "contact.exponent": 1.0,
    "contact.deadBand": 2.6e-6,
    "contact.damping": 0.0,
} | nc.lifted(0)  # all balls hang at rest: the coil pulls the first one
CRADLE |= {f"{name}[{i}]": 1.0 for name in ("ball.massRatio", "pendulum.lengthRatio") for i in range(1, 6)}
for i in range(1, 5):
    CRADLE |= {f"contact.stiffnessRatio[{i}]": 1.0, f"contact.gap[{i}]": 0.0}
DESCRIPTION = Path(__file__).with_name("plant.xml")
PARAMETERS = {  # of the plant
    parameter.get("name"): float(parameter.find("Real").get("start"))
    for parameter in ElementTree.parse(DESCRIPTION).iterfind("ModelVariables/*[@causality='parameter']")
}
# Not every tool that runs an SSP can set these: the FMU must have been built with them.
BUILT_IN = {"contact.model": "powerLaw", "contact.dampingLaw": "kelvinVoigt", "solver.method": "eventDriven"}


@dataclass(frozen=True)
class Fmus:
    """The two FMUs."""

    cradle: nc.Fmu
    plant: nc.Fmu

    @contextmanager
    def started(self, method: str, values: dict | None = None, *, newton: bool = False) -> Iterator[Master]:
        """A master at the start time; `values`: parameters of the plant."""
        with self.cradle.start(CRADLE) as cradle, self.plant.start(values) as of_plant:
            yield Master(cradle, of_plant, method, newton=newton)


@contextmanager
def opened(cradle: Path, out: Path, language: str) -> Iterator[Fmus]:
    """The cradle, and the plant in this language, built into the folder `out`. Raises FileNotFoundError, FmuError."""
    with nc.Fmu(cradle) as first:
        first.require(balls=5, starts=BUILT_IN)
        with nc.Fmu(plant(language, out)) as second:
            yield Fmus(first, second)


def plant(language: str, out: Path) -> Path:
    """The plant's FMU: from plant.c, which runs only on machines like this one, or from plant.py. Raises
    FileNotFoundError without a C compiler."""
    if language == "c":
        return pack(DESCRIPTION.with_suffix(".c"), DESCRIPTION, out / "plant.fmu")
    from pythonfmu.builder import FmuBuilder

    return FmuBuilder.build_FMU(DESCRIPTION.with_suffix(".py"), out, [DESCRIPTION])


def positions(master: Master) -> list[float]:
    """Positions of the balls relative to the cart, then of the cart, m."""
    return [*master.cradle["x"], master.plant.get("s")]
