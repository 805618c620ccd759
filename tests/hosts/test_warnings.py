"""Start values that are accepted but hardly ever meant, and parameters without effect: what the log, `cradle-fmu build`
and Python say."""

import warnings

import newtons_cradle as nc
import pytest
from conftest import ended

RIGID, HERTZ = {"contact.model": "rigid"}, {"contact.model": "hertz"}
HUNT_CROSSLEY, VISCOELASTIC = ({"contact.dampingLaw": law} for law in ("huntCrossley", "viscoelastic"))
RK4 = {"solver.method": "rk4"}

RESTITUTION = {"contact.dampingLaw": "constantRestitution"}
HALF = {"contact.restitution": 0.5}
ONE_ELASTIC, ALL_ELASTIC = ({f"contact.lossRatio[{i}]": 0 for i in range(1, last)} for last in (2, 5))

#: Parameters that need something (those that share settings are tried together): a value that is not the default,
#: settings with which it has no effect, others with which it has one, and what the warning says that it needs.
NEEDY = [
    ("ball.youngModulus", 1e11, [{}], [HERTZ], "contact.model = hertz"),
    ("ball.youngModulusRatio[1]", 2.0, [{}, RIGID], [HERTZ], "contact.model = hertz"),
    ("ball.poissonRatio", 0.2, [RIGID], [HERTZ], "contact.model = hertz"),
    ("contact.stiffness", 1e9, [HERTZ], [{}], "contact.model = powerLaw"),
    ("contact.stiffnessRatio[2]", 2.0, [RIGID], [HERTZ], "contact.model = powerLaw or hertz"),
    ("contact.overlapRef", 1e-5, [HERTZ], [{}], "contact.model = powerLaw"),
    ("contact.exponent", 2.0, [RIGID], [{}], "contact.model = powerLaw"),
    ("contact.dampingLaw", "huntCrossley", [RIGID | HALF], [{}], "contact.model = powerLaw or hertz"),
    ("contact.damping", 5.0, [HUNT_CROSSLEY], [HERTZ], "contact.dampingLaw = kelvinVoigt or kelvinVoigtNoPull"),
    (
        "contact.huntCrossley",
        0.3,
        [RIGID],
        [HUNT_CROSSLEY],
        "contact.model = powerLaw or hertz and contact.dampingLaw = huntCrossley",
    ),
    ("contact.relaxationTime", 1e-6, [HUNT_CROSSLEY, RESTITUTION], [VISCOELASTIC], "contact.dampingLaw = viscoelastic"),
    (
        "contact.restitution",
        0.5,
        [{}, HUNT_CROSSLEY],
        [RIGID, RESTITUTION, RESTITUTION | HERTZ],
        "contact.model = rigid or contact.dampingLaw = constantRestitution",
    ),
    (
        "contact.lossRatio[2]",
        3.0,
        [{}, RIGID, RESTITUTION, HUNT_CROSSLEY],
        [RIGID | HALF, RESTITUTION | HALF, {"contact.damping": 5.0}, HUNT_CROSSLEY | {"contact.huntCrossley": 0.3}],
        "contacts with losses (contact.restitution below 1, or a coefficient of contact.dampingLaw above 0)",
    ),
    ("contact.restitution", 0.5, [RIGID | ALL_ELASTIC], [RIGID], "a contact.lossRatio above 0"),
    ("contact.damping", 5.0, [ALL_ELASTIC], [ONE_ELASTIC], "a contact.lossRatio above 0"),
    ("contact.huntCrossley", 0.3, [HUNT_CROSSLEY | ALL_ELASTIC], [HUNT_CROSSLEY], "a contact.lossRatio above 0"),
    ("contact.relaxationTime", 1e-6, [VISCOELASTIC | ALL_ELASTIC], [VISCOELASTIC], "a contact.lossRatio above 0"),
    ("solver.tolerance", 1e-9, [RK4], [{}], "solver.method = eventDriven, bdf or adams"),
    ("solver.fixedStep", 1e-5, [{}], [RK4], "solver.method = rk4"),
]
#: Those that need an instance of one kind; `build` and Python do not know which a file will be used for.
OF_ONE_KIND = {"exchange.contacts": ("resolved", "model exchange"), "solver.method": ("rk4", "co-simulation")}


def together(wasted: bool) -> list[tuple[dict, dict, dict]]:
    """Each of the settings above, with all parameters that have no effect, or that have one, beside it: their values
    and what they need."""
    found = []
    for name, value, without, with_effect, needs in NEEDY:
        for others in without if wasted else with_effect:
            place = next((i for i, (known, *_) in enumerate(found) if known == others), len(found))
            found[place:] = found[place:] or [(others, {}, {})]
            found[place][1][name], found[place][2][name] = value, needs
    return found


def told(values: dict, *calls) -> list[list[str]]:
    """What each call with these values warns of as without effect."""
    found = []
    for call in calls:
        with warnings.catch_warnings(record=True, action="always") as caught:
            call(values)
        assert all(one.filename == __file__ for one in caught)
        found.append([text for text in (str(one.message) for one in caught) if " has no effect" in text])
    return found


def no_effects(lines) -> list[str]:
    """Those that name a parameter without effect."""
    return [line for line in lines if " has no effect" in line]


def logged(fmu, values: dict, **options) -> list[str]:
    """The warnings in the log of an instance that starts with these values."""
    with warnings.catch_warnings(action="ignore"), fmu.start(values, **options) as run:
        return [line.text for line in run.log if line.category == "logStatusWarning"]


def test_warnings_name_each_parameter_without_effect_and_what_it_needs(fmu):
    """Over the whole table, in the log and in Python in the same words; none where it has an effect."""
    for others, given, needs in together(wasted=True):
        (python,) = told(others | given, fmu.start)
        assert python == no_effects(logged(fmu, others | given))
        assert len(python) == len(given) or others.keys() & {"contact.lossRatio[1]"}
        for name in given:
            (line,) = (line for line in python if line.startswith(f"{name} = "))
            assert line.endswith(f" has no effect: it needs {needs[name]}")
    for others, given, _ in together(wasted=False):
        for name, value in given.items():
            used = others | {name: value}
            about = [line for line in told(used, fmu.start)[0] + logged(fmu, used) if line.startswith(f"{name} = ")]
            assert not about, used
    for name, (value, needs) in OF_ONE_KIND.items():
        of_kind = {
            "co-simulation": logged(fmu, {name: value}),
            "model exchange": logged(fmu, {name: value}, exchange=True),
        }
        assert {kind for kind, said in of_kind.items() if not said} == {needs}
    for name, value in without_needs(fmu).items():
        one = {name: value}
        said = told(one, fmu.start)[0] + no_effects(logged(fmu, one))
        assert not said, said


def without_needs(fmu) -> dict:
    """A value for each parameter that needs nothing."""
    families = {name.partition("[")[0] for name, *_ in NEEDY}
    others = {name for name in fmu.parameters if "[" not in name or name.endswith("[1]")} - {*OF_ONE_KIND}
    others = {name for name in others if name.partition("[")[0] not in families}
    items = {"contact.model": "hertz", "pendulum.model": "circular", "pendulum.length": 1.5}
    return {name: items.get(name, 0.015) for name in others}


@pytest.mark.all
def test_warnings_of_a_build_are_those_of_a_run(fmu, producer, tmp_path):
    """By the program and by Python."""

    def build(values: dict) -> None:
        nc.build(set=values, binaries=fmu.path).close()

    def program(values: dict) -> list[str]:
        given = [part for name, value in values.items() for part in ("--set", f"{name}={value}")]
        said = ended(producer, "build", "--from", fmu.path, "--out", tmp_path / "x.fmu", *given).stderr.splitlines()
        return no_effects(line.removeprefix("warning: ") for line in said)

    for others, given, _ in together(wasted=True) + together(wasted=False):
        run, built = told(others | given, fmu.start, build)
        assert run == built == program(others | given)
    for name, (value, _) in OF_ONE_KIND.items():
        assert told({name: value}, build) == [[]]
    assert not program(without_needs(fmu) | {"pendulum.model": "linear"})


@pytest.mark.all
def test_warnings_of_the_page_are_those_of_the_log(page, fmu):
    """Of each parameter that needs something, with and without it, but for methods, of which it has one."""
    start = "return cradle.engine.start({ balls: 5, start: arguments[0] }).warnings"
    for name, value, without, with_effect, _ in NEEDY:
        for others in [] if name.startswith("solver.") else without + with_effect:
            values = others | {name: value}
            with warnings.catch_warnings(action="ignore"), fmu.start(values) as run:
                logged = [line.text for line in run.log if line.category == "logStatusWarning"]
            assert page.execute_script(start, values) == ". ".join(logged), values
            assert bool(logged) >= (others in without)


def test_warnings_leave_presets_alone(either):
    """Only what somebody has set himself is told in Python, and again after a merge."""
    desk = nc.preset("desk")
    with warnings.catch_warnings(action="error"):
        either.start(desk | {"contact.model": "rigid"}).close()
        either.start(desk | {"x_start[1]": -0.02} | {"contact.model": "rigid"}).close()
        for values in (desk | {"contact.restitution": 0.5}, desk | {"contact.restitution": 0.5} | {"gravity": 9.8}):
            with pytest.raises(
                nc.DoubtfulStart, match=r"restitution = 0.5 has no effect: it needs contact.model = rigid or"
            ):
                either.start(values)
            with pytest.raises(nc.DoubtfulStart, match=r"restitution = 0.5 has no effect"):
                nc.build(set=values, binaries=either.path)
        with pytest.raises(nc.DoubtfulStart, match=r"stiffnessRatio\[1\] = 1.5 \(and 3 more\) has no effect"):
            either.start({"contact.model": "rigid", "contact.stiffnessRatio": [1.5] * 4})


def test_warnings_of_a_wrong_sign(either):
    """In the FMU's words; what a preset has is meant."""
    pressed = r"x_start\[3\] = 0.1 m and x_start\[4\] = 0 m press balls 3 and 4"
    with warnings.catch_warnings(action="error"):
        with pytest.raises(nc.DoubtfulStart, match=pressed):
            either.start({"x_start[3]": 0.1})
        either.start(nc.figure5() | {"contact.damping": 1.0}).close()
        either.start(nc.lifted(2)).close()
        with nc.build(preset="figure3", binaries=either.path) as wide:
            wide.simulate({"contact.damping": 1.0}, stop=0.01)
        with pytest.raises(nc.DoubtfulStart, match="ball 1 swings farther than a quarter of its pendulum"):
            either.start(nc.figure5() | {"pendulum.length": 1.0})
        with pytest.raises(nc.DoubtfulStart, match=pressed):
            nc.build(set={"x_start[3]": 0.1}, binaries=either.path)
    for call in (either.start, either.simulate):
        with pytest.warns(nc.DoubtfulStart) as told:
            call({"x_start[3]": 0.1})
        assert told[0].filename == __file__
