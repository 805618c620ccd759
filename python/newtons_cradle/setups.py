"""Start values of the paper's experiments (P. C. Breedveld, "Newton's cradle revisited", 2002).

Each function returns a dict of start values by variable name, in SI units, to be merged and changed
freely: `figure5(dead_band=0) | {"pendulum.drag": 0.01}`.
"""


def power_law(k: float, p: float = 1.0, dead_band: float = 0.0) -> dict:
    """Contacts F = k overlap^p, k in N/m^p; `dead_band` in m."""
    return {
        "contact.stiffness": k,
        "contact.overlapRef": 1.0,
        "contact.exponent": p,
        "contact.deadBand": dead_band,
    }


def lifted(left: int, right: int = 0, *, n: int = 5, amplitude: float = 1.0) -> dict:
    """`left` balls lifted to the left and `right` to the right by `amplitude` (m), all at rest."""
    x = [-amplitude] * left + [0.0] * (n - left - right) + [amplitude] * right
    return _vector("x_start", x) | _vector("v_start", [0.0] * n)


def chain(p: float, strikers: int, *, n: int = 5) -> dict:
    """Free chain: no gravity, balls of 1 kg exactly in touch, F = overlap^p, strikers at 1 m/s."""
    v = [1.0] * strikers + [0.0] * (n - strikers)
    at_rest_in_touch = _vector("x_start", [0.0] * n) | _vector("v_start", v)
    return {"gravity": 0.0, "ball.mass": 1.0} | power_law(1.0, p) | at_rest_in_touch


def figure5(dead_band: float = 2.6e-7) -> dict:
    """Figures 4 and 5, Table 1: two balls of 1 kg lifted by 1 m, g/L = 5 1/s2, k = 1e14 N/m."""
    pendulum = {"gravity": 9.81, "pendulum.length": 1.962, "ball.mass": 1.0}
    return pendulum | power_law(1e14, dead_band=dead_band) | lifted(2)


def figure6() -> dict:
    """Figure 6: as Figure 5 with k = 2.9e14 N/m and a dead band of 1.46e-7 m."""
    return figure5() | power_law(2.9e14, dead_band=1.46e-7)


def figure3() -> dict:
    """Figure 3: 13 balls of 1 kg, three lifted left and two right by 1 m, g/L = 9.81 1/s2, k = 4e4 N/m."""
    pendulum = {"gravity": 9.81, "pendulum.length": 1.0, "ball.mass": 1.0}
    return pendulum | power_law(4e4) | lifted(3, 2, n=13)


def steel(lifted_balls: int = 1, *, amplitude: float = 0.05) -> dict:
    """Five touching steel balls (1 kg, radius 31.3 mm, Hertz contacts), lifted by `amplitude` (m)."""
    ball = {"ball.mass": 1.0, "ball.radius": 0.0313, "ball.youngModulus": 2.1e11, "ball.poissonRatio": 0.3}
    contact = {"contact.model": 2, "contact.deadBand": 0.0}
    return (
        {"gravity": 9.81, "pendulum.length": 1.962}
        | ball
        | contact
        | lifted(lifted_balls, amplitude=amplitude)
    )


def _vector(name: str, values) -> dict:
    return {f"{name}[{i}]": value for i, value in enumerate(values, start=1)}
