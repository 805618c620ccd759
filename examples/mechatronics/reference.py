"""The machine as one set of equations, integrated with tight tolerance: the reference for the coupling."""

import math
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp


def reference(c: dict, p: dict, n: int, times: np.ndarray) -> np.ndarray:
    """Positions (m) of n equal balls relative to the cart, then of the cart, at these times (s), from rest at 0: shape
    (times, n + 1). The contacts are linear, without damping. `c`, `p`: parameters of cradle and plant."""
    omega2 = c["gravity"] / c["pendulum.length"]

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x, v, (s, cart, i) = y[:n], y[n : 2 * n], y[2 * n :]
        contacts = c["contact.stiffness"] * np.maximum(x[:-1] - x[1:] - c["contact.deadBand"], 0.0)
        pushed = p["force_constant"] * i
        support = c["ball.mass"] * omega2 * x.sum()
        acceleration = (support - pushed - p["stiffness"] * s - p["damping"] * cart) / p["mass"]
        pull = math.sin(math.pi * t / p["pull_time"]) ** 2 if t < p["pull_time"] else 0.0
        loop = (p["resistance"] + p["gain"]) * (p["pull"] * pull - i)
        current = (loop - p["force_constant"] * v[0]) / p["inductance"]
        outer = -np.diff(contacts, prepend=pushed, append=0.0)
        balls = outer / c["ball.mass"] - omega2 * x - acceleration
        return np.concatenate([v, balls, [cart, acceleration, current]])

    states = [np.zeros(2 * n + 3)]
    for span in pairwise(times):
        states.append(solve_ivp(rates, span, states[-1], "DOP853", rtol=1e-12, atol=1e-15).y[:, -1])
    return np.array(states)[:, [*range(n), 2 * n]]
