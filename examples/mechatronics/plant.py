"""The rest of the machine as an FMU of another exporter, PythonFMU: cart, voice coil, controller and force sensor.

The cart (mass, spring and damper to ground) carries the cradle. A voice coil on the cart pulls ball 1; its
amplifier holds the current at a reference, a pull of the form sin^2 at the beginning. Inputs change linearly over a step.

    cart:  mass s'' = F_support - F_coil - stiffness s - damping s',  F_coil = force_constant i
    coil:  inductance i' = (resistance + gain) (i_ref - i) - force_constant v_coil

The FMU contains this file and runs in the host's Python, which needs NumPy and SciPy. The host must be a
Python program, or be started with LD_PRELOAD=/path/to/libpython3.so. plant.c is the same for any host.
"""

import math
from itertools import pairwise
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Integer, Real
from scipy.integrate import solve_ivp

PARAMETERS = {  # name: (start value, unit, meaning)
    "mass": (2.0, "kg", "mass of the cart"),
    "stiffness": (150.0, "N/m", "of the cart's spring to ground"),
    "damping": (1.0, "N.s/m", "of its damper to ground"),
    "force_constant": (1.0, "N/A", "of the coil; the same in V.s/m"),
    "resistance": (5.0, "Ohm", "of the coil"),
    "inductance": (0.2, "H", "of the coil"),
    "gain": (5.0, "V/A", "of the current controller"),
    "pull": (-0.8, "A", "largest reference current; negative pulls ball 1 to the left"),
    "pull_time": (1.6, "s", "how long it pulls"),
}
INPUTS = {  # name: (unit, meaning)
    "F_support": ("N", "force of the cradle on the cart at the start of a step"),
    "F_support_rate": ("N/s", "its rate during the step"),
    "v_coil": ("m/s", "velocity of ball 1 relative to the cart at the start of a step"),
    "v_coil_rate": ("m/s2", "its rate during the step"),
    "F_sensor": ("N", "mean contact force on the last ball over the step before"),
}
STATES = {
    "s": ("m", "position of the cart"),
    "v": ("m/s", "its velocity"),
    "i": ("A", "current"),
    "q": ("A.s", "integral of the current"),
}
OUTPUTS = {
    "a_mean": ("m/s2", "acceleration of the cart, mean over the last step"),
    "F_coil_mean": ("N", "force of the coil on ball 1, mean over the last step"),
    "a": ("m/s2", "acceleration of the cart at the end of the step"),
    "a_rate": ("m/s3", "its rate"),
    "F_coil": ("N", "force of the coil at the end of the step"),
    "F_coil_rate": ("N/s", "its rate"),
    "coil_work": ("J", "work done by the coil between cart and ball 1"),
    "damper_loss": ("J", "energy lost in the damper"),
    "sensed": ("N.s", "impulse that the force sensor has seen"),
}
UNITS = {  # of PARAMETERS, INPUTS, STATES and OUTPUTS: powers of kg, m, s and A
    "A": (0, 0, 0, 1), "A.s": (0, 0, 1, 1), "H": (1, 2, -2, -2), "J": (1, 2, -2, 0), "N": (1, 1, -2, 0),
    "N.s": (1, 1, -1, 0), "N.s/m": (1, 0, -1, 0), "N/A": (1, 1, -2, -1), "N/m": (1, 0, -2, 0), "N/s": (1, 1, -3, 0),
    "Ohm": (1, 2, -3, -2), "V/A": (1, 2, -3, -2), "kg": (1, 0, 0, 0), "m": (0, 1, 0, 0), "m/s": (0, 1, -1, 0),
    "m/s2": (0, 1, -2, 0), "m/s3": (0, 1, -3, 0), "s": (0, 0, 1, 0),
}  # fmt: skip
INTEGRATED = (*STATES, "coil_work", "damper_loss", "F_support", "v_coil")
LONGEST = 5e-3  # s, step of the integration; the fastest time constant, of the coil, is 20 ms


class CartAndCoil(Fmi2Slave):
    """Cart, voice coil with current controller, and force sensor."""

    description = "Cart with voice coil, current controller and force sensor, for Newton's cradle"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self._units: dict[str, str] = {}
        exact = {"initial": Fmi2Initial.exact}
        fixed = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed, **exact}
        given, output = {"causality": Fmi2Causality.input}, {"causality": Fmi2Causality.output, **exact}
        kinds = [
            (PARAMETERS, fixed),
            (INPUTS, given),
            (STATES | OUTPUTS, output),
            ({"last_step": ("s", "length of the last step")}, {"causality": Fmi2Causality.local, **exact}),
        ]
        for table, options in kinds:
            for name, (*start, unit, text) in table.items():
                setattr(self, name, start[0] if start else 0.0)
                self._units[name] = unit
                self.register_variable(Real(name, description=text, **options))
        discrete = {"variability": Fmi2Variability.discrete}
        self.pulses = self.impacts = 0
        text = "pulses of the last contact so far"
        self.register_variable(Integer("pulses", description=text, **given, **discrete))
        text = "impacts that the sensor has felt"
        self.register_variable(Integer("impacts", description=text, **output, **discrete))

    def to_xml(self, *options) -> Element:
        """The description, with the units that PythonFMU does not know of."""
        root = super().to_xml(*options)
        definitions = Element("UnitDefinitions")
        for name, powers in UNITS.items():
            bases = zip(("kg", "m", "s", "A"), powers, strict=True)
            unit = SubElement(definitions, "Unit", name=name)
            SubElement(unit, "BaseUnit", {base: str(power) for base, power in bases if power})
        root.insert(1, definitions)
        for variable in root.findall("ModelVariables/ScalarVariable[Real]"):
            variable.find("Real").set("unit", self._units[variable.get("name")])
        return root

    def do_step(self, current_time: float, step_size: float) -> bool:
        """One communication step; it is cut where the pull ends, which has a kink there."""
        # The sensor: what the cradle reports is the mean over its last step, as long as the one done here.
        self.sensed += self.F_sensor * self.last_step
        if self.F_sensor > 0.0:
            self.impacts = self.pulses
        v, q, end = self.v, self.q, current_time + step_size
        z = [getattr(self, name) for name in INTEGRATED]
        cuts = [t for t in (self.pull_time,) if current_time < t < end]
        for t0, t1 in pairwise([current_time, *cuts, end]):
            # Equal steps: with adaptive ones, steps that are repeated would differ by the tolerance.
            steps = {"max_step": (t1 - t0) / math.ceil((t1 - t0) / LONGEST), "atol": math.inf}
            z = solve_ivp(self._rates, (t0, t1), z, "DOP853", first_step=steps["max_step"], **steps).y[:, -1]
        rate = dict(zip(INTEGRATED, self._rates(end, z), strict=True))
        for name in (*STATES, "coil_work", "damper_loss"):
            setattr(self, name, float(z[INTEGRATED.index(name)]))
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
        states = [v, force / self.mass, loop / self.inductance, i]
        return [*states, work, loss, self.F_support_rate, self.v_coil_rate]
