"""The cases of the benchmark by families: rows of balls and how they start, in doubles.

Gaps of 0 are rows in touch. Masses are 1 kg, stiffnesses 1 N/m^p and the first ball strikes at 1 m/s where nothing else
is said; the rows of steel have Hertz contacts between spheres.
"""

import itertools
import json
import math
import random
from pathlib import Path

STEEL = {"density": 7800.0, "youngModulus": 2.1e11, "poissonRatio": 0.3}
SICONOS = {"density": 7780.0, "youngModulus": 203.0e9, "poissonRatio": 0.3}  # of its tutorials' chains
# What their reference files hold behind the last impact: velocities in m/s.
PUBLISHED = json.loads(Path(__file__).with_name("published.json").read_text(encoding="utf-8"))
P = {1.5: "hertz", 1.0: "linear", 2.0: "square", 3.0: "cubic"}

DAMPED = {  # name of a case after its law: number of balls, exponent, coefficient
    "kelvinVoigt": ("kv", [(2, 1.0, 0.2), (5, 1.0, 0.1), (3, 2.0, 0.1)]),
    "kelvinVoigtNoPull": ("kv-no-pull", [(2, 1.0, 0.2), (5, 1.0, 0.1)]),
    "huntCrossley": ("hc", [(2, 1.5, 0.3), (5, 1.5, 0.1), (5, 1.0, 0.2), (10, 1.5, 0.05)]),
    "viscoelastic": ("ve", [(2, 1.5, 0.2), (5, 1.5, 0.1), (10, 1.5, 0.05)]),
}


def case(name, text, mass, *, p=1.5, k=1.0, gap=0.0, v=(1.0,), x=(), law="elastic", damping=0.0, **more):
    """A case; what is shorter than the row is continued: numbers by themselves, lists by 0. Rigid: p, k are None."""
    n = len(mass)

    def whole(values, length):
        values = values if isinstance(values, (list, tuple)) else [values] * length
        return [float(value) for value in [*values, *[0.0] * (length - len(values))]]

    row = {"name": name, "family": name.split("-")[0], "text": text, "n": n, "law": law, "exponent": p}
    row |= {"damping": damping, "g_over_length": 0.0, "stop": 0.0} | more
    row |= {"mass": whole(mass, n), "stiffness": k and whole(k, n - 1), "gap": whole(gap, n - 1)}
    return row | {"x": whole(x, n), "v": whole(v, n)}


def steel(name, text, radii, material=STEEL, **more):
    """A row of spheres (radii in m) with Hertz contacts."""
    e = material["youngModulus"] / (2.0 * (1.0 - material["poissonRatio"] ** 2))
    stiffness = [4.0 / 3.0 * e * math.sqrt(a * b / (a + b)) for a, b in itertools.pairwise(radii)]
    mass = [4.0 / 3.0 * math.pi * r**3 * material["density"] for r in radii]
    return case(name, text, mass, k=stiffness, radius=radii, material=material, **more)


def everything():
    """All cases, in their order."""
    ones = [1.0] * 5
    # Equal balls in touch.
    for n, (p, name) in itertools.product((2, 3, 5, 10), P.items()):
        yield case(f"equal-{n}-{name}", f"{n} balls, F = overlap^{p:g}", [1.0] * n, p=p)
    yield case("equal-5-two-strike", "two of five balls strike the others", ones, v=(1.0, 1.0))
    yield case("equal-6-both-ends", "both ends of six balls strike", [1.0] * 6, v=(1, 0, 0, 0, 0, -1))
    yield steel("equal-5-steel", "five equal steel balls", [0.0313] * 5, v=(0.5,))
    text = "a pulse through 50 balls; the last is 0.5 m apart and tells its arrival"
    yield case("equal-50-cubic", text, [1.0] * 50, p=3.0, gap=[0.0] * 48 + [0.5])

    # Apart, by less and by more than their overlaps.
    for p, name in P.items():
        yield case(f"apart-5-{name}", "0.1 m apart: pulses overlap", ones, p=p, gap=0.1)
    yield case("apart-5-wide", "2 m apart: one impact after the other", ones, gap=2.0, stop=21.0)
    yield case("apart-5-just", "just apart, by a hundred-thousandth of the overlaps", ones, gap=1e-5)
    yield case("apart-5-mixed", "gaps of 0.3, 0 and 1.5 m", ones, gap=[0.3, 0.0, 0.0, 1.5], v=(1.0, 0.5))

    # Each ball smaller, or larger, than the one before; in touch.
    for n, q in ((5, 0.9), (10, 0.95), (20, 0.95), (10, 1.05)):
        name, text = "hertz" if q < 1 else "growing", f"{n} steel balls, each {q:g} of the one before"
        yield steel(f"tapered-{n}-{name}", text, [0.0313 * q**i for i in range(n)])
    text = "masses fall by a thousandth, 2 m apart: 999 impacts of two, one after the other"
    yield case("tapered-1000-wide", text, [0.999**i for i in range(1000)], gap=2.0)
    text = "masses fall by the square root of 2, F = overlap"
    yield case("tapered-8-linear", text, [2.0 ** -(i / 2) for i in range(8)], p=1.0)

    # Two sizes, one after the other; in touch. Then large balls with small ones between.
    for name, radii in (("down", [0.04] * 5 + [0.02] * 5), ("up", [0.02] * 5 + [0.04] * 5)):
        yield steel(f"stepped-10-{name}", f"ten steel balls, a step {name} in size", radii)
    yield case("stepped-6-cubic", "three balls of 1 kg, then three of 0.25 kg", [1] * 3 + [0.25] * 3, p=3.0)
    for n in (7, 21):
        text = f"{n} steel balls in touch, every other half as large"
        yield steel(f"decorated-{n}-hertz", text, [0.03, 0.015] * (n // 2) + [0.03])
    text = "masses 1 and 0.2 kg by turns, 0.01 m apart"
    yield case("decorated-5-linear", text, [1.0, 0.2, 1.0, 0.2, 1.0], p=1.0, gap=0.01)

    # Unequal masses, stiffnesses and gaps; by seeds whose balls part early, as slow late impacts tell roundings.
    for n, p, seed in ((5, 1.0, 21), (8, 1.5, 48), (8, 2.0, 390), (12, 3.0, 7)):
        rng = random.Random(seed)
        limits = [(0.4, 2.5, n), (0.5, 2.0, n - 1), (0.01, 1.5, n - 1), (0.8, 1.2, 1), (0.2, 0.6, 1)]
        mass, k, gap, *ends = ([round(rng.uniform(a, b), 3) for _ in range(count)] for a, b, count in limits)
        more = {"k": k, "gap": gap, "v": [*ends[0], *[0.0] * (n - 2), -ends[1][0]]}
        yield case(f"random-{n}-{P[p]}", "random masses, stiffnesses and gaps", mass, p=p, **more)

    # Equal balls whose contacts lose energy.
    for law, (short, rows) in DAMPED.items():
        for n, p, damping in rows:
            gap = 0.2 if n == 3 or law == "viscoelastic" else 0.0
            text = f"{n} balls {'0.2 m apart' if gap else 'in touch'}, {law}"
            name = f"damped-{n}-{short}-{P[p]}"
            yield case(name, text, [1.0] * n, p=p, law=law, damping=damping, gap=gap)

    # Instantaneous impacts of two, one after the other, with a coefficient of restitution e.
    more = {"law": "restitution", "p": None, "k": None}
    yield case("rigid-5-equal", "five equal balls in touch, e = 1", ones, damping=1.0, **more)
    yield case("rigid-5-lossy", "five equal balls in touch, e = 0.9", ones, damping=0.9, **more)
    yield case("rigid-3-unequal", "masses 1, 2 and 4 kg in touch, e = 0.75", [1, 2, 4], damping=0.75, **more)
    text = "a light ball between two heavy ones, e = 1: it goes to and fro"
    yield case("rigid-3-light", text, [4.0, 0.25, 4.0], damping=1.0, gap=0.5, **more)
    rng = random.Random(12)
    mass, gap = [rng.randint(2, 16) / 8 for _ in range(8)], [rng.randint(1, 16) / 8 for _ in range(7)]
    more |= {"gap": gap, "v": [1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, -0.75]}
    yield case("rigid-8-random", "random masses and gaps, e = 0.9375", mass, damping=0.9375, **more)

    # The chains of ten balls in the Siconos tutorials: the first strikes over 0.2 m at 1 m/s.
    more, radii = {"material": SICONOS, "x": [-0.2]}, [0.95 ** (i + 1) * 0.01 for i in range(10)]
    text, (equal, tapered) = "ten equal steel balls, nine in touch", PUBLISHED.values()
    yield steel("siconos-monodisperse", text, [0.01] * 10, published=equal, **more)
    yield steel("siconos-tapered", "ten tapered steel balls, nine in touch", radii, **more)
    text = "the same, but each contact closes at the distance of the last pair, as in the published result"
    more |= {"gap": [a + b - (radii[8] + radii[9]) for a, b in itertools.pairwise(radii)], "stop": 0.579}
    yield steel("siconos-tapered-as-run", text, radii, published=tapered, **more)

    # Five balls of 1 kg on linear pendulums with g/L = 5 1/s2; the state halfway between two clicks.
    k = steel("", "", [0.0313] * 5)["stiffness"]
    for clicks in (1, 10, 100):
        more = {"v": (), "g_over_length": 5.0, "stop": round(clicks * math.pi / math.sqrt(5.0), 3)}
        text = f"this project's default cradle, two balls lifted: the state after click {clicks}"
        yield case(f"cradle-{clicks}", text, ones, k=1e10, gap=2.6e-6, p=1.0, x=(-0.1, -0.1), **more)
        text = f"steel balls in touch, Hertz contacts, one lifted: the state after click {clicks}"
        if clicks < 100:
            yield case(f"cradle-{clicks}-steel", text, ones, k=k, x=(-0.05,), **more)
