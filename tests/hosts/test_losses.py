"""Damping from a coefficient of restitution, against the FMU."""

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import repacked
from newtons_cradle.cases import COEFFICIENT

#: Contacts, and the masses of the two balls.
CRADLES = {
    "linear": ({"contact.exponent": 1.0, "contact.stiffness": 1e6}, (1.0, 1.0)),
    "hertz": ({"contact.model": "hertz", "ball.youngModulus": 1e11, "ball.radius": 0.01}, (1e-2, 10.0)),
    "unlike spheres": (
        {"contact.model": "hertz", "ball.radiusRatio[3]": 0.2, "ball.youngModulusRatio[2]": 30.0, "ball.radius": 0.01},
        (1e-2, 10.0),
    ),
    "quadratic": (
        {"contact.exponent": 2.0, "contact.stiffnessRatio[2]": 3.0, "contact.lossRatio[2]": 4.0},
        (30.0, 0.5),
    ),
    "steep": ({"contact.exponent": 7.3, "contact.overlapRef": 1e-4, "contact.stiffness": 1e5}, (1.0, 2.0)),
}


@pytest.mark.parametrize("law", COEFFICIENT)
@pytest.mark.parametrize("cradle", CRADLES)
@pytest.mark.parametrize(("e", "speed"), [(0.999, 1e-3), (0.9, 1.0), (0.5, 0.1), (0.05, 5.0)])
def test_losses_from_a_restitution_give_that_restitution(fmu, cradle, law, e, speed):
    """Balls 2 and 3, far from the others, by any law: e to 1e-9, by the law of constant restitution to 1e-13."""
    contacts, (left, right) = CRADLES[cradle]
    values = contacts | {
        "gravity": 0.0,
        "contact.deadBand": 0.0,
        "ball.massRatio[2]": left,
        "ball.massRatio[3]": right,
        "contact.gap": [10.0, 1e-6 * speed, 10.0, 10.0],
        "x_start": [0.0] * 5,
        "v_start": [0.0, speed, 0.0, 0.0, 0.0],
    }
    lossy = nc.damping(law, values, restitution=e, speed=speed, contact=2, fmu=fmu)
    assert set(lossy) == {"contact.dampingLaw", COEFFICIENT[law]}
    run = fmu.simulate(values | lossy, stop=0.9, step=0.9, record=["v"])
    assert len(run.pulses) == 1
    v = run["v"][-1]
    exact = 1e-13 if law == "constantRestitution" else 1e-9
    assert (v[2] - v[1]) / speed == pytest.approx(e, abs=exact)


@pytest.mark.parametrize(
    ("given", "e", "speeds"),
    [
        (["--restitution", "0.8"], 0.8, (1e-3, 2.0)),
        (["--preset", "steel", "--restitution", "0.3"], 0.3, (1e-3, 2.0)),
        (["--preset", "rigid", "--restitution", "0.8"], 0.8, (1e-3, 2.0)),
        (["--preset", "desk", "--restitution", "0.9@0.25"], 0.9, (0.25,)),
        (
            ["--preset", "unlike", "--set", "contact.dampingLaw=viscoelastic", "--restitution", "0.6@0.5"],
            0.6,
            (0.5,),
        ),
    ],
)
def test_losses_of_an_fmu_built_with_a_restitution(fmu_path, producer, tmp_path, given, e, speeds):
    """Balls 1 and 2, far from the others, free and on lines."""
    with nc.Fmu(repacked(producer, fmu_path, tmp_path / "lossy.fmu", *given)) as lossy:
        free = {"gravity": 0.0, "pendulum.drag": 0.0, "pendulum.model": "linear", "x_start": [0.0] * 5}
        for speed in speeds:
            alone = {"v_start": [speed, 0.0, 0.0, 0.0, 0.0], "contact.gap": [1e-6 * speed, 1.0, 1.0, 1.0]}
            v = lossy.simulate(free | alone, times=[0.0, 0.01 / speed], record=["v"])["v"][-1]
            assert (v[1] - v[0]) / speed == pytest.approx(e, abs=1e-10)


def test_losses_of_the_preset_clay(fmu):
    """Its two balls alone part as its comment says, any others as steel; a run of the cradle has the exact balance."""
    clay = nc.preset("clay")
    free = clay | {"gravity": 0.0, "contact.gap": [1e-6] * 4, "pendulum.model": "linear"}
    for contact, e in ((3, 0.98**150), (1, 0.98)):
        balls = {"x_start": [0.0] * 5, "v_start": [0.1 * (ball == contact) for ball in range(1, 6)]}
        apart = {f"contact.gap[{i}]": 1.0 for i in range(1, 5) if i != contact}
        v = fmu.simulate(free | balls | apart, times=[0.0, 0.1], record=["v"])["v"][-1]
        assert (v[contact] - v[contact - 1]) / 0.1 == pytest.approx(e, abs=1e-13)
    run = fmu.simulate(clay, stop=10.0, record=["E_total", "E_dissipated", "E_residual"])
    assert np.abs(run["E_residual"]).max() < 1e-13 * run["E_total"][0]
    without = fmu.simulate(clay | {"contact.lossRatio": [1.0] * 4}, stop=0.3, record=["E_dissipated"])
    assert run["E_dissipated"][30] > 4 * without["E_dissipated"][-1] > 0.0


def test_losses_that_cannot_be_are_refused_in_words(fmu):
    def damp(law="viscoelastic", values=None, restitution=0.9, speed=1.0, **options):
        return nc.damping(law, values, restitution=restitution, speed=speed, fmu=fmu, **options)

    for wrong, complaint in [
        ({"law": "plastic"}, "law = 'plastic' is refused; allowed: kelvinVoigt, "),
        ({"restitution": 1.2}, "restitution = 1.2 is refused; allowed: a positive number, at most 1"),
        ({"restitution": 0.0}, "restitution = 0.0 is refused"),
        ({"speed": None}, "speed is missing: by viscoelastic the coefficient of restitution depends on it"),
        ({"values": {"contact.lossRatio[1]": 0.0}}, "contact.lossRatio\\[1\\] = 0 is refused; allowed: above 0"),
        ({"speed": -1.0}, "speed = -1.0 is refused; allowed: a positive number \\(m/s\\)"),
        ({"contact": 5}, "contact = 5 is refused; allowed: a whole number from 1 to 4"),
        ({"values": {"contact.model": "rigid"}}, "its coefficient is contact.restitution"),
    ]:
        with pytest.raises(nc.InvalidValue, match=complaint):
            damp(**wrong)
    assert damp(restitution=1.0) == {"contact.dampingLaw": "viscoelastic", "contact.relaxationTime": 0.0}
    known = damp("constantRestitution", speed=None)
    assert (
        known
        == damp("constantRestitution")
        == {
            "contact.dampingLaw": "constantRestitution",
            "contact.restitution": 0.9,
        }
    )
