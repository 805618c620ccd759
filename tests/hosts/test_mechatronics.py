"""The cradle in a larger model, small: two FMUs coupled by a master and as an SSP by FMPy, libcosim and ecos; the
presets' SSP."""

import json
import shutil
import subprocess
import sys
import zipfile
from contextlib import nullcontext
from functools import cache

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT, ended
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv, validate_tree
from fmpy.validation import validate_fmu
from lxml import etree
from other_hosts import command

pytestmark = pytest.mark.all

SCRIPT = ROOT / "examples/mechatronics/couple.py"
DOCUMENT = (ROOT / "docs/coupling.md").read_text(encoding="utf-8")
# Those that numbers alone tell an FMU of five balls.
PRESETS = {"default": {}, "figure5_overlapping": nc.figure5(0.0)}
PRESETS |= {name: nc.preset(name) for name in ("textbook", "figure5", "figure6")}


@pytest.fixture(scope="module")
def couple(fmu_path, tmp_path_factory):
    """The example as typed, with two of its communication steps and the plant in a language: its folder, and the
    finished process."""

    @cache
    def run(language):
        out = tmp_path_factory.mktemp(f"mechatronics_{language}")
        options = ["--steps", "2", "--plant", language]
        return out, ended(sys.executable, SCRIPT, "--fmu", fmu_path, "--out", out, *options)

    return run


LANGUAGES = pytest.mark.parametrize("language", ["c", "python"])


@LANGUAGES
def test_machine_numbers_of_the_document_hold(couple, language, fmu):
    """Orders of the masters, momentum, the force sensor, directional derivatives, energy. The CSV of the run shown has
    the energies exchanged: the coil puts some in, the clicks move it to the last ball. Results say what they are of."""
    out, done = couple(language)
    assert done.stdout.count("agrees") == 17 and "DIFFERS" not in done.stdout
    for name in ("coupling", "machine"):
        assert (out / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert len((out / "convergence.csv").read_text().splitlines()) == 3
    table = np.genfromtxt(out / "machine.csv", delimiter=",", names=True, deletechars="")
    assert table["put_in"].max() > 0.1
    assert table["pulses"][-1] >= 2
    assert table["x[5]"].max() > 0.15
    about = json.loads((out / "about.json").read_text(encoding="utf-8"))
    assert about["guid"] == fmu.description.guid
    assert about["cradle"]["contact.stiffness"] == 1e10 and about["numpy"] == np.__version__


def test_machine_plant_in_c_is_that_in_python(couple, producer):
    """The same variables with units, and the same machine; in C it needs nothing but the system."""
    paths = {"c": couple("c")[0] / "plant.fmu", "python": couple("python")[0] / "CartAndCoil.fmu"}
    assert [problem for path in paths.values() for problem in validate_fmu(str(path))] == []
    described = [read_model_description(str(path)).modelVariables for path in paths.values()]
    ours, theirs = ([(v.name, v.valueReference, v.unit, v.start) for v in part] for part in described)
    assert ours == theirs and all(unit or name in ("pulses", "impacts") for name, _, unit, _ in ours)
    tables = [np.genfromtxt(couple(language)[0] / "machine.csv", delimiter=",", skip_header=1) for language in paths]
    assert tables[0] == pytest.approx(tables[1], abs=1e-9)
    said = ended(producer, "info", paths["c"]).stdout
    assert not sys.platform.startswith("linux") or "linked with libc.so.6, libm.so.6\n" in said


@pytest.mark.parametrize(("name", "structures"), [("machine", 1), ("presets", len(PRESETS))])
def test_ssp_files_obey_their_schema(couple, fmu, name, structures):
    """System and component bind the same numbers: tools read either, and some of them cannot set enumerations."""
    path = couple("c")[0] / f"{name}.ssp"
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        kept = [file for file in names if file.endswith((".ssd", ".ssv"))]
        trees = {file: etree.fromstring(archive.read(file)) for file in kept}
    assert "SystemStructure.ssd" in names and "resources/NewtonsCradle.fmu" in names
    for file, tree in trees.items():
        kind = "Description" if file.endswith(".ssd") else "ParameterValues"
        validate_tree(tree, f"SystemStructure{kind}.xsd")
        known = {unit.get("name") for unit in tree.iter("{*}Unit")}
        assert {element.get("unit") for element in tree.iter("{*}Real")} - {None} <= known
    systems = [tree for file, tree in trees.items() if file.endswith(".ssd")]
    assert len(systems) == structures
    for tree in systems:
        (of_system,) = tree.xpath("*[local-name()='System']/*[local-name()='ParameterBindings']/*/@source")
        (of_component,) = tree.xpath("//*[@name='cradle']/*[local-name()='ParameterBindings']/*/@source")
        whole, part = (
            {parameter.name: parameter.value for parameter in read_ssv(path, source).parameters}
            for source in (of_system, of_component)
        )
        assert whole == {f"cradle.{variable}": value for variable, value in part.items()}
        assert {fmu.variables[variable].type for variable in part} <= {"Real"}


def test_ssp_presets_are_those_of_the_package(couple, fmu):
    path = couple("c")[0] / "presets.ssp"
    with zipfile.ZipFile(path) as archive:
        names = [name.removesuffix(".ssd") for name in archive.namelist() if name.endswith(".ssd")]
    assert names == ["SystemStructure", *list(PRESETS)[1:]]
    for name, values in PRESETS.items():
        parameters = read_ssv(path, f"resources/{name}_cradle.ssv").parameters
        settings = fmu.settings(values).items()
        assert {one.name: float(one.value) for one in parameters} == {
            key: value for key, value in settings if fmu.variables[key].type == "Real"
        }


def by_fmpy(archive, parameter_set, h, steps, names):
    """Rows of the variables `names` at the ends of the steps, by FMPy's runner, which takes the first structure and any
    parameter set."""
    parameters = read_ssv(archive, f"resources/{parameter_set}.ssv")
    result = simulate_ssp(archive, stop_time=(steps - 0.5) * h, step_size=h, parameter_set=parameters)
    return np.column_stack([result[name] for name in names])


def by_another_host(host, archive, parameter_set, h, steps, names):
    """Runs a preset of the system structure in `host`, in a process of its own."""
    folder = archive.with_name(f"{archive.stem}_{parameter_set}_{host}_{steps}")
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder)
    if parameter_set in PRESETS and parameter_set != "default":  # these hosts read this one only
        shutil.copy(folder / f"{parameter_set}.ssd", folder / "SystemStructure.ssd")
    request = {"step": h, "count": steps, "names": names, "parameter_set": parameter_set}
    done = subprocess.run(command(host, folder, **request), capture_output=True, text=True)
    if done.returncode == 77:
        pytest.skip(f"{host} cannot be imported: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stdout + done.stderr
    return np.array(json.loads(done.stdout.splitlines()[-1]))[-steps:, 1:]


BALLS = [f"cradle.x[{i}]" for i in range(1, 6)]


@pytest.mark.parametrize("host", ["alone", "libcosim", "ecos"])
@pytest.mark.parametrize("preset", PRESETS)
def test_ssp_hosts_run_the_presets(couple, fmu, host, preset):
    """As FMPy's SSP runner does, and the FMU on its own; the differences are those of their step arithmetic."""
    given = couple("c")[0] / "presets.ssp", preset, 0.1, 10, BALLS
    alone = fmu.simulate(PRESETS[preset], stop=1.0, step=0.1, record=["x"])["x"][1:]
    theirs = alone if host == "alone" else by_another_host(host, *given)
    ours = by_fmpy(*given)
    assert np.abs(ours[-1]).max() > 1e-2
    assert theirs == pytest.approx(ours, abs=1e-12)


@pytest.mark.parametrize("host", ["libcosim", "ecos"])
@pytest.mark.parametrize("h", [0.1, 0.05])
@LANGUAGES
def test_ssp_hosts_couple_the_machine(couple, language, host, h):
    """Each host holds the outputs of the last step: the error of that, 0.04 m and 0.02 m, is the same in all."""
    given = couple(language)[0] / "machine.ssp", "start", h, round(5.0 / h), [*BALLS, "plant.s"]
    ours = by_fmpy(*given)
    assert np.abs(ours).max() > 0.15
    assert by_another_host(host, *given) == pytest.approx(ours, abs=1e-10)


@pytest.fixture
def run(fmu, monkeypatch):
    """Runs the program under a heading of the document with these changes of its text; `found` gets its names."""
    monkeypatch.setattr(nc, "Fmu", lambda: nullcontext(fmu))

    def run(heading, changes, found):
        program = DOCUMENT.split(f"## {heading}\n")[1].split("```python\n")[1].split("```")[0]
        for old, new in changes.items():
            assert program.count(old) == 1
            program = program.replace(old, new)
        exec(program, found)

    return run


@pytest.mark.parametrize(("step", "row"), [(0.1, "1.8 %"), (0.025, "1.2 %"), (0.001, "0.016 %")])
def test_coupling_check_fails_where_the_step_is_too_long(run, step, row):
    """The program of the document, and the row of its table."""
    found = {}
    with pytest.raises(AssertionError, match="the step is too long") if step > 0.001 else nullcontext():
        run("Put in your own actuator", {"h = 1e-3": f"h = {step}"}, found)
    work, received, energy, finer = (f"{found[name]:.4f}" for name in ("work", "received", "energy", "finer"))
    assert f"| {step} | {work} | {received} | {row} | {energy} | {finer} |" in DOCUMENT
    assert f"{abs(found['work'] / found['received'] - 1) * 100:.2g} %" == row


def test_coupling_frame_follows_its_position(run):
    """The program of the document and its table: errors of order 1, 2 and 4."""

    def positions(h, changes):
        found = {}
        run("A frame that is given by its position", {"h = 0.01 ": f"h = {h} "} | changes, found)
        return np.array(found["x"])

    mean = {"rate = 6": "rate = 0"}
    at_start = mean | {"= mean - rate * h / 2": "= -(math.pi**2) * s0"}
    exact = positions(0.001, {})
    for h in (0.1, 0.01):
        errors = [np.abs(positions(h, changes) - exact).max() for changes in (at_start, mean, {})]
        cells = (f"{error:.1e}".replace("e-0", "e-") for error in errors)
        assert f"| {h} | {' | '.join(cells)} |" in DOCUMENT
