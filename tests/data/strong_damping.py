"""Results for cradles with linear contacts, damped or pressed, by matrix exponentials in 40 digits:
strong_damping.json.

    pip install mpmath
    python tests/data/strong_damping.py > tests/data/strong_damping.json

Between two switchings the equations are linear with constant coefficients: the motion is a sum of exponentials of the
eigenvalues, whatever the damping. The first switching is looked for on a grid that is fine at first, then by bisection.
"""

import json
from functools import cache, partial

from mpmath import eig, exp, inverse, lu_solve, matrix, mp, mpf, nstr, re, zeros

mp.dps = 40
# What is not more is rounding: balls side by side do not approach.
NOISE = mpf("1e-30")
GRAVITY, LENGTH = mpf(9.81), mpf(1.962)

# Balls, how many of them are lifted by 0.1 m, stiffness, times critical damping, dead band, may a contact pull, time;
# and where they are not those of equal balls without forces: ratios of the masses and of the stiffnesses, the force
# that presses the ends (N).
RATIOS = (1.0, 2.0, 1.0, 0.5, 1.0)
SPRINGS = (1.0, 3.0, 0.7, 1.4)
CASES = [
    (2, 1, 1e10, 1000, 2.6e-6, True, 3),
    (2, 1, 4.5e7, 1900, 1e-9, False, 3),
    (3, 1, 1e10, 1000, 0.0, False, 3),
    (4, 1, 1e10, 30, 1e-6, False, 4),
    (4, 2, 1e8, 0.4, 1e-6, True, 2),
    (5, 2, 1e10, 1000, 2.6e-6, True, 10),
    (5, 2, 1e10, 1000, 2.6e-6, False, 5),
    (5, 2, 1e10, 0.0003, 0.0, True, 2, RATIOS),
    (5, 2, 1e10, 0.5, 0.0, True, 2, RATIOS),
    (5, 2, 1e10, 2.0, 1e-6, False, 2, RATIOS),
    (5, 1, 1e10, 2.0, 1e-6, True, 3, RATIOS),
    (5, 2, 1e10, 1000, 2.6e-6, True, 3, RATIOS),
    (5, 1, 1e10, 1000, 0.0, False, 2, RATIOS),
    (5, 0, 1e10, 0.0003, 0.0, True, 0.05, RATIOS, (1.0,) * 4, 200.0),
    (5, 0, 1e10, 0.0, 0.0, True, 0.01, RATIOS, (1.0,) * 4, 200.0),
    (5, 0, 1e10, 0.0, 0.0, True, 0.01, RATIOS, SPRINGS, 200.0),
    (5, 0, 1e10, 0.0, 0.0, True, 0.01, (1.0,) * 5, SPRINGS, 200.0),
]


class Motion:
    """Everything linear while the contacts of `pressing` act."""

    def __init__(self, masses, springs, c, dead_band, press, pressing):
        n = len(masses)
        a, f = zeros(2 * n), zeros(2 * n, 1)
        for i in range(n):
            a[i, n + i] = 1
            a[n + i, i] = -GRAVITY / LENGTH
        f[n] += press / masses[0]
        f[2 * n - 1] -= press / masses[-1]
        for j in (j for j in range(n - 1) if pressing[j]):
            for ball, side in ((n + j, -1 / masses[j]), (n + j + 1, 1 / masses[j + 1])):
                k = springs[j]
                a[ball, j] += side * k
                a[ball, j + 1] -= side * k
                a[ball, n + j] += side * c
                a[ball, n + j + 1] -= side * c
                f[ball] -= side * k * dead_band
        self.rates, self.vectors = eig(a)
        self.backwards, self.equilibrium = inverse(self.vectors), lu_solve(a, -f)

    def course(self, state, row, more=0):
        """`row` times the state, and `more`, as a function of time."""
        amplitudes = self.backwards * (state - self.equilibrium)
        size = range(len(self.rates))
        weights = [amplitudes[m] * sum(row[i] * self.vectors[i, m] for i in row) for m in size]
        rest = sum(row[i] * self.equilibrium[i] for i in row) + more
        return lambda t: re(sum(weights[m] * exp(self.rates[m] * t) for m in size)) + rest

    def state(self, state, t):
        size = len(self.rates)
        return matrix([self.course(state, {i: 1})(t) for i in range(size)])


def first_positive(function, until):
    """The first time at which `function` becomes positive."""
    grid = [mpf("1e-14") * mpf(2) ** (mpf(i) / 2) for i in range(110)]
    grid = [t for t in grid if t < until / 300] + [until * i / mpf(300) for i in range(1, 301)]
    before = mpf(0)
    for t in grid:
        if function(t) > NOISE:
            while t - before > mpf(10) ** -36 * t:
                middle = (before + t) / 2
                before, t = (before, middle) if function(middle) > NOISE else (middle, t)
            return t
        before = t
    return None


def run(start, masses, springs, c, dead_band, press, pull, end):
    """Positions, velocities and the number of switchings up to `end`."""
    n, c, dead_band, press, end = len(masses), mpf(c), mpf(dead_band), mpf(press), mpf(end)
    state = matrix([mpf(x) for x in start] + [mpf(0)] * n)
    overlaps = [state[j] - state[j + 1] - dead_band for j in range(n - 1)]
    modes = ["pressing" if overlap > 0 else "open" for overlap in overlaps]
    time, switchings = mpf(0), modes.count("pressing")
    motion_of = cache(partial(Motion, masses, springs, c, dead_band, press))
    while time < end:
        motion = motion_of(tuple(mode == "pressing" for mode in modes))
        until, switch = end - time, None
        for j, mode in enumerate(modes):
            k = springs[j]
            overlap = {j: 1, j + 1: -1}, -dead_band
            force = {j: k, j + 1: -k, n + j: c, n + j + 1: -c}, -k * dead_band
            candidates = {
                "open": [(overlap, 1, "pressing")],
                "pressing": [(overlap, -1, "open")] + ([] if pull else [(force, -1, "clipped")]),
                "clipped": [(overlap, -1, "open"), (force, 1, "pressing")],
            }[mode]
            for (row, more), sign, following in candidates:
                course = motion.course(state, {i: sign * value for i, value in row.items()}, sign * more)
                t = first_positive(course, until)
                if t is not None and t < until:
                    until, switch = t, (j, following)
        state = motion.state(state, until)
        time += until
        if switch:
            modes[switch[0]] = switch[1]
            switchings += 1
    return list(state[:n]), list(state[n:]), switchings


def main():
    results = []
    for n, lifted, stiffness, times_critical, dead_band, pull, end, *unequal in CASES:
        damping = times_critical * 2.0 * (stiffness / 2.0) ** 0.5
        masses, ratios, press = (*unequal, *((1.0,) * n, (1.0,) * (n - 1), 0.0)[len(unequal) :])
        # Pressed balls start closer than the forces hold them, and ring.
        overlaps = [1.2 * press / (stiffness * ratio) for ratio in ratios]
        start = [-0.1 if i < lifted else 0.0 - sum(overlaps[:i]) for i in range(n)]
        springs = [mpf(stiffness * ratio) for ratio in ratios]
        x, v, switchings = run(start, [mpf(m) for m in masses], springs, damping, dead_band, press, pull, end)
        case = {
            "balls": n,
            "start": start,
            "stiffness": stiffness,
            "damping": damping,
            "dead_band": dead_band,
        }
        if unequal:
            case |= {"masses": masses, "springs": ratios, "press": press}
        digits = {"x": [nstr(value, 20) for value in x], "v": [nstr(value, 20) for value in v]}
        results.append({**case, "pull": pull, "time": end, "switchings": switchings, **digits})
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
