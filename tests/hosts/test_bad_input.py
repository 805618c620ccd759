"""Nonsense is refused with an error that names variable, value and what is allowed, and does no harm: through FMPy, as hosts show it.

tests/rust/ffi goes through all functions and states.
"""

import math
import re
import shutil

import newtons_cradle as nc
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from newtons_cradle.run import log as router

ERROR = 3
NAN, INF = math.nan, math.inf


@pytest.fixture
def bare(fmu):
    """An instance that is only instantiated."""
    with fmu.start(initialize=False) as run:
        yield run


@pytest.fixture
def ready(fmu):
    """An instance in step mode at 0.1 s."""
    with fmu.start() as run:
        run.step_to(0.1)
        yield run


def refused(run, function, *args) -> str:
    """Calls a function of the slave, which must answer fmi2Error and log why; returns the text."""
    before = len(run.log)
    with pytest.raises(FMICallException) as caught:
        function(*args)
    assert caught.value.status == ERROR
    errors = [line for line in run.log[before:] if line.status == ERROR]
    assert errors, "refused without a word"
    assert all(line.category == "logStatusError" for line in errors)
    return " ".join(line.text for line in errors)


def refused_set(run, name, value, kind="Real") -> str:
    """Sets one variable, which must be refused in words that name it."""
    text = refused(run, getattr(run.slave, f"set{kind}"), [run.fmu.variables[name].valueReference], [value])
    assert name in text
    return text.replace(name, "")


def still_works(run) -> None:
    """The instance goes on as if nothing had been asked: the default run's first impact is there.

    Every refused value would move that impact or put it elsewhere in the log, had it been applied.
    """
    if run.time == 0.0:
        run.initialize()
    run.step_to(1.0)
    assert run.pulses["onset"][0] == pytest.approx(0.702493100658, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "value", "says", "allowed"),
    [
        ("ball.mass", 0.0, r"\b0\b", r"> 0"),
        ("ball.mass", -1.0, r"-1\b", r"> 0"),
        ("ball.mass", NAN, r"(?i)nan", r"> 0"),
        ("ball.mass", -INF, r"(?i)-inf", r"> 0"),
        ("ball.massRatio[3]", 0.0, r"\b0\b", r"> 0"),
        ("ball.radius", -0.01, r"-0\.01\b", r"> 0"),
        ("ball.poissonRatio", 0.6, r"0\.6\b", r"0\.5"),
        ("gravity", -9.81, r"-9\.81\b", r">= 0"),
        ("contact.exponent", 0.5, r"0\.5\b", r"1.*10"),
        ("contact.exponent", 10.5, r"10\.5\b", r"1.*10"),
        ("contact.deadBand", -1e-6, r"-(1e-0?6|0\.000001)\b", r">= 0"),
        ("contact.gap[1]", NAN, r"(?i)nan", r"finite"),
        ("x_start[2]", INF, r"(?i)inf", r"finite"),
        ("solver.tolerance", 1.0, r"\b1\b", r"1e-0?14|0\.001|1e-0?3"),
        ("F_ext[2]", NAN, r"(?i)nan", r"finite"),
        ("contact.model", 99, "99", "powerLaw"),
        ("contact.dampingLaw", -1, "-1", "kelvinVoigt"),
    ],
)
def test_bad_value(bare, name, value, says, allowed):
    variable = bare.fmu.variables[name]
    text = refused_set(bare, name, value, "Integer" if variable.type == "Enumeration" else "Real")
    assert re.search(says, text) and re.search(allowed, text), text
    still_works(bare)
    assert bare.get(name) == float(variable.start)


def test_one_bad_value_spoils_the_whole_call_and_nothing_else(bare):
    names = ["ball.mass", "pendulum.length", "gravity"]
    references = [bare.fmu.variables[name].valueReference for name in names]
    assert "pendulum.length" in refused(bare, bare.slave.setReal, references, [2.0, -1.0, 1.6])
    still_works(bare)
    assert [bare.get(name) for name in names] == [1.0, 1.962, 9.81]


VALUES = {"Real": 1.0, "Integer": 1, "Boolean": True, "String": "one"}


@pytest.mark.parametrize("kind", VALUES)
def test_unknown_references_and_wrong_types(ready, kind):
    """Of a variable of each type, and of none."""
    names = {"ball.mass": "Real", "contact.model": "Integer", "inContact[1]": "Boolean"}
    places = {name: ready.fmu.variables[name].valueReference for name in names if names[name] != kind}
    for name, reference in (places | {"4000000000": 4_000_000_000}).items():
        assert name in refused(ready, getattr(ready.slave, f"get{kind}"), [reference])
        assert name in refused(ready, getattr(ready.slave, f"set{kind}"), [reference], [VALUES[kind]])
    still_works(ready)


def test_what_may_be_set_and_when(ready):
    """Not what the FMU calculates, nor fixed parameters in a run; tunable parameters and inputs, but not to nonsense."""
    for name, kind in (
        ("x[1]", "Real"),
        ("E_residual", "Real"),
        ("pulses[1]", "Integer"),
        ("inContact[1]", "Boolean"),
        ("pendulum.period", "Real"),
        ("gravity", "Real"),
        ("x_start[1]", "Real"),
    ):
        old = ready.get(name)
        refused_set(ready, name, VALUES[kind], kind)
        assert ready.get(name) == old
    for name in ("pendulum.drag", "contact.damping", "contact.huntCrossley", "contact.relaxationTime"):
        refused_set(ready, name, -1.0)
        assert ready.get(name) == 0.0
    still_works(ready)
    ready.set({"pendulum.drag": 0.1})
    ready.step_to(1.1)
    assert ready.get("pendulum.drag") == 0.1
    assert ready.get("E_dissipated") > 0


@pytest.mark.parametrize(
    ("start", "step", "says"),
    [(0.1, size, r"> 0|positive|finite") for size in (0.0, -0.01, NAN, INF)]
    + [(start, 0.01, r"0\.1") for start in (0.0, 0.1 + 1e-9, 0.2, NAN)],
)
def test_steps_that_lead_nowhere(ready, start, step, says):
    before = ready.get("x[1]")
    assert re.search(says, refused(ready, ready.slave.doStep, start, step))
    assert ready.get("x[1]") == before
    still_works(ready)


OTHER = "{00000000-0000-0000-0000-000000000000}"
DAMAGE = {
    "whole": lambda data: data,
    "empty": lambda data: b"",
    "binary rubbish": lambda data: bytes(range(256)) * 4,
    "cut in half": lambda data: data[: len(data) // 2],
    "of another cradle": lambda data: data.replace(b'"balls": 5', b'"balls": 7'),
    "missing": None,  # then the default FMU is what the binary has built in
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_instantiated_is_what_the_description_says(fmu, tmp_path, damage):
    """Only whole resources, or none, with the FMU's own GUID."""
    folder = tmp_path / "fmu"
    shutil.copytree(fmu.folder, folder)
    for path in (path for path in (folder / "resources").rglob("*") if path.is_file()):
        if DAMAGE[damage]:
            path.write_bytes(DAMAGE[damage](path.read_bytes()))
        else:
            path.unlink()
    for guid in (fmu.description.guid, OTHER):
        log: list[nc.LogLine] = []
        callbacks = router.callbacks(log)
        slave = FMU2Slave(
            guid=guid, modelIdentifier="NewtonsCradle", unzipDirectory=str(folder), instanceName="x"
        )
        if guid != OTHER and damage in ("whole", "missing"):
            slave.instantiate(callbacks=callbacks)
            slave.freeInstance()
            assert log == []
        else:
            with pytest.raises(Exception, match="Failed to instantiate"):
                slave.instantiate(callbacks=callbacks)
            assert log and log[-1].status >= ERROR
            if damage in ("whole", "missing"):
                assert OTHER in log[-1].text and fmu.description.guid in log[-1].text
        router.forget(callbacks)
