"""Instances are used again after a reset, and nobody notices; descriptions are read as far as they are asked for."""

import contextlib
from zipfile import ZipFile

import newtons_cradle as nc
import pytest
from newtons_cradle.run.description import Description


@pytest.fixture(params=[2, 3])
def fresh(request, fmu, fmu3):
    """An FMU of either version that no instance was made of."""
    with nc.Fmu((fmu if request.param == 2 else fmu3).path) as opened:
        yield opened


def test_instances_are_used_again_once_their_run_has_ended(fresh):
    with fresh.start() as one, fresh.start() as two:
        one.step_to(1.0)
        instances = one._instance, two._instance
        assert instances[0] is not instances[1]
    pulses, lines = one.pulses, list(one.log)
    with fresh.start(nc.lifted(1)) as three, fresh.start() as four, fresh.start() as five:
        assert {id(three._instance), id(four._instance)} == set(map(id, instances))
        assert id(five._instance) not in map(id, instances)
        three.step_to(2.0)
        assert len(three.pulses) == 4 and len(four.log) == 0
    assert one.pulses.tobytes() == pulses.tobytes() and list(one.log) == lines and len(lines) == 6
    with pytest.raises(nc.FmuError, match="the run is closed"):
        one.slave.getVersion()


def test_instances_somebody_may_have_are_not_used_again(fresh):
    """FMPy's functions were asked for, a call has failed, or the block has ended by an exception."""

    def lent(run):
        assert run.slave

    def failed(run):
        with contextlib.suppress(nc.InvalidValue):
            run.set({"contact.damping": -1.0})

    def raised(run):
        raise KeyboardInterrupt

    for spoil in (lent, failed, raised):
        with contextlib.suppress(KeyboardInterrupt), fresh.start() as run:
            spoil(run)
        assert fresh._idle == []
    fresh.start().close()
    assert len(fresh._idle) == 1


@pytest.mark.parametrize(
    "before",
    [
        {"contact.model": "rigid", "contact.restitution": 0.5, "F_ext[5]": -3},
        {"contact.model": "hertz", "contact.dampingLaw": "huntCrossley", "contact.huntCrossley": 0.3, "gravity": 0.0},
        {"solver.method": "adams", "x_start": [-0.2, 0, 0, 0, 0], "contact.stiffness": 1e6},
    ],
)
def test_runs_leave_nothing_behind(fresh, before):
    with nc.Fmu(fresh.path) as other:
        wanted = other.simulate(stop=2.0)
    fresh.simulate(before, stop=1.0, inputs=lambda t: {"a_support": t})
    with fresh.start(before) as run:
        run.step_to(0.3)
        run.save()
    assert len(fresh._idle) == 1
    found = fresh.simulate(stop=2.0)
    assert found == wanted and found.given == wanted.given


@pytest.mark.all
def test_descriptions_of_ten_thousand_balls_are_read_lazily(cradle, fmu_path):
    for fmi in (2, 3):
        row = cradle(balls=10_000, fmi=fmi, binaries=fmu_path)
        assert row.balls == 10_000 and row.arrays["x"][-1] == "x[10000]"
        with row.start({"x_start[1]": -0.2}) as run:
            assert run["x[1]"] == -0.2 and run["x"].shape == (10_000,) and run.get("F[9999]") == 0.0
        assert "x[10001]" not in row.variables and "x[0]" not in row.variables and "x[01]" not in row.variables
        assert len(row.variables._made) < 60
        with pytest.raises(nc.UnknownName, match=r"x\[1\] to x\[10000\] are in"):
            row.variable("x[10001]")


def described(variables: str, root: str = 'fmiVersion="2.0" modelName="Other"') -> Description:
    parts = f"<ModelVariables>{variables}</ModelVariables><ModelStructure/>"
    text = f"<fmiModelDescription {root}>{parts}</fmiModelDescription>"
    return Description(text.encode(), "other.fmu")


def test_descriptions_of_others_are_read_however_they_are_written():
    """Other orders of attributes, quotes, comments and entities than ours."""
    found = described("""
      <!-- <ScalarVariable name="none" valueReference="9"><Real/></ScalarVariable> -->
      <ScalarVariable valueReference='7' causality='output' name='a&lt;b[1]' description='x > y'>
        <Real unit="m" start="1"/><Annotations/></ScalarVariable>
      <ScalarVariable name="c" valueReference="8"><String start="text"/></ScalarVariable>""").variables
    assert list(found) == ["a<b[1]", "c"] and found.named("output") == ["a<b[1]"] and found.named("local") == ["c"]
    first = found["a<b[1]"]
    assert (first.type, first.unit, first.valueReference, first.start) == ("Real", "m", 7, "1")
    assert (
        found.place("a<b[1]").reference == 7
        and found["c"].type == "String"
        and dict(found.arrays) == {"a<b": ["a<b[1]"]}
    )
    for variables in ("<ScalarVariable", "<ScalarVariable name='x'></Real>", "<!-- -- -->"):
        with pytest.raises(
            nc.FmuError, match=r"^other\.fmu is not an FMU that can be read: its modelDescription\.xml: "
        ):
            list(described(variables).variables)


DAMAGES = {  # text of a description, what it becomes, and who finds it
    'valueReference="': ('valueReference="x', lambda fmu: fmu.parameters),
    'start="': ('start="x', lambda fmu: fmu.built_with("gravity")),
    'factor="': ('factor="x', lambda fmu: fmu.start({"contact.deadBand": (1.0, "um")})),
    'value="': ('value="x', lambda fmu: fmu.items("contact.model")),
    "/>": (">", lambda fmu: fmu.simulate(stop=0.1)),
    "</ModelVariables>": ("", lambda fmu: fmu.variables),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_descriptions_that_are_damaged_are_one_error(fresh, tmp_path, damage):
    path, (change, use) = tmp_path / "damaged.fmu", DAMAGES[damage]
    with ZipFile(fresh.path) as source, ZipFile(path, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "modelDescription.xml":
                data = data.replace(damage.encode(), change.encode())
            target.writestr(name, data)
    complaint = r"damaged\.fmu is not an FMU that can be read: its modelDescription\.xml"
    with pytest.raises(nc.FmuError, match=complaint), nc.Fmu(path) as fmu:
        use(fmu)
