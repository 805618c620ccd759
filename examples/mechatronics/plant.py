"""The rest of the machine as an FMU of another exporter, PythonFMU: cart, voice coil, controller and force sensor.

The cart (mass, spring and damper to ground) carries the cradle. A voice coil on the cart pulls ball 1; its
amplifier holds the current at a reference, a pull of the form sin^2 at the beginning. Everything is linear.
So a step is the exact solution, by the matrix exponential, for inputs that change linearly over it.

    cart:  mass s'' = F_support - F_coil - stiffness s - damping s',  F_coil = force_constant i
    coil:  inductance i' = (resistance + gain) (i_ref - i) - force_constant v_coil

The FMU contains this file and runs in the host's Python, which needs NumPy and SciPy. The host must be a
Python program, or be started with LD_PRELOAD=/path/to/libpython3.so. plant.c is the same for any host.
"""

import math
from functools import lru_cache
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Integer, Real
from scipy.linalg import expm

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
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
GAUSS = 0.5 * (1.0 + _NODES), 0.5 * _WEIGHTS  # on [0, 1]


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
        """One communication step; it is cut where the pull ends, the exact solution having a kink there."""
        self._sense()
        v, q, end = self.v, self.q, current_time + step_size
        inputs = [self.F_support, self.F_support_rate, self.v_coil, self.v_coil_rate]
        z = np.array([self.s, self.v, self.i, self.q, *inputs])
        cuts = [t for t in (self.pull_time,) if current_time < t < end]
        for t0, t1 in zip([current_time, *cuts], [*cuts, end], strict=True):
            self._book(t0, t1, z)
            z = self._flow(t0, t1, z)
        self.s, self.v, self.i, self.q = map(float, z[:4])
        self._rates(end, z)
        self.a_mean = (self.v - v) / step_size
        self.F_coil_mean = self.force_constant * (self.q - q) / step_size
        self.last_step = step_size
        return True

    def _sense(self) -> None:
        """The sensor: what the cradle reports is the mean over its last step, as long as the one done here."""
        self.sensed += self.F_sensor * self.last_step
        if self.F_sensor > 0.0:
            self.impacts = self.pulses

    def _book(self, t0: float, t1: float, z: np.ndarray) -> None:
        """Work and loss from t0 to t1, by Gauss' rule."""
        for node, weight in zip(*GAUSS, strict=True):
            _, v, i, _, _, _, v_coil, _ = self._flow(t0, t0 + node * (t1 - t0), z)
            self.coil_work += float(weight * (t1 - t0) * self.force_constant * i * v_coil)
            self.damper_loss += float(weight * (t1 - t0) * self.damping * v**2)

    def _flow(self, t0: float, t1: float, z: np.ndarray) -> np.ndarray:
        """States and inputs at t1, from those at t0."""
        return (_propagator(self._values(), t1 - t0) @ self._with_pull(t0, z))[:8]

    def _rates(self, t: float, z: np.ndarray) -> None:
        """Acceleration and force at the end of a step, and their rates: the equations once and twice."""
        equations = _equations(self._values())
        first = equations @ self._with_pull(t, z)
        self.a, self.a_rate = float(first[1]), float((equations @ first)[1])
        self.F_coil, self.F_coil_rate = self.force_constant * self.i, self.force_constant * float(first[2])

    def _values(self) -> tuple:
        return tuple(getattr(self, name) for name in PARAMETERS)

    def _with_pull(self, t: float, z: np.ndarray) -> np.ndarray:
        """States and inputs, and 1, cos and sin of the pull, which are 0 after it."""
        angle = 2.0 * math.pi * t / self.pull_time
        pull = [1.0, math.cos(angle), math.sin(angle)] if t < self.pull_time else [0.0, 0.0, 0.0]
        return np.concatenate([z, pull])


@lru_cache(maxsize=4096)
def _propagator(values: tuple, h: float) -> np.ndarray:
    return expm(_equations(values) * h)


def _equations(values: tuple) -> np.ndarray:
    """The matrix A in z' = A z, where z is s, v, i, q, F_support, F_support_rate, v_coil, v_coil_rate, and 1, cos and
    sin of the pull."""
    p = dict(zip(PARAMETERS, values, strict=True))
    a = np.zeros((11, 11))
    s, v, i, q, force, force_rate, coil, coil_rate, one, cos, sin = range(11)
    a[s, v] = a[q, i] = a[force, force_rate] = a[coil, coil_rate] = 1.0
    a[v, [s, v, i, force]] = -p["stiffness"], -p["damping"], -p["force_constant"], 1.0
    a[v] /= p["mass"]
    loop = p["resistance"] + p["gain"]
    a[i, [i, coil, one, cos]] = -loop, -p["force_constant"], loop * p["pull"] / 2, -loop * p["pull"] / 2
    a[i] /= p["inductance"]
    a[cos, sin], a[sin, cos] = -2.0 * math.pi / p["pull_time"], 2.0 * math.pi / p["pull_time"]
    return a
