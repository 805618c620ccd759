"""Results for chains of viscoelastic balls in touch, struck by the first, in 35 digits: viscoelastic.json.

    pip install mpmath
    python tests/data/viscoelastic.py > tests/data/viscoelastic.json

Units as in reference.json: K = d_ref = 1, the striker's velocity 1, no gravity. Gauss collocation by Picard
iteration, on steps that double from 1e-22 after each onset and stay away from where an overlap vanishes: the force is
not analytic there.
Switchings end steps.
"""

import json
from functools import partial

from mpmath import findroot, mp, mpf, nstr

mp.dps = 35
NODES = 20
FIRST, LONGEST, PART = mpf("1e-22"), mpf("0.15"), mpf("0.4")

# Masses, exponent, relaxation time.
CASES = [
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


def legendre(x: mpf) -> list[mpf]:
    """Legendre's polynomials up to that of degree NODES."""
    p = [mpf(1), x]
    for n in range(1, NODES):
        p.append(((2 * n + 1) * x * p[n] - n * p[n - 1]) / (n + 1))
    return p


def nodes() -> tuple[list[list[mpf]], list[mpf]]:
    """Of Gauss's nodes on [0, 1]: the integrals of Lagrange's polynomials up to each node, and the weights."""
    values = []
    for i in range(NODES):
        x = -mp.cos(mp.pi * (i + mpf(3) / 4) / (NODES + mpf(1) / 2))
        for _ in range(8):
            *_, before, last = legendre(x)
            x -= last * (x * x - 1) / (NODES * (x * last - before))
        values.append(legendre(x))
    weights = [1 / sum((2 * n + 1) * p[n] ** 2 for n in range(NODES)) for p in values]

    def integral(i: int, q: list[mpf]) -> mpf:
        """Of the polynomial of node `i`, up to where Legendre's polynomials are `q`."""
        terms = (values[i][n] * (q[n + 1] - q[n - 1]) for n in range(1, NODES))
        return weights[i] * (1 + q[1] + sum(terms)) / 2

    return [[integral(i, q) for i in range(NODES)] for q in values], weights


with mp.workdps(50):
    INTEGRALS, WEIGHTS = nodes()


class Chain:
    def __init__(self, masses: list[float], exponent: float, relaxation: float) -> None:
        self.masses, self.p, self.a = [mpf(m) for m in masses], mpf(exponent), mpf(relaxation)
        self.v = [mpf(0)] * len(masses)
        self.v[0] = mpf(1)
        self.d = [mpf(0)] * (len(masses) - 1)
        self.modes = ["pressing"] * len(self.d)
        self.t, self.age, self.last = mpf(0), mpf(0), mpf(0)

    def sign(self, d: mpf, rate: mpf) -> mpf:
        """What has the sign of the force."""
        return d + self.p * self.a * rate

    def accelerations(self, v: list[mpf], d: list[mpf]) -> list[mpf]:
        forces = [mpf(0)]
        for j, mode in enumerate(self.modes):
            pressing = mode == "pressing" and d[j] > 0
            power = (d[j] * mp.sqrt(d[j]) if self.p == 1.5 else d[j] ** self.p) if pressing else mpf(0)
            forces.append(power * self.sign(d[j], v[j] - v[j + 1]) / d[j] if pressing else mpf(0))
        forces.append(mpf(0))
        return [(forces[i] - forces[i + 1]) / m for i, m in enumerate(self.masses)]

    def step(self, h: mpf) -> tuple[list[mpf], list[mpf]]:
        """Velocities and overlaps at the end of a step."""
        n = len(self.v)
        at = [
            (self.v, [d + h * c * (self.v[j] - self.v[j + 1]) for j, d in enumerate(self.d)])
            for c in map(sum, INTEGRALS)
        ]
        change = mpf(1)
        while change > mpf("1e-33"):
            a = [self.accelerations(v, d) for v, d in at]
            columns = [[row[i] for row in a] for i in range(n)]
            v = [[self.v[i] + h * mp.fdot(row, columns[i]) for i in range(n)] for row in INTEGRALS]
            rates = [[w[j] - w[j + 1] for w in v] for j in range(n - 1)]
            d = [[self.d[j] + h * mp.fdot(row, rates[j]) for j in range(n - 1)] for row in INTEGRALS]
            change = max(
                abs(new - old) for w, (u, _) in zip(v, at, strict=True) for new, old in zip(w, u, strict=True)
            )
            at = list(zip(v, d, strict=True))
        a = [self.accelerations(v, d) for v, d in at]
        v = [self.v[i] + h * mp.fdot(WEIGHTS, [row[i] for row in a]) for i in range(n)]
        d = [self.d[j] + h * mp.fdot(WEIGHTS, [w[j] - w[j + 1] for w, _ in at]) for j in range(n - 1)]
        return v, d

    def length(self) -> mpf:
        h = min(LONGEST, self.age if self.age > 0 else FIRST)
        for j, d in enumerate(self.d):
            rate = self.v[j] - self.v[j + 1]
            if self.modes[j] == "pressing" and d > 0 and rate < 0:
                h = min(h, PART * d / -rate)
        return h

    def switched(self, j: int, v: list[mpf], d: list[mpf]) -> mpf:
        """Positive once contact `j` is about to switch."""
        rate = v[j] - v[j + 1]
        return {"pressing": -self.sign(d[j], rate), "clipped": -d[j], "open": d[j]}[self.modes[j]]

    def sign_after(self, j: int, h: mpf) -> mpf:
        return self.switched(j, *self.step(h))

    def advance(self) -> None:
        h = self.length()
        v, d = self.step(h)
        due = [j for j in range(len(d)) if self.switched(j, v, d) > 0]
        first = None
        for j in due:
            ahead = partial(self.sign_after, j)
            time = findroot(ahead, (0, h), solver="anderson", tol=mpf("1e-60"))
            if first is None or time < first[0]:
                first = (time, j)
        if first is not None:
            h, j = first
            v, d = self.step(h)
        self.v, self.d, self.t, self.age = v, d, self.t + h, self.age + h
        for j in range(len(d)):
            assert self.modes[j] != "clipped" or self.sign(d[j], v[j] - v[j + 1]) <= 0
        if first is not None:
            self.switch(first[1])

    def switch(self, j: int) -> None:
        mode = {"pressing": "clipped", "clipped": "open", "open": "pressing"}[self.modes[j]]
        self.modes[j] = mode
        if mode != "clipped":
            self.d[j] = mpf(0)
        if mode == "open":
            self.last = self.t
        if mode == "pressing":
            self.age = mpf(0)

    def has_parted(self) -> bool:
        return all(mode == "open" for mode in self.modes) and self.v == sorted(self.v)


def main() -> None:
    results = []
    for masses, exponent, relaxation in CASES:
        chain = Chain(masses, exponent, relaxation)
        while not chain.has_parted():
            chain.advance()
        digits = [nstr(v, 20) for v in chain.v]
        results.append(
            {
                "masses": masses,
                "p": exponent,
                "A": relaxation,
                "v_final": digits,
                "duration": nstr(chain.last, 20),
            }
        )
    print(json.dumps(results, indent=1))


main()
