"""The rest of the machine as an FMU of another exporter, PythonFMU: cart, voice coil, controller and force sensor.

The cart (mass, spring and damper to ground) carries the cradle. A voice coil on the cart pulls ball 1; its amplifier
holds the current at a reference, a pull of the form sin^2 at the beginning. Inputs change linearly over a step.

    cart:  mass s'' = F_support - F_coil - stiffness s - damping s',  F_coil = force_constant i
    coil:  inductance i' = (resistance + gain) (i_ref - i) - force_constant v_coil

The FMU contains this file and plant.xml, which has its variables. It runs in the host's Python, which needs NumPy and
SciPy. The host must be a Python program, or be started with LD_PRELOAD=/path/to/libpython3.so. The same in C, plant.c,
needs nothing of its host.
"""

import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pythonfmu import Fmi2Slave, Integer, Real
from scipy.integrate import solve_ivp

INTEGRATED = ("s", "v", "i", "q", "coil_work", "damper_loss", "F_support", "v_coil")


class CartAndCoil(Fmi2Slave):
    """Cart, voice coil with current controller, and force sensor."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for variable in self._described().iter("ScalarVariable"):
            name, (value,) = variable.get("name"), variable
            setattr(self, name, float(value.get("start")))
            self.register_variable({"Real": Real, "Integer": Integer}[value.tag](name))

    def to_xml(self, *_options) -> ElementTree.Element:
        """The description: PythonFMU's own would have no units."""
        root = self._described()
        root.attrib |= {"guid": str(self.guid), "generationTool": "PythonFMU"}
        root.find("CoSimulation").attrib |= {"modelIdentifier": self.modelName, "needsExecutionTool": "true"}
        return root

    def _described(self) -> ElementTree.Element:
        return ElementTree.parse(Path(self.resources, "plant.xml")).getroot()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """One communication step."""
        # The sensor gets the cradle's mean over its last step.
        self.sensed += self.F_sensor * self.last_step
        if self.F_sensor > 0.0:
            self.impacts = self.pulses
        v, q, end = self.v, self.q, current_time + step_size
        z = [getattr(self, name) for name in INTEGRATED]
        # Tight, because repeated steps must agree to the master's tolerance; the pull has a kink at `pull_time`.
        z = solve_ivp(self._rates, (current_time, end), z, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
        rate = dict(zip(INTEGRATED, self._rates(end, z), strict=True))
        for name, value in zip(INTEGRATED[:6], z[:6], strict=True):
            setattr(self, name, float(value))
        self.a_mean = (self.v - v) / step_size
        self.F_coil_mean = self.force_constant * (self.q - q) / step_size
        self.a, self.F_coil = rate["v"], self.force_constant * self.i
        self.F_coil_rate = self.force_constant * rate["i"]
        elastic = self.stiffness * self.v + self.damping * self.a
        self.a_rate = (self.F_support_rate - self.F_coil_rate - elastic) / self.mass
        self.last_step = step_size
        return True

    def _rates(self, t: float, z: np.ndarray) -> list[float]:
        """The equations: rates of INTEGRATED at the time t."""
        s, v, i, _, _, _, support, v_coil = z
        pull = self.pull * math.sin(math.pi * t / self.pull_time) ** 2 if t < self.pull_time else 0.0
        force = support - self.force_constant * i - self.stiffness * s - self.damping * v
        loop = (self.resistance + self.gain) * (pull - i) - self.force_constant * v_coil
        work, loss = self.force_constant * i * v_coil, self.damping * v**2
        return [v, force / self.mass, loop / self.inductance, i, work, loss, self.F_support_rate, self.v_coil_rate]
