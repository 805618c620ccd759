"""What a host is told of nonsense, through FMPy: fmi2Error, with a message that names variable, value and what is
allowed; and the instance goes on. tests/rust/ffi goes through all functions, variables and states.
"""

import math
import re

import newtons_cradle as nc
import pytest
from fmpy.fmi1 import FMICallException

NAN = math.nan
#: kind of the setter, variable, value, what its message says of the value, and of what is allowed
REFUSED = [
    ("Real", "ball.mass", 0.0, r"\b0\b", r"> 0"),
    ("Real", "ball.massRatio[3]", -1.0, r"-1\b", r"> 0"),
    ("Real", "ball.poissonRatio", 0.6, r"0\.6\b", r"0\.5"),
    ("Real", "contact.exponent", 10.5, r"10\.5\b", r"1.*10"),
    ("Real", "contact.gap[1]", NAN, r"(?i)nan", r"finite"),
    ("Real", "F_ext[2]", math.inf, r"(?i)inf", r"finite"),
    ("Integer", "contact.model", 99, "99", "powerLaw"),
    ("Integer", "contact.dampingLaw", -1, "-1", "kelvinVoigt"),
    ("Integer", "ball.mass", 2, "", "Real"),
    ("Real", "E_total", 1.0, "", ""),
    ("Integer", "pulses[1]", 3, "", ""),
]


@pytest.fixture
def run(fmu):
    """An instance that is only instantiated."""
    with fmu.start(initialize=False) as started:
        yield started


def refused(run, function, *args) -> str:
    """Calls a function of the slave, which must answer fmi2Error and log why; returns the text."""
    before = len(run.log)
    with pytest.raises(FMICallException) as caught:
        function(*args)
    assert caught.value.status == 3
    errors = [line for line in run.log[before:] if line.status == 3]
    assert errors, "refused without a word"
    assert all(line.category == "logStatusError" for line in errors)
    return " ".join(line.text for line in errors)


def still_works(run) -> None:
    """The instance goes on as if nothing had been asked: the default run's first impact is there.

    Every refused value would move that impact or put it elsewhere in the log, had it been applied.
    """
    if run.time == 0.0:
        run.initialize()
    run.step_to(1.0)
    assert run.pulses["onset"][0] == pytest.approx(0.702493100658, abs=1e-9)


@pytest.mark.parametrize(("kind", "name", "value", "says", "allowed"), REFUSED)
def test_bad_value(run, kind, name, value, says, allowed):
    variable = run.fmu.variables[name]
    text = refused(run, getattr(run.slave, f"set{kind}"), [variable.valueReference], [value])
    assert name in text
    assert re.search(says, text.replace(name, "")) and re.search(allowed, text.replace(name, "")), text
    still_works(run)
    assert variable.start is None or run.get(name) == float(variable.start)


@pytest.mark.parametrize(
    ("start", "step", "says"),
    [(0.1, size, r"> 0|positive|finite") for size in (0.0, -0.01, NAN)] + [(0.2, 0.01, r"0\.1"), (NAN, 0.01, r"0\.1")],
)  # fmt: skip
def test_steps_that_lead_nowhere(run, start, step, says):
    run.initialize()
    run.step_to(0.1)
    assert re.search(says, refused(run, run.slave.doStep, start, step))
    still_works(run)


def test_another_guid(fmu):
    """FMPy cannot instantiate, and both GUIDs are in the log."""
    other = "{00000000-0000-0000-0000-000000000000}"
    with nc.Fmu(fmu.path) as copy:
        own, copy.description.guid = copy.description.guid, other
        with pytest.raises(nc.FmuError) as caught:
            copy.start()
    assert other in str(caught.value) and own in str(caught.value)
