"""Start values for spheres of given sizes and materials."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from .errors import MOST_BALLS, InvalidValue, did_you_mean, needed, number, plain, whole
from .setups import Start, vector

Each = float | Sequence[float]  # one number for all balls, or one for each


class Material(NamedTuple):
    """Density (kg/m3), Young's modulus (Pa) and Poisson's ratio of an isotropic solid, and where they are from."""

    density: float
    young_modulus: float
    poisson_ratio: float
    source: str


_KAYE_LABY = "Kaye and Laby, 16th edition, 1995"  # Tables of Physical and Chemical Constants
_CRC = "CRC Handbook of Chemistry and Physics"  # densities of various solids

#: Typical values: those of a batch differ by some percent, of natural materials by half.
MATERIALS = {
    "steel": Material(7850.0, 2.1e11, 0.3, "EN 1993-1-1, 3.2.6, and EN 1991-1-1, table A.4; the FMU's defaults"),
    "brass": Material(8500.0, 1.006e11, 0.35, f"70 Cu, 30 Zn: {_KAYE_LABY}"),
    "aluminium": Material(2700.0, 7.03e10, 0.345, _KAYE_LABY),
    "lead": Material(11340.0, 1.61e10, 0.44, _KAYE_LABY),
    "glass": Material(2500.0, 7.13e10, 0.22, f"crown: {_KAYE_LABY}"),
    "ivory": Material(1880.0, 1e10, 0.3, f"density: {_CRC}; elastic constants: estimates, of dry dentine"),
    "cork": Material(170.0, 2e7, 0.0, "Gibson, Easterling and Ashby, Proc. R. Soc. A 377 (1981) 99: along the radius"),
    "rubber": Material(930.0, 1.2e6, 0.5, f"shear modulus: Treloar, Trans. Faraday Soc. 40 (1944) 59; density: {_CRC}"),
}


def spheres(
    radii: Each,
    material: str | Sequence[str] = "steel",
    *,
    density: Each | None = None,
    young_modulus: Each | None = None,
    poisson_ratio: Each | None = None,
    n: int | None = None,
) -> Start:
    """Solid spheres in touch, with Hertz contacts: start values of masses, radii and elastic constants.

    `nc.spheres([0.011, 0.008, 0.011], ["steel", "lead", "steel"])`. Each argument is one value for all balls, or a list
    with one for each; `n`: how many there are if none is a list, else 5. `radii`: m; `material`: a name in
    `newtons_cradle.materials.MATERIALS`, whose values `density` (kg/m3), `young_modulus` (Pa) and `poisson_ratio`
    replace. Raises InvalidValue.

    The FMU has one Poisson's ratio for all balls, that of the first. The moduli of the others are multiplied by
    (1 - nu_1^2) / (1 - nu_i^2): a contact depends on E / (1 - nu^2) of both balls alone, which are thus exact.
    """
    names = [material] if isinstance(material, str) else material
    lists: dict[str, Any] = {"radii": radii, "material": material, "density": density}
    lists |= {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio}
    sizes = {name: len(given) for name, given in lists.items() if _is_list(given)}
    if n is not None:
        sizes = {"n": whole("n", n, 1, MOST_BALLS)} | sizes
    if len(set(sizes.values())) > 1:
        raise InvalidValue(f"{_told(sizes)} are refused; allowed: one value for all balls, or one for each")
    balls = whole("number of balls", next(iter(sizes.values()), 5), 1, MOST_BALLS)
    solids = [_material(name) for name in names] * (balls if len(names) == 1 else 1)

    def each(what: str, unit: str, given: Any, own: list[float] | None = None, **limits: Any) -> list[float]:
        if given is None and own is not None:
            return own
        if _is_list(given):
            return [number(f"{what}[{i}]", value, unit, **limits) for i, value in enumerate(given, start=1)]
        return [number(what, given, unit, **limits)] * balls

    r = each("radii", "m", radii, positive=True)
    rho = each("density", "kg/m3", density, [solid.density for solid in solids], positive=True)
    e = each("young_modulus", "Pa", young_modulus, [solid.young_modulus for solid in solids], positive=True)
    nu = each("poisson_ratio", "", poisson_ratio, [solid.poisson_ratio for solid in solids], least=0.0, most=0.5)
    mass = [4.0 / 3.0 * math.pi * a * b**3 for a, b in zip(rho, r, strict=True)]
    alike = [a * ((1.0 - nu[0] ** 2) / (1.0 - b**2)) for a, b in zip(e, nu, strict=True)]
    values = {"contact.model": "hertz", "contact.deadBand": 0.0, "ball.poissonRatio": nu[0]}
    for name, own in {"ball.mass": mass, "ball.radius": r, "ball.youngModulus": alike}.items():
        values |= {name: own[0]} | vector(f"{name}Ratio", [value / own[0] for value in own])
    return values


def _is_list(given: Any) -> bool:
    return hasattr(plain(given), "__len__") and not isinstance(given, str)


def _told(sizes: dict[str, int]) -> str:
    parts = [f"n = {size}" if name == "n" else f"{size} value(s) of {name}" for name, size in sizes.items()]
    return f"{', '.join(parts[:-1])} and {parts[-1]}"


def _material(name: Any) -> Material:
    needed("material", name, str, f"one of {', '.join(MATERIALS)}")
    if name not in MATERIALS:
        hint = did_you_mean(name, MATERIALS)
        raise InvalidValue(f"material = {name!r} is refused; allowed: {', '.join(MATERIALS)}{hint}")
    return MATERIALS[name]
