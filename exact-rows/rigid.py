"""Rows of rigid balls twice: in fractions, by velocities; in 60 decimal digits, by gaps and approach speeds.

Impacts are those of two balls. At one place in time the pair that approaches fastest comes first; equally fast pairs
that share no ball are independent, and no case has equally fast ones that share a ball.
"""

import random
from decimal import Decimal, getcontext
from fractions import Fraction

import numpy as np

getcontext().prec = 60


def fastest(approach, touching, zero=0):
    """The contacts that collide next among those that touch."""
    most = max(approach[j] for j in touching)
    tied = [j for j in touching if most - approach[j] <= zero]
    assert all(np.diff(tied) > 1), "a tie that shares a ball"
    return tied


def impacts(m, x, v, gap, e):
    """Time (s), contact (from 1), positions and velocities behind it of each impact. `e()` returns its restitution.
    Exact if all numbers are fractions."""
    x, v, t = np.array(x, dtype=object), np.array(v, dtype=object), 0 * v[0]
    while any((w := v[:-1] - v[1:]) > 0):
        times = {j: (x[j + 1] + gap[j] - x[j]) / speed for j, speed in enumerate(w) if speed > 0}
        step = min(times.values())
        x, t = x + v * step, t + step
        for j in fastest(w, [j for j, time in times.items() if time == step]):
            impulse = (1 + e()) * w[j] * m[j] * m[j + 1] / (m[j] + m[j + 1])
            v[j] -= impulse / m[j]
            v[j + 1] += impulse / m[j + 1]
            yield t, j + 1, x, v.copy()


def arrays(row, number):
    """Masses, positions, velocities, gaps and the restitution of a row, in these numbers."""
    lists = [row[name] for name in ("mass", "x", "v", "gap")] + [[row["damping"]]]
    return [np.array([number(value) for value in values], dtype=object) for values in lists]


def in_fractions(row, seed=0):
    """The results of a row; with a seed, with each value changed by 1e-16 of itself, up or down by chance."""
    rng, change = random.Random(seed), Fraction(1, 10**16) if seed else 0
    m, x, v, gap, e = arrays(row, lambda value: Fraction(value) * (1 + rng.choice((-1, 1)) * change))
    times, contacts, _, speeds = zip(*impacts(m, x, v, gap, lambda: e[0]), strict=True)
    parts = times, speeds[-1], [sum(m * (v * v - speeds[-1] ** 2)) / 2]
    times, v, loss = ([Decimal(f.numerator) / f.denominator for f in part] for part in parts)
    events = [*zip(contacts, times, strict=True)]
    return {"v": v, "loss": loss, "closed": events, "opened": events}


def in_decimals(row):
    """The same, by gaps and approach speeds."""
    m, x, v, gap, (e,) = arrays(row, Decimal)
    far, w, t, lost, zero = x[1:] + gap - x[:-1], v[:-1] - v[1:], Decimal(0), Decimal(0), Decimal("1e-45")
    events = []
    while closing := [j for j, speed in enumerate(w) if speed > zero]:
        step = min(max(far[j], Decimal(0)) / w[j] for j in closing)
        far, t = far - w * step, t + step
        for j in fastest(w, [j for j in closing if far[j] < zero], zero):
            reduced, before = m[j] * m[j + 1] / (m[j] + m[j + 1]), w[j]
            lost += reduced * before * before * (1 - e * e) / 2
            w[j] = -e * before
            w[j - 1 : j] += (1 + e) * reduced * before / m[j]
            w[j + 1 : j + 2] += (1 + e) * reduced * before / m[j + 1]
            events.append((j + 1, t))
    behind = np.array([0, *np.cumsum(w)])  # by which a ball is slower than the first
    v = sum(m * (v + behind)) / sum(m) - behind
    return {"v": v, "loss": [lost], "closed": events, "opened": events}
