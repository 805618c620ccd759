"""The same machine as one set of equations, integrated with tight tolerance: the reference for the coupling."""

import math

import numpy as np
from scipy.integrate import solve_ivp


class Machine:
    """Cradle (equal balls, linear contacts without damping), cart and coil in one. SI units.

    State: x and v of the n balls relative to the cart, then s, v, i and q of the plant.
    """

    def __init__(self, cradle: dict, plant: dict, n: int):
        self.n, self.cradle, self.plant = n, cradle, plant
        self.omega2 = cradle["gravity"] / cradle["pendulum.length"]

    def rates(self, t: float, y: np.ndarray, closed: np.ndarray) -> np.ndarray:
        """dy/dt with these contacts closed."""
        n, c, p = self.n, self.cradle, self.plant
        x, v, (s, cart, i, _) = y[:n], y[n : 2 * n], y[2 * n :]
        force = np.where(closed, c["contact.stiffness"] * self.overlaps(y), 0.0)
        pushed = p["force_constant"] * i
        support = c["ball.mass"] * self.omega2 * x.sum()
        acceleration = (support - pushed - p["stiffness"] * s - p["damping"] * cart) / p["mass"]
        outer = np.zeros(n)
        outer[:-1] -= force
        outer[1:] += force
        outer[0] += pushed
        pull = math.sin(math.pi * t / p["pull_time"]) ** 2 if t < p["pull_time"] else 0.0
        loop = (p["resistance"] + p["gain"]) * (p["pull"] * pull - i)
        current = (loop - p["force_constant"] * v[0]) / p["inductance"]
        balls = outer / c["ball.mass"] - self.omega2 * x - acceleration
        return np.concatenate([v, balls, [cart, acceleration, current, i]])

    def overlaps(self, y: np.ndarray) -> np.ndarray:
        """Overlap of each contact, m."""
        return y[: self.n - 1] - y[1 : self.n] - self.cradle["contact.deadBand"]

    def solve(self, times: np.ndarray) -> np.ndarray:
        """States at these times (s, rising from 0), shape (times, 2 n + 4), from rest."""
        y, t, found = np.zeros(2 * self.n + 4), 0.0, {}
        closed = self.overlaps(y) > 0.0
        stops = sorted({*times[1:], self.plant["pull_time"]})
        found[0.0] = y
        while t < times[-1]:
            end = next(stop for stop in stops if stop > t)
            events = [self._crossing(i, closed) for i in range(self.n - 1)]
            options = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-16, "events": events, "args": (closed,)}
            # A step must not jump over a short pulse, nor over the onset of one.
            part = solve_ivp(self.rates, (t, end), y, max_step=1e-5 if closed.any() else 1e-2, **options)
            t, y = part.t[-1], part.y[:, -1]
            if part.status == 1:
                closed = closed.copy()
                for i, hits in enumerate(part.t_events):
                    if len(hits):
                        closed[i] = not closed[i]
            else:
                found[end] = y
        return np.array([found[time] for time in times])

    def _crossing(self, contact: int, closed: np.ndarray):
        """The event of this contact opening, if it is closed, or closing."""

        def overlap(_t, y, _closed):
            return self.overlaps(y)[contact]

        overlap.terminal, overlap.direction = True, -1 if closed[contact] else 1
        return overlap
