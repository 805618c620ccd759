"""Derivatives through FMPy: of inputs, of outputs by time, and along directions."""

import newtons_cradle as nc
import numpy as np
import pytest


def reference(run, name):
    return run.fmu.variables[name].valueReference


def test_capabilities_are_declared(fmu):
    declared = fmu.description.coSimulation
    assert declared.canInterpolateInputs
    assert declared.maxOutputDerivativeOrder == 3
    assert declared.providesDirectionalDerivative
    assert declared.canGetAndSetFMUstate
    assert declared.canSerializeFMUstate
    assert declared.canHandleVariableCommunicationStepSize


def test_a_ramp_is_followed_exactly(fmu):
    """A force of 2 N/s on a ball that swings alone: x'' = -omega^2 x + 2 t / m."""
    with fmu.start() as run:
        run.slave.setRealInputDerivatives([reference(run, "F_ext[5]")], [1], [2.0])
        run.step(0.5)
        omega = np.sqrt(5.0)
        wanted = 2.0 / 5.0 * (0.5 - np.sin(omega * 0.5) / omega)
        assert run.get("x[5]") == pytest.approx(wanted, rel=1e-13)
        assert run.get("F_ext[5]") == 1.0


def test_output_derivatives_predict_the_swing(fmu):
    with fmu.start() as run:
        run.step(0.2)
        x, h = run.get("x[1]"), 1e-3
        rates = run.slave.getRealOutputDerivatives([reference(run, "x[1]")] * 3, [1, 2, 3])
        run.step(h)
        taylor = x + sum(rate * h**k / f for k, (rate, f) in enumerate(zip(rates, (1, 2, 6), strict=True), 1))
        assert run.get("x[1]") == pytest.approx(taylor, abs=1e-13)


@pytest.mark.parametrize("end", ["in flight", "within a pulse", "after an impact"])
def test_directional_derivatives_agree_with_differences(fmu, end):
    unknowns = ["x[1]", "v[2]", "F[2]", "impulse[2]", "F_support"]
    if end != "within a pulse":  # after which two onsets tie: a kink
        unknowns.append("t_next")
    with fmu.start(nc.figure5()) as run:
        run.step_to(0.6)
        saved, onset = run.save(), run.get("t_next")
        length = {"in flight": 0.05, "within a pulse": onset + 1e-7 - 0.6, "after an impact": 0.11}[end]

        def outputs(force: float) -> np.ndarray:
            run.load(saved)
            run.set({"F_ext[2]": force})
            run.step(length)
            return np.array([run.get(name) for name in unknowns])

        outputs(0.0)
        exact = run.slave.getDirectionalDerivative(
            [reference(run, name) for name in unknowns], [reference(run, "F_ext[2]")], [1.0]
        )
        h = 1e-7
        sides = [outputs(k * h) - outputs(-k * h) for k in (1, 2)]
        differences = (8.0 * sides[0] - sides[1]) / (12.0 * h)
        assert exact == pytest.approx(differences, rel=1e-5, abs=1e-6)
