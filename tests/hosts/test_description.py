"""modelDescription.xml: FMPy's validator, the names and units that never change, and what no tool checks."""

import pytest
from fmpy.validation import validate_fmu

N = 5

PARAMETERS = {  # name: (unit, start); None where the start differs per element
    "gravity": ("m/s2", 9.81),
    "ball.mass": ("kg", 1.0),
    "ball.massRatio[#n]": ("1", 1.0),
    "ball.radius": ("m", 0.0313),
    "ball.youngModulus": ("Pa", 2.1e11),
    "ball.poissonRatio": ("1", 0.3),
    "pendulum.length": ("m", 1.962),
    "pendulum.lengthRatio[#n]": ("1", 1.0),
    "pendulum.drag": ("kg/s", 0.0),
    "contact.model": (None, 1),
    "contact.stiffness": ("N/m", 1e10),
    "contact.stiffnessRatio[#c]": ("1", 1.0),
    "contact.overlapRef": ("m", 1e-6),
    "contact.exponent": ("1", 1.0),
    "contact.deadBand": ("m", 2.6e-6),
    "contact.gap[#c]": ("m", 0.0),
    "contact.dampingLaw": (None, 1),
    "contact.damping": ("N.s/m", 0.0),
    "contact.huntCrossley": ("s/m", 0.0),
    "contact.relaxationTime": ("s", 0.0),
    "contact.restitution": ("1", 1.0),
    "x_start[#n]": ("m", None),
    "v_start[#n]": ("m/s", 0.0),
    "solver.method": (None, 1),
    "solver.tolerance": ("1", 1e-12),
    "solver.fixedStep": ("s", 1e-6),
    "exchange.contacts": (None, 2),
}
TUNABLE = {
    "pendulum.drag",
    "contact.damping",
    "contact.huntCrossley",
    "contact.relaxationTime",
    "contact.restitution",
}
INPUTS = {"F_ext[#n]": "N", "a_support": "m/s2"}
OUTPUTS = {  # in this order
    "x[#n]": "m",
    "F[#c]": "N",
    "v[#n]": "m/s",
    "E_total": "J",
    "p_total": "kg.m/s",
    "F_support": "N",
    "t_next": "s",
    "impulse[#c]": "N.s",
    "F_mean[#c]": "N",
    "F_peak[#c]": "N",
    "F_support_mean": "N",
    "pulses[#c]": None,
    "inContact[#c]": None,
}
LOCALS = {
    "t_onset[#c]": "s",
    "t_release[#c]": "s",
    "overlap[#c]": "m",
    "a[#n]": "m/s2",
    "E_kinetic[#n]": "J",
    "E_gravity[#n]": "J",
    "E_contact[#c]": "J",
    "E_dissipated": "J",
    "W_external": "J",
    "der(overlap[#c])": "m/s",
    "der(E_dissipated)": "W",
    "der(W_external)": "W",
    "E_residual": "J",
    "solver.steps": None,
    "solver.evaluations": None,
    "solver.events": None,
    "t_next_isOnset": None,
}
CALCULATED = {"pendulum.period": "s"}
DISCRETE = ("F_peak", "t_next", "pulses", "inContact")


def spread(name: str) -> list[str]:
    """`x[#n]` as x[1] to x[5], `F[#c]` as F[1] to F[4], other names as they are."""
    for mark, count in (("#n", N), ("#c", N - 1)):
        if mark in name:
            return [name.replace(mark, str(i)) for i in range(1, count + 1)]
    return [name]


def unit_of(variable) -> str | None:
    """The unit a variable has itself or by its type."""
    return variable.unit or (variable.declaredType.unit if variable.declaredType else None)


def test_fmpy_validate_finds_nothing(fmu_path):
    assert validate_fmu(str(fmu_path)) == []


def test_identity_and_default_experiment(fmu):
    description = fmu.description
    assert (description.fmiVersion, description.modelName) == ("2.0", "NewtonsCradle")
    assert description.coSimulation.modelIdentifier == "NewtonsCradle"
    assert description.modelExchange.modelIdentifier == "NewtonsCradle"
    assert (description.numberOfContinuousStates, description.numberOfEventIndicators) == (
        3 * N + 1,
        2 * (N - 1),
    )
    assert description.variableNamingConvention == "structured"
    experiment = description.defaultExperiment
    assert [float(v) for v in (experiment.startTime, experiment.stopTime, experiment.stepSize)] == [
        0,
        10,
        0.01,
    ]
    assert experiment.tolerance is None


@pytest.mark.parametrize("name", PARAMETERS)
def test_parameters_keep_name_unit_and_default(fmu, name):
    unit, start = PARAMETERS[name]
    for element in spread(name):
        variable = fmu.variables[element]
        wanted = "tunable" if name in TUNABLE else "fixed"
        assert (variable.causality, variable.variability) == ("parameter", wanted)
        assert unit_of(variable) == unit
        if start is not None:
            assert float(variable.start) == start


def test_two_balls_are_lifted_by_default(fmu):
    assert [float(fmu.variables[name].start) for name in spread("x_start[#n]")] == [-0.1, -0.1, 0, 0, 0]


def test_calculated_parameters(fmu):
    for name, unit in CALCULATED.items():
        assert (fmu.variables[name].causality, unit_of(fmu.variables[name])) == ("calculatedParameter", unit)


def test_the_lists_above_have_every_variable(fmu):
    names = [*PARAMETERS, *CALCULATED, *INPUTS, *OUTPUTS, *LOCALS]
    assert sorted(fmu.variables) == sorted(element for name in names for element in spread(name))


def test_inputs(fmu):
    wanted = {element: unit for name, unit in INPUTS.items() for element in spread(name)}
    found = {v.name: unit_of(v) for v in fmu.description.modelVariables if v.causality == "input"}
    assert found == wanted


def test_outputs_in_their_order(fmu):
    wanted = [(element, unit) for name, unit in OUTPUTS.items() for element in spread(name)]
    assert [(name, unit_of(fmu.variables[name])) for name in fmu.outputs[: len(wanted)]] == wanted


def test_locals(fmu):
    for name, unit in LOCALS.items():
        for element in spread(name):
            variable = fmu.variables[element]
            assert (variable.causality, unit_of(variable)) == ("local", unit)


def test_values_of_communication_points_are_discrete(fmu):
    for variable in fmu.description.modelVariables:
        if variable.name.split("[")[0] in DISCRETE:
            assert variable.variability == "discrete", variable.name


def test_states_of_model_exchange_in_their_order(fmu):
    wanted = [
        "x[1]",
        *spread("overlap[#c]"),
        *spread("v[#n]"),
        *spread("impulse[#c]"),
        "E_dissipated",
        "W_external",
    ]
    rates = ["v[1]", *spread("der(overlap[#c])"), *spread("a[#n]"), *spread("F[#c]")]
    rates += ["der(E_dissipated)", "der(W_external)"]
    found = [unknown.variable for unknown in fmu.description.derivatives]
    assert [variable.name for variable in found] == rates
    assert [variable.derivative.name for variable in found] == wanted
    for name in ("F_mean[1]", "F_support_mean", "F[1]"):
        assert fmu.variables[name].variability in (None, "continuous")


def test_every_start_lies_within_its_range(fmu):
    """No validator looks at this."""
    ranged = 0
    for variable in fmu.description.modelVariables:
        if variable.start is not None and variable.type in ("Real", "Integer"):
            low = float(variable.min) if variable.min is not None else -float("inf")
            high = float(variable.max) if variable.max is not None else float("inf")
            assert low <= float(variable.start) <= high, variable.name
            ranged += variable.min is not None
    assert ranged >= 10


def test_every_quantity_says_what_it_is(fmu):
    for variable in fmu.description.modelVariables:
        assert variable.description, variable.name
        assert variable.type != "Real" or unit_of(variable), variable.name


def test_log_categories(fmu):
    names = {category.name for category in fmu.description.logCategories or []}
    assert names == {"logEvents", "logSolver", "logStatusWarning", "logStatusError"}
