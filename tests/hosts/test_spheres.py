"""Spheres of given sizes and materials: start values, and impacts of two against Hertz."""

import math

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT
from newtons_cradle.materials import MATERIALS

PUBLISHED = (ROOT / "docs/makers/exact-rows.md").read_text(encoding="utf-8")


def pulse_of_two(fmu, values: dict, v: float):
    """The pulse of balls 2 and 3, the others far away, one of which is struck at v."""
    free = {
        "gravity": 0.0,
        "contact.gap": [1.0, 0.0, 1.0, 1.0],
        "x_start": [0.0] * 5,
        "v_start": [0.0, v, 0.0, 0.0, 0.0],
    }
    (pulse,) = fmu.simulate(values | free, stop=0.01, step=0.01, record=[]).pulses
    return pulse


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("other", ["steel", "lead", "cork"])
def test_spheres_of_any_materials_meet_as_hertz_says(fmu, material, other):
    """Johnson, Contact Mechanics, 1985, section 11.4, with a Poisson's ratio for each: to 1e-13."""
    v, radii, materials = 0.3, [0.02, 0.011, 0.004, 0.02, 0.02], ["glass", material, other, "brass", "glass"]
    pulse = pulse_of_two(fmu, nc.spheres(radii, materials), v)
    left, right = (MATERIALS[name] for name in materials[1:3])
    compliance = sum((1.0 - one.poisson_ratio**2) / one.young_modulus for one in (left, right))
    stiffness = 4.0 / 3.0 / compliance / math.sqrt(1.0 / radii[1] + 1.0 / radii[2])
    m, n = (4.0 / 3.0 * math.pi * one.density * r**3 for one, r in zip((left, right), radii[1:3], strict=True))
    mass = m * n / (m + n)
    deepest = (1.25 * mass * v**2 / stiffness) ** 0.4
    duration = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9) * deepest / v
    assert pulse["onset"] == 0.0
    assert pulse["release"] == pytest.approx(duration, rel=1e-13)
    assert pulse["peak"] == pytest.approx(stiffness * deepest**1.5, rel=1e-13)
    assert pulse["impulse"] == pytest.approx(2.0 * mass * v, rel=1e-13)


def test_spheres_start_values():
    """One value for all balls or one for each; of equal spheres all ratios are 1."""
    equal = nc.spheres(0.0313)
    assert equal == nc.spheres([0.0313] * 5, ["steel"] * 5) == nc.spheres(0.0313, n=5)
    assert all(value == 1.0 for name, value in equal.items() if "Ratio[" in name)
    own = {"ball.radius": 0.0313, "ball.youngModulus": 2.1e11, "ball.poissonRatio": 0.3, "contact.model": "hertz"}
    assert own.items() <= equal.items() and equal["ball.mass"] == pytest.approx(1.0083, abs=1e-4)
    mixed = nc.spheres(np.array([0.01, 0.02]), density=[8000, 1000], young_modulus=1e9, poisson_ratio=[0.3, 0.5])
    assert mixed["ball.massRatio[2]"] == pytest.approx(1.0, rel=1e-15) and mixed["ball.radiusRatio[2]"] == 2.0
    assert mixed["ball.youngModulusRatio[2]"] == pytest.approx(0.91 / 0.75, rel=1e-15)
    assert len(nc.spheres(0.01, n=3)) == 3 + 3 * 4 and "ball.massRatio[7]" in nc.spheres(0.01, 7 * ["glass"])


@pytest.mark.parametrize(
    ("preset", "radii", "materials"),
    [
        ("tapered", [0.015 * 0.8**i for i in range(5)], "steel"),
        ("unlike", 0.011, ["steel", "steel", "lead", "steel", "steel"]),
        ("desk", 0.011, "steel"),
        ("clay", 0.011, "steel"),
    ],
)
def test_spheres_of_the_presets(preset, radii, materials):
    of_preset = nc.preset(preset)
    for name, value in nc.spheres(radii, materials).items():
        assert of_preset.get(name, 1.0) == (pytest.approx(value, rel=1e-4) if name != "contact.model" else value), name


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (((0.01,), "steal"), "material = 'steal' is refused; allowed: steel, brass, .*; did you mean steel?"),
        ((0.01, [1.0]), "material: one of steel, brass, .* is needed, not 1.0"),
        (([0.01, -0.01],), r"radii\[2\] = -0.01 is refused; allowed: a positive number \(m\)"),
        (("0.01",), r"radii = '0.01' is refused; allowed: a positive number \(m\)"),
        (([0.01] * 3, ["lead"] * 2), r"3 value\(s\) of radii and 2 value\(s\) of material are refused; allowed: one"),
        (([],), "number of balls = 0 is refused"),
    ],
)
def test_spheres_that_cannot_be_are_refused_in_words(arguments, complaint):
    with pytest.raises(nc.InvalidValue, match=complaint):
        nc.spheres(*arguments)
    with pytest.raises(nc.InvalidValue, match="n = 3 and 2 value"):
        nc.spheres([0.01, 0.02], n=3)
    with pytest.raises(nc.InvalidValue, match=r"poisson_ratio = 0.6 is refused; .* at least 0, at most 0.5"):
        nc.spheres(0.01, poisson_ratio=0.6)


def struck(cradle, fmu_path, radii: list[float], gap: float, stop: float):
    """The run of free steel spheres, the first at 1 m/s, until a time (s)."""
    n = len(radii)
    free = {"gravity": 0.0, "x_start": [0.0] * n, "v_start": [1.0] + [0.0] * (n - 1), "contact.gap": [gap] * (n - 1)}
    fmu = cradle(balls=n, binaries=fmu_path)
    return fmu.simulate(nc.spheres(radii) | free, times=[0.0, stop], record=["v", "F_peak"])


def test_spheres_in_published_tapered_rows(cradle, fmu_path):
    """The energy of the last ball over that of the first: of hard spheres by Doney and Sen, apart, in touch."""
    found = []
    for n, q in [(5, 0.05), (10, 0.05), (10, 0.1), (20, 0.05), (20, 0.1)]:
        radii = [0.0127 * (1.0 - q) ** i for i in range(n)]
        ratio = (1.0 - q) ** 3
        hard = (4.0 * ratio / (1.0 + ratio) ** 2) ** (n - 1)
        apart, touching = (
            ratio ** (n - 1) * struck(cradle, fmu_path, radii, *run)["v"][-1, -1] ** 2
            for run in [(1e-3, 0.1), (0, 0.02)]
        )
        assert apart == pytest.approx(hard, rel=1e-14)
        found.append(f"| {n} | {q} | {hard:.6f} | {touching:.6f} |")
    assert "\n".join(found) in PUBLISHED


@pytest.mark.all
@pytest.mark.parametrize("published", [0.3428, 0.1548, 0.0901])
def test_spheres_in_published_decorated_rows(cradle, fmu_path, published):
    """Mass ratios at which a pulse becomes a solitary wave, by Jayaprakash, Starosvetsky and Vakakis."""

    def lost(ratio: float) -> float:
        radii = [0.0127, 0.0127 * ratio ** (1.0 / 3.0)] * 100 + [0.0127]
        peak = struck(cradle, fmu_path, radii, 0.0, 0.012)["F_peak"][-1]
        return 1.0 - peak[180] / peak[100]

    at, below, above = (lost(published + change) for change in (0.0, -5e-4, 5e-4))
    (row,) = [line for line in PUBLISHED.splitlines() if line.startswith(f"| {published} |")]
    assert row.startswith(f"| {published} | {at:.1e} | {below:.1e} | {above:.1e} | ")
    best = float(row.split("|")[5])
    assert abs(best - published) <= 5.01e-5 and lost(best) < 1e-3 * below


def test_spheres_table_of_the_documents_is_that_of_the_package():
    text = (ROOT / "docs/python.md").read_text(encoding="utf-8")
    for name, (density, modulus, poisson_ratio, source) in MATERIALS.items():
        assert f"| `{name}` | {density:g} | {modulus / 1e9:g} | {poisson_ratio:g} | {source} |" in text
