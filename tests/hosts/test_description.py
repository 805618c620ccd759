"""modelDescription.xml: FMPy's validator, the names and units that never change, and what no tool checks."""

import re

import pytest
from fmpy.validation import validate_fmu

N = 5
# name: variability where it matters and causality, unit, start (None where there is none)
FIXED, TUNABLE = "fixed parameter", "tunable parameter"
CONTINUOUS, DISCRETE = "continuous output", "discrete output"
VARIABLES = {
    "gravity": (FIXED, "m/s2", 9.81),
    "ball.mass": (FIXED, "kg", 1.0),
    "ball.massRatio[#n]": (FIXED, "1", 1.0),
    "ball.radius": (FIXED, "m", 0.0313),
    "ball.radiusRatio[#n]": (FIXED, "1", 1.0),
    "ball.youngModulus": (FIXED, "Pa", 2.1e11),
    "ball.youngModulusRatio[#n]": (FIXED, "1", 1.0),
    "ball.poissonRatio": (FIXED, "1", 0.3),
    "pendulum.length": (FIXED, "m", 1.962),
    "pendulum.lengthRatio[#n]": (FIXED, "1", 1.0),
    "pendulum.model": (FIXED, None, 1),
    "pendulum.drag": (TUNABLE, "kg/s", 0.0),
    "pendulum.period": ("calculatedParameter", "s", None),
    "contact.model": (FIXED, None, 1),
    "contact.stiffness": (FIXED, "N/m", 1e10),
    "contact.stiffnessRatio[#c]": (FIXED, "1", 1.0),
    "contact.overlapRef": (FIXED, "m", 1e-6),
    "contact.exponent": (FIXED, "1", 1.0),
    "contact.deadBand": (FIXED, "m", 2.6e-6),
    "contact.gap[#c]": (FIXED, "m", 0.0),
    "contact.dampingLaw": (FIXED, None, 1),
    "contact.damping": (TUNABLE, "N.s/m", 0.0),
    "contact.huntCrossley": (TUNABLE, "s/m", 0.0),
    "contact.relaxationTime": (TUNABLE, "s", 0.0),
    "contact.restitution": (TUNABLE, "1", 1.0),
    "contact.lossRatio[#c]": (TUNABLE, "1", 1.0),
    "x_start[#n]": (FIXED, "m", (-0.1, -0.1, 0.0, 0.0, 0.0)),
    "v_start[#n]": (FIXED, "m/s", 0.0),
    "solver.method": (FIXED, None, 1),
    "solver.tolerance": (FIXED, "1", 1e-12),
    "solver.fixedStep": (FIXED, "s", 1e-6),
    "exchange.contacts": (FIXED, None, 2),
    "F_ext[#n]": ("input", "N", 0.0),
    "a_support": ("input", "m/s2", 0.0),
    "x[#n]": ("output", "m", None),
    "F[#c]": (CONTINUOUS, "N", None),
    "v[#n]": ("output", "m/s", None),
    "E_total": ("output", "J", None),
    "p_total": ("output", "kg.m/s", None),
    "F_support": ("output", "N", None),
    "t_next": (DISCRETE, "s", None),
    "impulse[#c]": ("output", "N.s", None),
    "F_mean[#c]": (CONTINUOUS, "N", None),
    "F_peak[#c]": (DISCRETE, "N", None),
    "F_support_mean": (CONTINUOUS, "N", None),
    "pulses[#c]": (DISCRETE, None, None),
    "inContact[#c]": (DISCRETE, None, None),
    "angle[#n]": ("output", "rad", None),
    "y[#n]": ("output", "m", None),
    "F_support_vertical": ("output", "N", None),
    "t_onset[#c]": ("local", "s", None),
    "t_release[#c]": ("local", "s", None),
    "overlap[#c]": ("local", "m", None),
    "a[#n]": ("local", "m/s2", None),
    "E_kinetic[#n]": ("local", "J", None),
    "E_gravity[#n]": ("local", "J", None),
    "E_contact[#c]": ("local", "J", None),
    "E_dissipated": ("local", "J", None),
    "W_external": ("local", "J", None),
    "der(overlap[#c])": ("local", "m/s", None),
    "der(E_dissipated)": ("local", "W", None),
    "der(W_external)": ("local", "W", None),
    "E_residual": ("local", "J", None),
    "solver.steps": ("local", None, None),
    "solver.evaluations": ("local", None, None),
    "solver.events": ("local", None, None),
    "t_next_isOnset": ("local", None, None),
}


def spread(*names: str) -> list[str]:
    """`x[#n]` as x[1] to x[5], `F[#c]` as F[1] to F[4], other names as they are."""
    found = []
    for name in names:
        count = N if "#n" in name else N - 1 if "#c" in name else 1
        found += [re.sub("#[nc]", str(i), name) for i in range(1, count + 1)]
    return found


def test_description_passes_fmpys_validation(fmu_path):
    assert validate_fmu(str(fmu_path)) == []


def test_description_identity_capabilities_and_default_experiment(fmu):
    description = fmu.description
    assert (description.fmiVersion, description.modelName) == ("2.0", "NewtonsCradle")
    assert description.modelExchange.modelIdentifier == "NewtonsCradle"
    states, indicators = description.numberOfContinuousStates, description.numberOfEventIndicators
    assert (states, indicators) == (3 * N + 1, 2 * (N - 1))
    assert description.variableNamingConvention == "structured"
    experiment = description.defaultExperiment
    times = (experiment.startTime, experiment.stopTime, experiment.stepSize)
    assert [float(time) for time in times] == [0, 10, 0.01] and experiment.tolerance is None
    declared = description.coSimulation
    assert (declared.modelIdentifier, declared.maxOutputDerivativeOrder) == ("NewtonsCradle", 3)
    assert declared.canInterpolateInputs and declared.providesDirectionalDerivative
    assert declared.canGetAndSetFMUstate and declared.canSerializeFMUstate
    assert declared.canHandleVariableCommunicationStepSize


@pytest.mark.parametrize("name", VARIABLES)
def test_description_variables_keep_name_unit_and_default(fmu, name):
    kind, unit, start = VARIABLES[name]
    *variability, causality = kind.split()
    for i, element in enumerate(spread(name)):
        variable = fmu.variables[element]
        assert variable.description
        assert variable.causality == causality and variability in ([], [variable.variability])
        assert fmu.unit(element) == (unit or "")
        if start is not None:
            assert float(variable.start) == (start[i] if isinstance(start, tuple) else start)


def test_description_has_every_variable_and_outputs_in_order(fmu):
    assert sorted(fmu.variables) == sorted(spread(*VARIABLES))
    wanted = [name for name, (kind, *_) in VARIABLES.items() if kind.endswith("output")]
    assert list(fmu.outputs) == spread(*wanted)
    assert [unknown.variable.name for unknown in fmu.description.outputs] == list(fmu.outputs)


def test_description_value_references_stay(fmu):
    """They count the rows of the table: a row that is not its last would change those that follow."""
    names = ("gravity", "x[1]", "pendulum.model", "F_support_vertical")
    assert [fmu.variables[name].valueReference / 2**14 for name in names] == [0, 30, 60, 63]


def test_description_states_are_in_order(fmu):
    states = ["x[1]", "overlap[#c]", "v[#n]", "impulse[#c]", "E_dissipated", "W_external"]
    rates = ["v[1]", "der(overlap[#c])", "a[#n]", "F[#c]", "der(E_dissipated)", "der(W_external)"]
    found = [unknown.variable for unknown in fmu.description.derivatives]
    assert [variable.name for variable in found] == spread(*rates)
    assert [variable.derivative.name for variable in found] == spread(*states)


def test_description_log_categories(fmu):
    names = {category.name for category in fmu.description.logCategories or []}
    assert names == {"logEvents", "logSolver", "logStatusWarning", "logStatusDiscard", "logStatusError"}
