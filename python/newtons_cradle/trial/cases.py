"""The cases: small cradles with the known mistakes of tools."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

Points = tuple[tuple[float, float], ...]  #: An input: times (s) with values; a time that occurs twice is a jump.


@dataclass(frozen=True)
class Case:
    """One case. `start`: start values that its FMU is built with; `settings`: those that the host sets; `inputs`: by
    name; `wrong`: the known mistakes, each with the words of the verdict; `other`: other ways that are allowed,
    likewise; `meaning`: what the case shows; `within`: the largest error of a right result, relative to the variable's
    largest value, in model exchange some five times the error of the solver that the case asks for; `alike`: the
    largest difference of two results with the same mistake."""

    title: str
    text: str
    meaning: str
    record: tuple[str, ...]
    wrong: Mapping[str, str]
    start: Mapping[str, Any] = field(default_factory=dict)
    balls: int = 3
    fmi: int = 2
    exchange: bool = False
    stop: float = 2.0  # s
    step: float = 0.1  # s
    within: float = 1e-5  # more than the error of six digits
    alike: float = 1e-5
    other: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, Points] = field(default_factory=dict)
    slopes: bool = False  # the slopes of the inputs are set, too
    events: bool = False  # event mode is used
    early: bool = False  # early return is allowed
    trial: tuple[Any, ...] = ()  # a step that is tried and taken back: its time (s), and inputs by name
    act: Mapping[str, float] = field(default_factory=dict)  # what is set at the first intermediate update
    parts: float = 32  # steps of the judge's solver in one communication step
    tolerance: float = 0.0  # relative, of that solver

    def instructions(self) -> str:
        """What to do, in one paragraph."""
        kind = "model exchange" if self.exchange else "co-simulation"
        modes = " with event mode" if self.events else ""
        modes += ", early return allowed" if self.early else ", without early return" if self.events else ""
        tolerance = f" {self.solver()[:1].upper()}{self.solver()[1:]}." if self.exchange else ""
        linear = "linear between the lines: before each step set their values at its start"
        linear += ", and their slopes" * self.slopes
        how = "jumps, which are input events" if self.exchange else linear
        given = f" Inputs: inputs.csv, {how}." if self.inputs else ""
        given += " The other elements of that array stay 0." if self.inputs and self.fmi == 3 else ""
        point = f"a communication point every {self.step:.12g} s, from 0 to {self.stop:g} s"
        text = f"FMI {self.fmi}.0, {kind}{modes}: {point}.{tolerance}{given} {self.text}".strip()
        return f"{text} Record {', '.join(self.record)}."

    def solver(self) -> str:
        """The solver that it asks for in model exchange."""
        if self.tolerance:
            return f"a relative tolerance of {self.tolerance:g}"
        return f"a relative tolerance of 1e-08, or a method of order 4 with {self.parts:g} steps from point to point"


EXCHANGE: dict[str, Any] = {"exchange": True, "stop": 1.0, "step": 1 / 64, "alike": 0.05}
#: Free balls, whose contacts last 22 ms.
SOFT: dict[str, Any] = {"gravity": 0.0, "contact.stiffness": 1e4, "contact.overlapRef": 1.0}
SOFT |= {"contact.deadBand": 0.0, "exchange.contacts": "resolved"}
RIGID = {"contact.model": "rigid", "contact.deadBand": 0.0}
TRIANGLE: Points = ((0.0, 0.0), (0.5, 4.0), (1.5, -4.0), (2.0, 0.0))
STEPS: Points = ((0.33, 0.0), (0.33, 2.0), (0.57, 2.0), (0.57, -1.0), (0.93, -1.0), (0.93, 3.0))
JUMPS: Points = ((0.0, 0.0), *STEPS, (2.0, 3.0))
NEVER = "events were not handled at all"
EVENTS = {
    "late": "events were handled at the next communication point only, not where they are",
    "timed": "state events were not handled, only time events",
    "never": NEVER,
}
STATES = "an event was not handled, or the states after it were not read: the solver kept the old ones"
IGNORED = "eventHandlingNeeded was ignored: Event Mode was never entered"
FIRST = "the input kept its first value"
MISPLACED = {"element": "the input went to the second ball, not to the first", "sign": "the input had the wrong sign"}
ONCE = "event iteration ended after one round, though the FMU asked for more"

CASES = {
    "grid": Case(
        "the communication grid",
        "The last point is the stop time.",
        "All grids are right by the standard, but results at other times differ.",
        ("x[1]", "x[3]", "v[1]", "E_total"),
        {"shifted": "each row has the values of the communication point before"},
        stop=10.0,
        step=1 / 30,
        other={
            "accumulated": "time is accumulated as t + h",
            "nanoseconds": "the step is rounded to whole nanoseconds",
            "lengths": "steps are h long from k h, and end a rounding away from (k + 1) h",
        },
    ),
    "inputs": Case(
        "inputs held over a step",
        "",
        "Inputs are the values at the start of a step.",
        ("x[1]", "v[1]", "x[2]", "v[2]"),
        {
            "row": "the input was held from line to line of the table where it was to be interpolated",
            "ahead": "the input of each step was that of its end: one step ahead",
            "behind": "the input came one step late",
            "first": FIRST,
        }
        | MISPLACED,
        balls=2,
        inputs={"F_ext[1]": ((0.0, 0.0), (0.35, 3.0), (1.05, -3.0), (2.0, 1.0))},
    ),
    "slopes": Case(
        "inputs interpolated within a step",
        "In FMI 2.0 the slopes are set by fmi2SetRealInputDerivatives.",
        "A tool without input derivatives holds its inputs, which the standard allows; the error is of first order.",
        ("x[1]", "v[1]", "x[2]", "v[2]"),
        {"left": "at the lines of the table the slope was that of the line before", "first": FIRST} | MISPLACED,
        balls=2,
        other={"held": "the input was held over each step, which FMI allows: its slopes were not set"},
        inputs={"F_ext[1]": TRIANGLE},
        slopes=True,
    ),
    "getters": Case(
        "getters after setters",
        "Record outputs and the input at each point after the step that ends there, before the next input is set.",
        "An output is that of its own row; between steps a setter does not change it.",
        ("F_ext[1]", "x[1]", "v[1]", "impulse[1]"),
        {
            "shifted": "each row has the values of the communication point before",
            "behind": "the input came one step late",
            "first": FIRST,
        },
        balls=2,
        other={"next": "each row has the input of the next step"},
        inputs={"F_ext[1]": TRIANGLE},
    ),
    "rollback": Case(
        "a step that is taken back",
        "At 0.7 s save the state, as bytes if you can. Set F_ext[1] = 5 N and step to 0.8 s. Restore the state, and go "
        "to 0.8 s again in two halves.",
        "A master that rejects steps needs the whole state, with time, inputs and counters.",
        ("x[1]", "v[1]", "pulses[1]", "impulse[1]", "F_ext[1]"),
        {
            "twice": "the state was not restored before the step was repeated, which the FMU refuses",
            "anew": "the step was repeated from the start values, not from the state saved",
            "kept": "the input of the step taken back stayed",
        },
        balls=2,
        trial=(0.7, {"F_ext[1]": 5.0}),
    ),
    "derivatives": Case(
        "derivatives of outputs",
        "The derivatives are those that fmi2GetRealOutputDerivatives gives, of order 1, 2 and 3.",
        "A master that extrapolates needs the true derivatives.",
        ("x[1]", "der(x[1])", "der(der(x[1]))", "der(der(der(x[1])))"),
        {
            "order": "each derivative was asked for with an order that is too low by one",
            "difference": "the derivatives are difference quotients of the rows",
        },
        balls=2,
    ),
    "pair": Case(
        "two impacts within a microsecond",
        "Two pairs of balls meet 0.3 us after each other.",
        "A tool may not look away after an event: what happens within its next step is an event, too.",
        ("x[1]", "x[2]", "x[3]", "x[4]", "pulses[1]", "pulses[3]"),
        {"soon": "missed the second of two impacts 0.3 us apart at 0.49 s"} | EVENTS,
        SOFT | {"x_start": [-0.49, 0.0, 2.0, 2.4900003], "v_start": [1.0, 0.0, 1.0, 0.0]},
        balls=4,
        **EXCHANGE,
        within=4e-7,
    ),
    "touch": Case(
        "an event indicator that is next to 0",
        "Balls 2 and 3 touch at rest: their overlap is exactly 0, its indicator just below. It gets positive while the "
        "first contact is closed, when nextEventTime is undefined.",
        "An indicator that changes its sign is an event, however small it is.",
        ("x[1]", "x[2]", "x[3]", "v[1]", "v[2]", "v[3]"),
        {"epsilon": "missed the event of an indicator next to 0 until it exceeded some absolute limit"} | EVENTS,
        SOFT | {"x_start": [-0.49, 0.0, 0.0], "v_start": [1.0, 0.0, 0.0]},
        **EXCHANGE,
        within=2e-5,
    ),
    "time": Case(
        "a time event at a communication point",
        "The contact closes at 0.5 s, which is a communication point.",
        "An event that is due at the end of a step is due, not at the end of the next one.",
        ("x[1]", "x[2]", "v[1]", "v[2]"),
        EVENTS | {"late": "the time event at the communication point 0.5 s was taken at the next one"},
        SOFT | {"x_start": [-0.5, 0.0, 0.2], "v_start": [1.0, 0.0, 0.0]},
        **EXCHANGE,
        within=5e-6,
    ),
    "states": Case(
        "states that jump",
        "The balls are rigid: each impact is an event that changes states.",
        "Where valuesOfContinuousStatesChanged is true, the solver goes on from the new states.",
        ("x[1]", "x[3]", "v[1]", "v[3]"),
        {"states": STATES},
        RIGID | {"gravity": 0.0, "x_start": [-0.49, 0.0, 0.24], "v_start": [1.0, 0.0, 0.0]},
        **EXCHANGE | {"stop": 1.5},
        within=1e-8,
    ),
    "cascade": Case(
        "a cascade of rigid impacts",
        "A heavy ball strikes light ones that touch: they hit each other in many rounds of one instant, a tick of the "
        "clocks for each.",
        "As long as discreteStatesNeedUpdate is true, fmi3UpdateDiscreteStates is to be called.",
        ("x[1]", "x[5]", "pulses[1]", "pulses[2]", "pulses[3]", "pulses[4]"),
        {"once": ONCE, "never": NEVER},
        RIGID | {"x_start": [-0.1, 0.0, 0.0, 0.0, 0.0], "ball.massRatio": [5.0, 1.0, 1.0, 1.0, 1.0]},
        balls=5,
        fmi=3,
        **EXCHANGE,
        within=3e-6,
    ),
    "nothing": Case(
        "events that change nothing",
        "",
        "After an event that changes no state the solver goes on from where it was.",
        ("x[1]", "v[1]", "x[2]", "v[2]"),
        {
            "lost": "at events that change no state the solver went back to the last communication point",
            "late": "the input changed at the next communication point, not where it jumps",
            "states": STATES,
            "first": FIRST,
        }
        | MISPLACED,
        {"x_start": [-0.1, 0.1], "exchange.contacts": "mapped"},
        balls=2,
        **EXCHANGE | {"stop": 2.0, "step": 1 / 16},
        within=1e-6,
        inputs={"F_ext[1]": JUMPS},
    ),
    "start": Case(
        "an event at the start",
        "Rigid balls touch when the run begins, and the first one moves: the impact is at 0 s.",
        "Event Mode after initialization is part of the run: the states are those after its event iteration.",
        ("x[1]", "x[2]", "v[1]", "v[2]"),
        {"before": "the event iteration at the start was left out", "states": STATES},
        RIGID | {"gravity": 0.0, "x_start": [0.0, 0.0], "v_start": [1.0, 0.0]},
        balls=2,
        **EXCHANGE | {"stop": 0.5},
        within=1e-8,
    ),
    "nominals": Case(
        "nominal values that matter",
        "The absolute tolerance of each state is the relative one times its nominal value.",
        "Overlaps are nanometres: a tolerance for metres lets the contact pass unseen.",
        ("v[1]", "v[2]", "E_total", "impulse[1]"),
        {"ones": "the nominal values were taken as 1: the solver's steps are too long for the contact"},
        SOFT | {"contact.stiffness": 1e10, "x_start": [-5e-4, 0.0], "v_start": [1e-3, 0.0]},
        balls=2,
        **EXCHANGE,
        within=1e-2,
        parts=1,
        tolerance=1e-4,
    ),
    "located": Case(
        "a state event within a short contact",
        "Ball 2 is struck for 22 us, and on its way strikes ball 3, 2 um away: nextEventTime is undefined then.",
        "An event is where the indicator changes its sign: behind it the balls press, and the model does not know.",
        ("v[1]", "v[2]", "v[3]", "E_total", "impulse[1]", "impulse[2]"),
        {
            "rough": "the search for an event ended within a microsecond of it",
            "timed": "state events were not handled, only time events",
            "never": NEVER,
        },
        SOFT | {"contact.stiffness": 1e10, "x_start": [-0.49, 0.0, 2e-6], "v_start": [1.0, 0.0, 0.0]},
        **EXCHANGE,
        within=2e-5,
        parts=1,
        tolerance=1e-8,
    ),
    "early": Case(
        "event mode with early return",
        "",
        "A step that returns early ends at lastSuccessfulTime. There Event Mode is due, and the next step begins.",
        ("x[1]", "x[3]", "pulses[1]", "pulses[2]", "impulse[1]"),
        {
            "past": "went on from the end of a step that had returned early, which the FMU refuses",
            "ignored": IGNORED,
            "stale": "the input was not set anew where a step had returned early",
            "first": FIRST,
        }
        | MISPLACED,
        fmi=3,
        events=True,
        early=True,
        inputs={"F_ext[1]": ((0.0, 0.0), (1.0, -0.5), (2.0, 0.0))},
    ),
    "whole": Case(
        "event mode without early return",
        "",
        "Several events may happen within a step: Event Mode after it reports one after the other.",
        ("x[1]", "x[5]", "pulses[1]", "pulses[2]", "pulses[3]", "pulses[4]"),
        {"once": ONCE, "ignored": IGNORED},
        balls=5,
        fmi=3,
        events=True,
    ),
    "clocks": Case(
        "two clocks that tick at once",
        "Rigid balls meet and part in one instant, in which both clocks tick. What belongs to a clock may be read when "
        "it ticks.",
        "All clocks that are active are to be asked, not only the first.",
        ("onset.time", "release.time", "release.impulse[1]", "pulses[1]", "pulses[2]"),
        {
            "clock": "only the first of the clocks that ticked was read",
            "tardy": "what belongs to a clock was read at the point after that of its tick",
            "ignored": IGNORED,
        },
        RIGID,
        fmi=3,
        events=True,
        early=True,
    ),
    "intermediate": Case(
        "intermediate update",
        "When intermediateUpdate is called for the first time, set F_ext[1] = 2 N.",
        "An input that is set within a step acts from there on.",
        ("x[1]", "x[3]", "v[1]", "v[3]"),
        {"after": "the input was set after the step, not when intermediateUpdate was called"} | MISPLACED,
        fmi=3,
        step=0.5,
        other={"never": "intermediateUpdate was not used, which FMI allows: the input was never set"},
        act={"F_ext[1]": 2.0},
    ),
    "arrays": Case(
        "arrays and a structural parameter",
        "In Configuration Mode set n = 3; then x_start = -0.12, 0, 0.05 m and ball.massRatio = 2, 1, 1.",
        "A new n resets all arrays, so they are set after it, each with n elements.",
        ("x[1]", "x[2]", "x[3]", "v[1]", "v[3]"),
        {
            "reset": "the arrays were not set after the number of balls, which resets them",
            "first": "only the first element of each array was set",
        },
        balls=5,
        fmi=3,
        settings={"n": 3, "x_start": [-0.12, 0.0, 0.05], "ball.massRatio": [2.0, 1.0, 1.0]},
    ),
    "binary": Case(
        "a variable of bytes",
        "Write the bytes of log.pulses as hexadecimal digits.",
        "Bytes have a length of their own at each reading, and no closing null.",
        ("x[1]", "log.pulses"),
        {"cut": "the bytes are cut to the length that they had at first"},
        fmi=3,
    ),
}
