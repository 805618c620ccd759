"""Results for cradles with linear contacts, damped or pressed, by matrix exponentials in 40 digits:
strong_damping.json.

    pip install mpmath
    python tests/data/strong_damping.py > tests/data/strong_damping.json

Between two switchings the equations are linear with constant coefficients: the motion is a sum of exponentials of the
eigenvalues, whatever the damping. The first switching is looked for on a grid that is fine at first, then by bisection.
"""

import json
from functools import cache

from mpmath import diag, eig, exp, eye, fdot, inverse, linspace, matrix, mp, mpf, nstr, re, zeros

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


def first_positive(function, until):
    """The first time at which `function` becomes positive, `until` if it does not before."""
    before, coarse = mpf(0), linspace(until / 300, until, 300)
    fine = [mpf("1e-14") * mpf(2) ** (mpf(i) / 2) for i in range(110)]
    for t in [*(t for t in fine if t < coarse[0]), *coarse]:
        if function(t) > NOISE:
            while t - before > mpf(10) ** -36 * t:
                middle = (before + t) / 2
                before, t = (before, middle) if function(middle) > NOISE else (middle, t)
            return t
        before = t
    return until


def run(start, masses, springs, c, dead_band, press, pull, end):
    """Positions, velocities and the number of switchings up to `end`. The state is x, v and 1; overlaps and forces are
    rows times it."""
    n, unit = len(masses), eye(2 * len(masses) + 1)
    x, v, one = [unit[i, :] for i in range(n)], [unit[n + i, :] for i in range(n)], unit[2 * n, :]
    overlap = [x[j] - x[j + 1] - dead_band * one for j in range(n - 1)]
    force = [springs[j] * overlap[j] + c * (v[j] - v[j + 1]) for j in range(n - 1)]

    @cache
    def motion(*modes):
        """Eigenvalues and eigenvectors of the equations, and the inverse of these."""
        a = zeros(2 * n + 1)
        for i in range(n):
            a[i, :], a[n + i, :] = v[i], -GRAVITY / LENGTH * x[i]
        pushes = [(force[j], j, j + 1) for j, mode in enumerate(modes) if mode == "pressing"]
        for push, left, right in [*pushes, (press * one, n - 1, 0)]:
            a[n + left, :] -= push / masses[left]
            a[n + right, :] += push / masses[right]
        rates, vectors = eig(a)
        return rates, vectors, inverse(vectors)

    state = matrix([*start, *[0] * n, 1])
    modes = ["pressing" if (row * state)[0] > 0 else "open" for row in overlap]
    time, switchings = mpf(0), modes.count("pressing")
    while time < end:
        rates, vectors, backwards = motion(*modes)
        amplitudes = diag(backwards * state)

        def course(row, rates=rates, of_state=vectors * amplitudes):
            weights = row * of_state
            return lambda t: re(fdot(weights, (exp(rate * t) for rate in rates)))

        until, switch = end - time, None
        for j, mode in enumerate(modes):
            switches = {
                "open": [(overlap[j], "pressing")],
                "pressing": [(-overlap[j], "open")] + ([] if pull else [(-force[j], "clipped")]),
                "clipped": [(-overlap[j], "open"), (force[j], "pressing")],
            }
            for row, following in switches[mode]:
                if (t := first_positive(course(row), until)) < until:
                    until, switch = t, (j, following)
        state = matrix([course(row)(until) for row in [*x, *v, one]])
        time += until
        if switch:
            modes[switch[0]] = switch[1]
            switchings += 1
    return state[:n], state[n : 2 * n], switchings


def main():
    results = []
    for n, lifted, stiffness, times_critical, dead_band, pull, end, *unequal in CASES:
        damping = times_critical * 2.0 * (stiffness / 2.0) ** 0.5
        masses, ratios, press = (*unequal, *((1.0,) * n, (1.0,) * (n - 1), 0.0)[len(unequal) :])
        # Pressed balls start closer than the forces hold them, and ring.
        overlaps = [1.2 * press / (stiffness * ratio) for ratio in ratios]
        start = [-0.1 if i < lifted else 0.0 - sum(overlaps[:i]) for i in range(n)]
        case = {
            "balls": n,
            "start": start,
            "stiffness": stiffness,
            "damping": damping,
            "dead_band": dead_band,
        }
        case |= {"masses": masses, "springs": ratios, "press": press} if unequal else {}
        springs = [mpf(stiffness * ratio) for ratio in ratios]
        x, v, switchings = run(start, masses, springs, mpf(damping), mpf(dead_band), press, pull, mpf(end))
        case |= {"pull": pull, "time": end, "switchings": switchings}
        results.append(case | {"x": [nstr(value, 20) for value in x], "v": [nstr(value, 20) for value in v]})
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
