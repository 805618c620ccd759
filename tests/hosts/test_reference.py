"""Against an independent quadruple-precision computation (tests/data/reference.json), five balls."""

import json
from pathlib import Path

import newtons_cradle as nc
import numpy as np
import pytest

DATA = json.loads((Path(__file__).parents[1] / "data/reference.json").read_text())
CHAINS = {case["id"]: case for case in DATA["free_chain"] if case["N"] == 5}
STATES = {case["id"]: case for case in DATA["cradle_states"] if case["N"] == 5}


def damped_chains() -> dict:
    """The damped chains of five balls by a name, each with the FMU's start values for its damping."""
    cases = {}
    for case in DATA["damped_chain"]:
        if case["N"] != 5:
            continue
        if "alpha" in case:
            law, values = "huntCrossley", {"contact.dampingLaw": 3, "contact.huntCrossley": case["alpha"]}
        elif case["clamped"]:
            law, values = "kelvinVoigtNoPull", {"contact.dampingLaw": 2, "contact.damping": case["c"]}
        else:
            law, values = "kelvinVoigt", {"contact.dampingLaw": 1, "contact.damping": case["c"]}
        cases[f"{law} p={case['p']:g}"] = case | {"values": values}
    return cases


DAMPED = damped_chains()


def floats(texts) -> np.ndarray:
    """Decimal strings as doubles."""
    return np.array([float(text) for text in texts])


@pytest.mark.parametrize("case", CHAINS)
def test_free_chain(fmu, case):
    """Final velocities to 1e-9, the contacts' opening times, peaks and impulses with them."""
    chain = CHAINS[case]
    with fmu.start(nc.chain(chain["p"], chain["strikers"])) as run:
        run.step_to(10.0)
        v = np.array([run.get(f"v[{i}]") for i in range(1, 6)])
        opened = [run.get(f"t_release[{i}]") for i in range(1, 5)]
        impulse = [run.get(f"impulse[{i}]") for i in range(1, 5)]
        peak = [run.get(f"F_peak[{i}]") for i in range(1, 5)]
        assert run.get("t_next") == 1e30
    assert np.abs(v - floats(chain["v_final"])).max() <= 1e-9
    assert opened == pytest.approx(floats(chain["t_open"]), abs=1e-8)
    assert impulse == pytest.approx(floats(chain["impulse"]), abs=1e-9)
    assert peak == pytest.approx(floats(chain["F_peak"]), abs=1e-8)


@pytest.mark.parametrize("case", STATES)
def test_cradle_state(fmu, case):
    """Positions to 1e-8 of the amplitude, velocities to 1e-8 of omega times it."""
    state = STATES[case]
    amplitude, omega = state["amplitude"], np.sqrt(state["omega2"])
    values = nc.power_law(state["k"], state["p"], state["gap"])
    values |= nc.lifted(state["lifted_left"], amplitude=amplitude)
    values |= {"gravity": state["omega2"], "pendulum.length": 1.0, "ball.mass": state["m"]}
    with fmu.start(values) as run:
        run.step_to(state["t"])
        x = np.array([run.get(f"x[{i}]") for i in range(1, 6)])
        v = np.array([run.get(f"v[{i}]") for i in range(1, 6)])
    assert np.abs(x - floats(state["x"])).max() <= 1e-8 * amplitude
    assert np.abs(v - floats(state["v"])).max() <= 1e-8 * amplitude * omega


@pytest.mark.parametrize("case", DAMPED)
def test_damped_chain(fmu, case):
    """Final velocities to 1e-9 for each damping law, and the losses that go with them."""
    chain = DAMPED[case]
    values = nc.chain(chain["p"], chain["strikers"]) | chain["values"]
    wanted = floats(chain["v_final"])
    with fmu.start(values) as run:
        run.step_to(10.0)
        v = np.array([run.get(f"v[{i}]") for i in range(1, 6)])
        assert run.pulses["release"].max() == pytest.approx(float(chain["duration"]), abs=1e-8)
        assert run.get("E_dissipated") == pytest.approx(0.5 * (chain["strikers"] - sum(wanted**2)), abs=1e-9)
    assert np.abs(v - wanted).max() <= 1e-9


def test_hertz_contact_of_two_steel_balls(fmu):
    """Peak, length and impulse of one collision against the closed form, from elastic constants."""
    radius, young, poisson, mass, v = 0.02, 2e11, 0.28, 0.25, 0.7
    values = {"gravity": 0.0, "contact.model": 2, "contact.deadBand": 0.0, "ball.mass": mass}
    values |= {"ball.radius": radius, "ball.youngModulus": young, "ball.poissonRatio": poisson}
    values |= {f"x_start[{i}]": 1.0 * i for i in range(1, 6)} | {"v_start[1]": v}
    k = 4 / 3 * young / (2 * (1 - poisson**2)) * np.sqrt(radius / 2)
    overlap = (2.5 * (mass / 2) * v**2 / (2 * k)) ** 0.4
    length = 2 * overlap / v * 1.4716375921623523287
    with fmu.start(values) as run:
        run.step_to(1.0 / v + 0.1)
        (pulse,) = run.pulses
    assert pulse["contact"] == 1
    assert pulse["peak"] == pytest.approx(k * overlap**1.5, rel=1e-9)
    assert pulse["release"] - pulse["onset"] == pytest.approx(length, rel=1e-9)
    assert pulse["impulse"] == pytest.approx(mass * v, rel=1e-12)
