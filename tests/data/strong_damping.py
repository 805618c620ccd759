"""Computes the results in strong_damping.json, `x`, `v` and `switchings` of cradles with linear contacts, damped or
pressed, by matrix exponentials in 40 digits.

    pip install mpmath
    python tests/data/strong_damping.py

A new case is an entry there with the other fields. Where balls are pressed, they start closer than the forces hold
them, and ring.

Between two switchings the equations are linear with constant coefficients: the motion is a sum of exponentials of the
eigenvalues, whatever the damping. The first switching is looked for on a grid that is fine at first, then by bisection.
"""

import json
from functools import cache
from pathlib import Path

from mpmath import diag, eig, exp, eye, fdot, inverse, linspace, matrix, mp, mpf, nstr, re, zeros

mp.dps = 40
# What is not more is rounding: balls side by side do not approach.
NOISE = mpf("1e-30")
GRAVITY, LENGTH = mpf(9.81), mpf(1.962)


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


def run(balls, start, stiffness, damping, dead_band, pull, time, masses=(), springs=(), press=0.0, **_results):
    """Positions, velocities and the number of switchings up to `time`. The state is x, v and 1; overlaps and forces are
    rows times it."""
    n, unit = balls, eye(2 * balls + 1)
    masses, springs = masses or [1.0] * n, springs or [1.0] * (n - 1)
    x, v, one = [unit[i, :] for i in range(n)], [unit[n + i, :] for i in range(n)], unit[2 * n, :]
    overlap = [x[j] - x[j + 1] - mpf(dead_band) * one for j in range(n - 1)]
    force = [stiffness * springs[j] * overlap[j] + mpf(damping) * (v[j] - v[j + 1]) for j in range(n - 1)]

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
    rest, switchings = mpf(time), modes.count("pressing")
    while rest > 0:
        rates, vectors, backwards = motion(*modes)
        amplitudes = diag(backwards * state)

        def course(row, rates=rates, of_state=vectors * amplitudes):
            weights = row * of_state
            return lambda t: re(fdot(weights, (exp(rate * t) for rate in rates)))

        until, switch = rest, None
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
        rest -= until
        if switch:
            modes[switch[0]] = switch[1]
            switchings += 1
    return state[:n], state[n : 2 * n], switchings


def main():
    path = Path(__file__).with_suffix(".json")
    cases = json.loads(path.read_text())
    for case in cases:
        x, v, case["switchings"] = run(**case)
        case |= {"x": [nstr(value, 20) for value in x], "v": [nstr(value, 20) for value in v]}
    path.write_text(json.dumps(cases, indent=1) + "\n")


if __name__ == "__main__":
    main()
