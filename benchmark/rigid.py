"""Rows of rigid balls twice: in fractions, by velocities; in 60 decimal digits, by gaps and approach speeds.

Impacts are those of two balls. At one place in time the pair that approaches fastest comes first; equally fast pairs
that share no ball are independent, and no case has equally fast ones that share a ball.
"""

import itertools
from decimal import Decimal, getcontext
from fractions import Fraction

getcontext().prec = 60


def pairs(approach, touching, equal):
    """The contacts that collide next among those that touch: the fastest."""
    fastest = max((approach[j] for j in touching), default=0)
    tied = [j for j in touching if equal(approach[j], fastest)]
    assert all(b - a > 1 for a, b in itertools.pairwise(tied)), "a tie that shares a ball"
    return tied


def in_fractions(row):
    """Velocities, impacts as (time, contact from 1), energy lost."""
    number = row.get("number", Fraction)
    m, x, v, gap = ([number(value) for value in row[name]] for name in ("mass", "x", "v", "gap"))
    e, t, impacts, contacts = number(row["damping"]), Fraction(0), [], range(len(m) - 1)
    energy = sum(mass * speed * speed for mass, speed in zip(m, v, strict=True)) / 2
    while True:
        w = [v[j] - v[j + 1] for j in contacts]
        times = {j: (x[j + 1] + gap[j] - x[j]) / w[j] for j in contacts if w[j] > 0}
        if not times:
            left = sum(mass * speed * speed for mass, speed in zip(m, v, strict=True)) / 2
            return v, impacts, energy - left
        step = min(times.values())
        x, t = [place + speed * step for place, speed in zip(x, v, strict=True)], t + step
        for j in pairs(w, [j for j, time in times.items() if time == step], lambda a, b: a == b):
            impulse = (1 + e) * w[j] * m[j] * m[j + 1] / (m[j] + m[j + 1])
            v[j] -= impulse / m[j]
            v[j + 1] += impulse / m[j + 1]
            impacts.append((t, j + 1))


def in_decimals(row):
    """The same, by gaps and approach speeds."""
    m, x, v, gap = ([Decimal(value) for value in row[name]] for name in ("mass", "x", "v", "gap"))
    e, t, impacts, contacts = Decimal(row["damping"]), Decimal(0), [], range(len(m) - 1)
    far = [x[j + 1] + gap[j] - x[j] for j in contacts]
    w = [v[j] - v[j + 1] for j in contacts]
    momentum, lost, zero = sum(a * b for a, b in zip(m, v, strict=True)), Decimal(0), Decimal("1e-45")
    while any(speed > zero for speed in w):
        step = min(max(far[j], Decimal(0)) / w[j] for j in contacts if w[j] > zero)
        far, t = [f - speed * step for f, speed in zip(far, w, strict=True)], t + step
        touching = [j for j in contacts if w[j] > zero and far[j] < zero]
        for j in pairs(w, touching, lambda a, b: abs(a - b) < zero):
            reduced, before = m[j] * m[j + 1] / (m[j] + m[j + 1]), w[j]
            lost += reduced * before * before * (1 - e * e) / 2
            impulse, w[j] = (1 + e) * reduced * before, -e * before
            if j > 0:
                w[j - 1] += impulse / m[j]
            if j + 1 < len(w):
                w[j + 1] += impulse / m[j + 1]
            impacts.append((t, j + 1))
    behind = [sum(w[:i], Decimal(0)) for i in range(len(m))]  # by which a ball is slower than the first
    first = (momentum + sum(a * b for a, b in zip(m, behind, strict=True))) / sum(m)
    return [first - b for b in behind], impacts, lost
