"""Nonsense is refused with an error that names variable, value and what is allowed, and does no harm."""

import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

import newtons_cradle as nc
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave

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


def refused_set(run, name, value, setter="setReal") -> str:
    """Sets one variable, which must be refused."""
    return refused(run, getattr(run.slave, setter), [run.fmu.variables[name].valueReference], [value])


def start_of(run, name) -> float:
    """The start value of the description; an enumeration's integer likewise."""
    return float(run.fmu.variables[name].start)


def still_works(run) -> None:
    """The instance goes on as if nothing had been asked: the default run's first impact is there.

    Every refused value would move that impact or put it elsewhere in the log, had it been applied.
    """
    if run.time == 0.0:
        run.initialize()
    run.step_to(1.0)
    assert run.pulses["onset"][0] == pytest.approx(0.702493100658, abs=1e-9)


BAD_VALUES = [  # variable, value, what its message says about the value, and about what is allowed
    ("ball.mass", 0.0, r"\b0\b", r"> 0"),
    ("ball.mass", -1.0, r"-1\b", r"> 0"),
    ("ball.mass", NAN, r"(?i)nan", r"> 0"),
    ("ball.mass", INF, r"(?i)inf", r"> 0"),
    ("ball.mass", -INF, r"(?i)-inf", r"> 0"),
    ("ball.massRatio[3]", 0.0, r"\b0\b", r"> 0"),
    ("ball.radius", -0.01, r"-0\.01\b", r"> 0"),
    ("ball.poissonRatio", 0.6, r"0\.6\b", r"0\.5"),
    ("gravity", -9.81, r"-9\.81\b", r">= 0"),
    ("pendulum.length", 0.0, r"\b0\b", r"> 0"),
    ("pendulum.drag", -0.1, r"-0\.1\b", r">= 0"),
    ("contact.exponent", 0.5, r"0\.5\b", r"1.*10"),
    ("contact.exponent", 10.5, r"10\.5\b", r"1.*10"),
    ("contact.stiffness", 0.0, r"\b0\b", r"> 0"),
    ("contact.deadBand", -1e-6, r"-(1e-0?6|0\.000001)\b", r">= 0"),
    ("contact.gap[1]", NAN, r"(?i)nan", r"finite"),
    ("x_start[2]", INF, r"(?i)inf", r"finite"),
    ("v_start[5]", NAN, r"(?i)nan", r"finite"),
    ("solver.tolerance", 1.0, r"\b1\b", r"1e-0?14|0\.001|1e-0?3"),
    ("F_ext[2]", NAN, r"(?i)nan", r"finite"),
    ("a_support", -INF, r"(?i)-inf", r"finite"),
]


@pytest.mark.parametrize(("name", "value", "says", "allowed"), BAD_VALUES)
def test_bad_value(bare, name, value, says, allowed):
    text = refused_set(bare, name, value)
    assert name in text
    assert re.search(says, text.replace(name, "")), text
    assert re.search(allowed, text.replace(name, "")), text
    still_works(bare)
    assert bare.get(name) == start_of(bare, name)


@pytest.mark.parametrize(
    ("name", "value"), [("contact.model", 0), ("contact.model", 99), ("contact.dampingLaw", -1)]
)
def test_bad_choice(bare, name, value):
    text = refused_set(bare, name, value, "setInteger")
    assert name in text and str(value) in text
    assert re.search("powerLaw|kelvinVoigt", text), text
    still_works(bare)
    assert bare.get(name) == start_of(bare, name)


def test_one_bad_value_spoils_the_whole_call_and_nothing_else(bare):
    names = ["ball.mass", "pendulum.length", "gravity"]
    references = [bare.fmu.variables[name].valueReference for name in names]
    text = refused(bare, bare.slave.setReal, references, [2.0, -1.0, 1.6])
    assert "pendulum.length" in text
    still_works(bare)
    assert [bare.get(name) for name in names] == [1.0, 1.962, 9.81]


@pytest.mark.parametrize("kind", ["Real", "Integer", "Boolean", "String"])
@pytest.mark.parametrize("reference", [4_000_000_000, 77_777])
def test_unknown_value_reference(ready, kind, reference):
    assert all(v.valueReference != reference for v in ready.fmu.description.modelVariables)
    assert str(reference) in refused(ready, getattr(ready.slave, f"get{kind}"), [reference])
    value = {"Real": 1.0, "Integer": 1, "Boolean": True, "String": "one"}[kind]
    assert str(reference) in refused(ready, getattr(ready.slave, f"set{kind}"), [reference], [value])
    still_works(ready)


@pytest.mark.parametrize(
    ("name", "wrong", "value"),
    [
        ("ball.mass", "Integer", 2),
        ("ball.mass", "Boolean", True),
        ("ball.mass", "String", "2"),
        ("contact.model", "Real", 1.0),
        ("pulses[1]", "Real", 1.0),
        ("inContact[1]", "Integer", 1),
    ],
)
def test_wrong_type(ready, name, wrong, value):
    reference = ready.fmu.variables[name].valueReference
    others = [v for v in ready.fmu.description.modelVariables if v.valueReference == reference]
    assert [v.name for v in others] == [name], "value references are unique over all types"
    assert name in refused(ready, getattr(ready.slave, f"set{wrong}"), [reference], [value])
    assert name in refused(ready, getattr(ready.slave, f"get{wrong}"), [reference])
    still_works(ready)


@pytest.mark.parametrize(
    ("name", "setter", "value"),
    [
        ("x[1]", "setReal", 0.5),
        ("E_total", "setReal", 1.0),
        ("E_residual", "setReal", 0.0),
        ("pulses[1]", "setInteger", 3),
        ("inContact[1]", "setBoolean", True),
        ("pendulum.period", "setReal", 2.0),
    ],
)
def test_setting_what_the_fmu_calculates(bare, name, setter, value):
    assert name in refused_set(bare, name, value, setter)
    still_works(bare)
    old = bare.get(name)
    assert name in refused_set(bare, name, value, setter)
    assert bare.get(name) == old


def test_fixed_parameters_are_fixed_between_steps(ready):
    for name, value in (("gravity", 1.6), ("ball.mass", 2.0), ("x_start[1]", 0.0)):
        assert name in refused_set(ready, name, value)
    still_works(ready)


def test_tunable_parameters_and_inputs_may_change_between_steps_but_not_to_nonsense(ready):
    for name in ("pendulum.drag", "contact.damping", "contact.huntCrossley", "contact.relaxationTime"):
        assert name in refused_set(ready, name, -1.0)
        assert ready.get(name) == 0.0
    assert "F_ext[1]" in refused_set(ready, "F_ext[1]", NAN)
    ready.set({"pendulum.drag": 0.1})
    ready.step_to(0.2)
    assert ready.get("pendulum.drag") == 0.1
    assert ready.get("E_dissipated") > 0


@pytest.mark.parametrize("step", [0.0, -0.01, NAN, INF])
def test_steps_that_lead_nowhere(ready, step):
    before = ready.get("x[1]")
    text = refused(ready, ready.slave.doStep, ready.time, step)
    assert re.search("(?i)step", text) and re.search(r"> 0|positive|finite", text), text
    assert ready.get("x[1]") == before
    still_works(ready)


@pytest.mark.parametrize("start", [0.0, 0.1 + 1e-9, 0.2, NAN])
def test_a_step_from_another_time(ready, start):
    text = refused(ready, ready.slave.doStep, start, 0.01)
    assert "0.1" in text, text
    still_works(ready)


def test_a_step_from_a_time_off_by_rounding_is_taken(ready):
    ready.slave.doStep(0.1 + 5e-13, 0.01)


def test_a_step_before_initialization(bare):
    assert "fmi2DoStep" in refused(bare, bare.slave.doStep, 0.0, 0.01)
    bare.slave.setupExperiment(startTime=0.0)
    bare.slave.enterInitializationMode()
    assert "fmi2DoStep" in refused(bare, bare.slave.doStep, 0.0, 0.01)
    bare.slave.exitInitializationMode()
    bare.step_to(1.0)
    assert bare.pulses["onset"][0] == pytest.approx(0.702493100658, abs=1e-9)


def test_an_instance_may_be_freed_in_any_state(fmu):
    for leave in ("instantiated", "set up", "initializing", "stepping", "refused"):
        with fmu.start(initialize=False) as run:
            if leave == "refused":
                refused(run, run.slave.doStep, 0.0, 0.01)
            if leave in ("set up", "initializing", "stepping"):
                run.slave.setupExperiment()
            if leave in ("initializing", "stepping"):
                run.slave.enterInitializationMode()
            if leave == "stepping":
                run.slave.exitInitializationMode()
                run.step_to(0.75)
        assert not run._alive


def instantiate(folder, guid) -> tuple[bool, list]:
    """Whether an unpacked FMU can be instantiated with a GUID, and what it logged."""
    from newtons_cradle.run.log import router

    log: list[nc.LogLine] = []
    callbacks = router.callbacks(log)
    slave = FMU2Slave(
        guid=guid, modelIdentifier="NewtonsCradle", unzipDirectory=str(folder), instanceName="x"
    )
    try:
        slave.instantiate(callbacks=callbacks)
    except Exception as error:
        assert "Failed to instantiate" in str(error)
        return False, log
    finally:
        router.forget(callbacks)
    slave.freeInstance()
    return True, log


def test_wrong_guid(fmu):
    wrong = "{00000000-0000-0000-0000-000000000000}"
    worked, log = instantiate(fmu.folder, wrong)
    assert not worked
    text = " ".join(line.text for line in log if line.status >= ERROR)
    assert wrong in text and fmu.description.guid in text
    assert instantiate(fmu.folder, fmu.description.guid) == (True, [])


@pytest.fixture
def copy(fmu, tmp_path) -> Path:
    """A copy of the unpacked FMU to be damaged."""
    return Path(shutil.copytree(fmu.folder, tmp_path / "fmu"))


def resources_of(folder: Path) -> list[Path]:
    """The files in resources/."""
    files = [path for path in (folder / "resources").rglob("*") if path.is_file()]
    assert files
    return files


DAMAGE = {
    "empty": lambda data: b"",
    "binary rubbish": lambda data: bytes(range(256)) * 4,
    "cut in half": lambda data: data[: len(data) // 2],
    "rubbish at the end": lambda data: data + b"\n\xff}]garbage = what",
    "zeros": lambda data: bytes(len(data)),
}


def test_resources_of_another_cradle(fmu, copy):
    """Intact, but not what the description was made for."""
    for path in resources_of(copy):
        text = path.read_text()
        assert '"balls": 5' in text
        path.write_text(text.replace('"balls": 5', '"balls": 7'))
    worked, log = instantiate(copy, fmu.description.guid)
    assert not worked
    assert any(fmu.description.guid in line.text for line in log if line.status >= ERROR), log


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_resources(fmu, copy, damage):
    for path in resources_of(copy):
        path.write_bytes(DAMAGE[damage](path.read_bytes()))
    worked, log = instantiate(copy, fmu.description.guid)
    assert not worked
    assert any(line.status >= ERROR for line in log), log


def test_missing_resources_mean_the_built_in_defaults(fmu, copy):
    """The default FMU is what the binary has built in; any other GUID must not pass for it."""
    for path in resources_of(copy):
        path.unlink()
    assert instantiate(copy, fmu.description.guid) == (True, [])
    other = "{00000000-0000-0000-0000-000000000001}"
    worked, log = instantiate(copy, other)
    assert not worked
    assert any(other in line.text for line in log if line.status >= ERROR)


@pytest.mark.parametrize("pointers", ["null", "valid"])
def test_calls_on_a_null_component(fmu_path, pointers):
    """Every exported function on no instance, in a process of its own: fmi2Error each, and no crash."""
    script = Path(__file__).with_name("null_component.py")
    done = subprocess.run([sys.executable, script, fmu_path, pointers], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    answers = dict(line.split() for line in done.stdout.splitlines())
    assert len(answers) == 31
    assert answers.pop("fmi2FreeInstance") == "None"
    assert set(answers.values()) == {"3"}, answers


def test_null_arrays(ready):
    """No array is fine where nothing is asked for, and refused where something is."""
    low = ready.slave
    for kind in ("Real", "Integer", "Boolean", "String"):
        for access in ("Get", "Set"):
            function = getattr(low, f"fmi2{access}{kind}")
            assert function(low.component, None, 0, None) == 0
            refused(ready, function, low.component, None, 1, None)
    still_works(ready)
