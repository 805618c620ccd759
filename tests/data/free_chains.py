"""Results for free chains with contacts that are not linear, elastic or damped, by Taylor series in 40 digits:
free_chains.json.

    pip install gmpy2
    python tests/data/free_chains.py > tests/data/free_chains.json     # half a minute

Units are those of a stiffness, a mass and a speed of 1. A force law that is not analytic where a contact opens or
closes has a series no further than to there, so steps shrink towards it and grow from it. Forces at overlaps below
LEAST are left out: what they would do to a velocity is below 1e-26.
"""

import json
import random
from itertools import pairwise

from gmpy2 import get_context, mpfr, root

get_context().precision = 140  # bits
ORDER = 40
LEAST = mpfr("1e-18")
ERROR = mpfr("1e-30")  # of a velocity in one step
LAWS = ("none", "huntCrossley", "viscoelastic")
EXPONENTS = (1.5, 2.5, 1.7)


class Contact:
    """One contact: open, pressing, or clipped, where the force would pull."""

    def __init__(self, law, p, coefficient, gap):
        self.law, self.p, self.coefficient, self.gap = law, mpfr(p), mpfr(coefficient), mpfr(gap)
        self.mode = "open"

    def begin(self, d):
        """To be called with the overlap's series while it grows by one coefficient after the other."""
        self.d, self.power = d, [d[0] ** self.p]

    def force(self, k):
        """Coefficient `k` of the force: those of the overlap must be known up to k + 1."""
        if self.mode != "pressing":
            return mpfr(0)
        while len(self.power) < k + 2:  # J. C. P. Miller's recursion
            n = len(self.power)
            terms = (((self.p + 1) * i - n) * self.d[i] * self.power[n - i] for i in range(1, n + 1))
            self.power.append(sum(terms) / (n * self.d[0]))
        force = self.power[k]
        if self.law == "huntCrossley":
            force += self.coefficient * sum((i + 1) * self.d[i + 1] * self.power[k - i] for i in range(k + 1))
        elif self.law == "viscoelastic":
            force += self.coefficient * (k + 1) * self.power[k + 1]
        return force

    def switches(self):
        """Series that end a mode where they become positive, each with the mode that follows."""
        d, rate = self.d, [(k + 1) * c for k, c in enumerate(self.d[1:])]
        if self.mode == "open":
            return [([d[0] - LEAST, *d[1:]], "pressing")]
        switches = [([LEAST - d[0], *(-c for c in d[1:])], "open")]
        # The force without its factors that are positive.
        if self.law == "huntCrossley":
            sign = [1 + self.coefficient * rate[0], *(self.coefficient * c for c in rate[1:])]
        elif self.law == "viscoelastic":
            sign = [c + self.coefficient * self.p * r for c, r in zip(d, rate, strict=False)]
        else:
            return switches
        if self.mode == "pressing":
            return [*switches, ([-c for c in sign], "clipped")]
        return [*switches, (sign, "pressing")]


def value(series, t):
    total = mpfr(0)
    for c in reversed(series):
        total = total * t + c
    return total


def first_positive(series, until):
    """The first time up to `until` at which a series becomes positive, or None."""
    before, pieces = mpfr(0), 16
    for piece in range(1, pieces + 1):
        after = until * piece / pieces
        if value(series, after) > 0:
            if value(series, before) > 0:
                return before
            for _ in range(150):
                middle = (before + after) / 2
                before, after = (before, middle) if value(series, middle) > 0 else (middle, after)
            return after
        before = after
    return None


def series(x, v, masses, contacts):
    """The positions' Taylor coefficients."""
    n = len(x)
    motion = [[x[i], v[i]] for i in range(n)]
    overlaps = [[x[j] - x[j + 1] - contacts[j].gap, v[j] - v[j + 1]] for j in range(n - 1)]
    for contact, d in zip(contacts, overlaps, strict=True):
        contact.begin(d)
    for k in range(ORDER - 1):
        forces = [mpfr(0), *(contact.force(k) for contact in contacts), mpfr(0)]
        for i in range(n):
            motion[i].append((forces[i] - forces[i + 1]) / (masses[i] * (k + 1) * (k + 2)))
        for j, d in enumerate(overlaps):
            d.append(motion[j][-1] - motion[j + 1][-1])
    return motion


def run(masses, v, contacts):
    """Velocities and the time when all have come apart, and the time of the last release."""
    x, t, released = [mpfr(0)] * len(v), mpfr(0), mpfr(0)
    while True:
        apart = all(contact.mode == "open" for contact in contacts)
        if apart and all(left <= right for left, right in pairwise(v)):
            return v, released
        motion = series(x, v, masses, contacts)
        last = max(abs(c) for ball in motion for c in ball[-2:])
        step = root(ERROR / (ORDER * last), ORDER - 1) if last > 0 else mpfr(1)
        found = []
        for contact in contacts:
            for switch, mode in contact.switches():
                at = first_positive(switch, step)
                if at is not None:
                    found.append((at, contact, mode))
        if found:
            step = min(at for at, _, _ in found)
        x, v = (
            [value(ball, step) for ball in motion],
            [value([(k + 1) * c for k, c in enumerate(ball[1:])], step) for ball in motion],
        )
        t += step
        for at, contact, mode in found:
            if at == step:
                contact.mode = mode
                if mode == "open":
                    released = t


# Viscoelastic chains in touch, struck by the first ball at a speed of 1: masses, exponent, coefficient.
IN_TOUCH = [
    ([1, 1], 1.5, 1e-3),
    ([1, 1], 1.5, 0.25),
    ([1, 3], 1.5, 4.0),
    ([1, 1], 2.0, 0.25),
    ([2, 1], 2.5, 0.5),
    ([1, 1], 3.7, 0.125),
    ([1, 1, 1], 1.5, 0.125),
    ([1, 1, 1, 1, 1], 1.5, 0.03125),
    ([1, 2, 0.5], 1.5, 0.25),
    ([1, 0.7, 1.3, 1], 2.5, 0.125),
    ([1, 1, 1], 3.0, 0.25),
]


def case(law, p, coefficient, masses, gaps, v):
    """A chain and what becomes of it."""
    contacts = [Contact(law, p, coefficient, gap) for gap in gaps]
    final, released = run([mpfr(m) for m in masses], [mpfr(u) for u in v], contacts)
    return {
        "law": law,
        "p": p,
        "coefficient": coefficient,
        "masses": masses,
        "gaps": gaps,
        "v": v,
        "v_final": [f"{u:.20e}" for u in final],
        "duration": f"{released:.20e}",
    }


def random_case(rng, law, p):
    """A random chain: unequal masses, gaps, one or two balls that strike."""
    n = rng.randint(2, 5)
    coefficient = {
        "none": 0.0,
        "huntCrossley": rng.uniform(0.05, 0.6),
        "viscoelastic": rng.uniform(0.02, 0.4),
    }[law]
    masses = [round(rng.uniform(0.4, 2.5), 3) for _ in range(n)]
    gaps = [round(rng.uniform(0.01, 1.5), 3) for _ in range(n - 1)]
    v = [round(rng.uniform(0.5, 1.5), 3)] + [0.0] * (n - 1)
    if n > 3:
        v[-1] = -round(rng.uniform(0.0, 1.0), 3)
    return case(law, p, coefficient, masses, gaps, v)


if __name__ == "__main__":
    rng = random.Random(2002)
    cases = [random_case(rng, law, p) for law in LAWS for p in EXPONENTS for _ in range(4)]
    for masses, p, coefficient in IN_TOUCH:
        rest = [0.0] * (len(masses) - 1)
        cases.append(case("viscoelastic", p, coefficient, masses, rest, [1.0, *rest]))
    print(json.dumps(cases, indent=1))
