"""A master for the cradle and its plant: four signals, and four ways to estimate them in advance.

The two FMUs step side by side, each over the same step of length h. What one needs from the other during the step is
passed as a value and a rate, which give the right integral over the step:

    hold         what the other one did over its last step, spread over this one: order 1
    extrapolate  value and rate at the start of the step, from output derivatives, passed on as input derivatives;
                 the next step makes up for the error of this guess: order 3
    repeat       what the other one does over this step, held: the step is repeated from saved states until this
                 no longer changes: order 2
    smooth       as `repeat`, but changing linearly over the step, by input derivatives: order 4

Nothing is lost in transit: what one has sent but the other has not received is added to the next step.
"""

from collections.abc import Iterator

import newtons_cradle as nc
import numpy as np

METHODS = ("hold", "extrapolate", "repeat", "smooth")
REPEATING = METHODS[2:]
MOST_TRIALS = 50  # of a step
SHORTEST = 1e-9  # s, of the steps to the next impact
PULSE = 1e-4  # s, step after an impact: about the duration of a pulse
TOLERANCE = 1e-13  # of the integrals (N.s, m, m/s, N.s), when steps are repeated
FORCE, COIL, ACCELERATION, PUSH = range(4)  # the signals: two to the plant, two to the cradle


class Master:
    """A cradle and a plant, and the signals between them."""

    def __init__(self, cradle: nc.Run, plant: nc.Run, method: str = "hold", *, newton: bool = False):
        self.cradle, self.plant, self.method, self.newton = cradle, plant, method, newton
        self.cradle_mass = cradle.get("ball.mass") * sum(cradle["ball.massRatio"])
        self.trials = 0  # steps of the cradle, with repeated ones
        # For each signal: the integral sent and delivered so far, and the sender's present value and rate.
        self.sent = np.zeros(4)
        self.sent = self._sent(0.0)
        self.delivered = self.sent.copy()
        self.value, self.rate = self._look()
        self._responses: dict[float, np.ndarray] = {}  # of the plant, by length of step

    @property
    def time(self) -> float:
        """The present time, s."""
        return self.cradle.time

    @property
    def pending(self) -> np.ndarray:
        """The integral of each signal that was sent but not yet delivered."""
        return self.sent - self.delivered

    def momenta(self) -> dict[str, float]:
        """The momenta of the balls, of the cart, and on its way from one to the other, kg.m/s."""
        return {
            "balls": self.cradle.get("p_total") + self.cradle_mass * self.delivered[ACCELERATION],
            "cart": self.plant.get("mass") * self.plant.get("v"),
            "on its way": self.pending[FORCE] + self.pending[PUSH],
        }

    def energies(self) -> dict[str, float]:
        """Energies, J: of the balls, at the velocity that the cart has for them; of the cart; lost; put in by the
        coil."""
        known = self.delivered[ACCELERATION]
        energy, momentum = self.cradle.get("E_total"), self.cradle.get("p_total")
        s, v, mass, stiffness = (self.plant.get(name) for name in ("s", "v", "mass", "stiffness"))
        return {
            "balls": energy + known * momentum + 0.5 * self.cradle_mass * known**2,
            "cart": 0.5 * mass * v**2 + 0.5 * stiffness * s**2,
            "lost": self.plant.get("damper_loss") + self.cradle.get("E_dissipated"),
            "put in": self.plant.get("coil_work"),
        }

    def steps(self, stop: float, h: float, *, at_impacts: bool = False) -> Iterator[float]:
        """Steps to `stop` (s), ending a step at each multiple of h (s); yields the times, the first one included.

        `at_impacts`: also ends a step at every onset of a contact, and shortly after it. Only for methods that repeat
        steps: the others would put into a short step what was meant for a long one.
        """
        if at_impacts and self.method not in REPEATING:
            raise ValueError(f"the method {self.method} needs equal steps; only {REPEATING} can step to impacts")
        yield self.time
        struck = False
        for number in range(1, round(stop / h) + 1):
            end = number * h
            while self.time < end:
                foreseen = at_impacts and self.cradle.get("t_next_isOnset")
                onset = self.cradle.get("t_next") if foreseen else nc.NEVER
                target = min(end, self.time + PULSE) if struck else end
                struck = self.time + SHORTEST < onset < target - SHORTEST
                self.step_to(onset if struck else target)
                yield self.time

    def step_to(self, end: float) -> None:
        """One communication step of both, to `end` (s). Raises RuntimeError if a repeated step does not converge."""
        begin, h, repeating = self.time, end - self.time, self.method in REPEATING
        share, rate = self.pending, np.zeros(4)
        if self.method == "extrapolate":
            share, rate = share + h * self.value + 0.5 * h**2 * self.rate, self.rate
        elif repeating:
            share = share + h * self.value
        before = {run: run.slave.getFMUstate() for run in (self.cradle, self.plant) if repeating}
        limit = TOLERANCE * (1.0 + np.abs(self.sent))
        for _ in range(MOST_TRIALS):
            self._try(end, h, share, rate)
            sent = self._sent(h)
            defect = sent - self.delivered - share
            if not repeating or np.all(np.abs(defect) <= limit):
                break
            if self.method == "smooth":
                rate = (self._look()[0] - self.value) / h
            if self.newton:
                defect = np.linalg.solve(np.eye(4) - self._response(begin, end, before[self.plant]), defect)
            share = share + defect
            for run, state in before.items():
                run.slave.setFMUstate(state)
                run.time = begin
        else:
            raise RuntimeError(f"the step to {end} s does not converge in {MOST_TRIALS} trials: try shorter steps")
        for run, state in before.items():
            run.slave.freeFMUstate(state)
        self.delivered, self.sent = self.delivered + share, sent
        self.value, self.rate = self._look()

    def _try(self, end: float, h: float, share: np.ndarray, rate: np.ndarray) -> None:
        """Steps both FMUs. `share`: the integral of each signal over the step; `rate`: its rate."""
        value = share / h - 0.5 * h * rate
        self.trials += 1
        self.cradle.set({"a_support": value[ACCELERATION], "F_ext[1]": value[PUSH]})
        if np.any(rate):
            references = self.cradle.slave.references("a_support", "F_ext[1]")
            self.cradle.slave.setRealInputDerivatives(references, [1, 1], [rate[ACCELERATION], rate[PUSH]])
        last = f"[{self.cradle.fmu.balls - 1}]"
        sensor = {"F_sensor": self.cradle.get("F_mean" + last), "pulses": self.cradle.get("pulses" + last)}
        to_plant = {"F_support": value[FORCE], "v_coil": value[COIL]}
        self.plant.set(to_plant | {"F_support_rate": rate[FORCE], "v_coil_rate": rate[COIL]} | sensor)
        self.cradle.step_to(end)
        self.plant.step_to(end)

    def _sent(self, h: float) -> np.ndarray:
        """The integrals that each side has sent, after a step of length h (s)."""
        supported = self.sent[FORCE] + h * self.cradle.get("F_support_mean")
        pushed = self.plant.get("force_constant") * self.plant.get("q")
        return np.array([supported, self.cradle.get("x[1]"), self.plant.get("v"), pushed])

    def _look(self) -> tuple[np.ndarray, np.ndarray]:
        """Values and rates at the present time: the cradle's rates are its output derivatives."""
        names = ("F_support", "v[1]")
        rates = self.cradle.slave.getRealOutputDerivatives(self.cradle.slave.references(*names), [1, 1])
        plant = [self.plant.get(name) for name in ("a", "F_coil", "a_rate", "F_coil_rate")]
        values = [self.cradle.get(name) for name in names]
        return np.array([*values, *plant[:2]]), np.array([*rates, *plant[2:]])

    def _response(self, begin: float, end: float, before) -> np.ndarray:
        """The derivatives of the sent signals by the received ones; for the cradle from directional derivatives."""
        cradle, h, response = self.cradle, end - begin, np.zeros((4, 4))
        for signal, name in ((ACCELERATION, "a_support"), (PUSH, "F_ext[1]")):
            force, position = cradle.derivative(["F_support_mean", "x[1]"], name, over="step") / h
            response[FORCE, signal], response[COIL, signal] = h * force, position
        response[2:, :2] = self._plant_response(begin, end, before)
        return response

    def _plant_response(self, begin: float, end: float, before) -> np.ndarray:
        """The derivatives of the plant's sent signals by its received ones. The plant is linear but gives no
        derivatives: differences of trial steps give them, once for each length of step."""
        h = end - begin
        if h not in self._responses:
            plant, sent = self.plant, []
            for force, coil in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
                plant.slave.setFMUstate(before)
                plant.time = begin
                plant.set({"F_support": force / h, "v_coil": coil / h, "F_support_rate": 0.0, "v_coil_rate": 0.0})
                plant.step_to(end)
                sent.append([plant.get("v"), plant.get("force_constant") * plant.get("q")])
            zero, *told = map(np.array, sent)
            self._responses[h] = np.column_stack([each - zero for each in told])
        return self._responses[h]
