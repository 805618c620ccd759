"""Presets and what else an FMU brings along to be checked and tried by. One list of presets, with equal values: in the
command line, Python, the live page, SSP and both kinds of FMUs; reference results; the lines of the documentation."""

import json
import os
import re
import sys
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT, SCRIPTS, ended
from fmpy.ssp.ssd import read_ssv

pytestmark = pytest.mark.all

LIFTED_BY_HAND = ("textbook", "steel", "rigid")  # on the page, which therefore leaves their release out
REFERENCE = "extra/org.fmi-standard.fmi-ls-ref"


def numbers(fmu, values: dict) -> dict:
    return {name: float(value) for name, value in fmu.settings(values).items()}


def in_set(fmu, preset: str) -> dict:
    """The values in a parameter set, which has the FMU's units; in that of FMI 3.0 arrays have their size."""
    path, values = Path(fmu.folder, REFERENCE, f"{preset}.ssv"), {}
    for parameter in ElementTree.parse(path).iterfind(".//{*}Parameter"):
        name, value, *size = parameter.get("name"), *parameter
        elements = value.get("value").split()
        assert not size or len(elements) == int(size[0].get("size")) == fmu.balls
        # Of contacts the last element belongs to none.
        named = {f"{name}[{i}]": text for i, text in enumerate(elements, 1)} if size else {name: elements[0]}
        assert value.get("unit", "") == fmu.unit(next(iter(named)))
        last = f"[{fmu.balls}]" if name.startswith("contact.") else None
        values |= {key: text for key, text in named.items() if last is None or not key.endswith(last)}
    return numbers(fmu, values)


def test_presets_are_listed_in_one_order(producer):
    lines = ended(producer, "presets").stdout.splitlines()
    assert [line.split()[0] for line in lines] == nc.presets()
    for path in (ROOT / "web/page/texts").glob("*.json"):
        assert list(json.loads(path.read_bytes())["presets"]) == nc.presets()


@pytest.mark.parametrize("name", nc.presets())
@pytest.mark.parametrize("standard", [2, 3])
def test_presets_give_an_fmu_its_start_values(fmu_path, producer, name, standard):
    with nc.build(preset=name, fmi=standard, binaries=fmu_path) as built:
        wanted = numbers(built, nc.preset(name))
        assert "0 problem(s)" in ended(producer, "check", built.path).stdout
        assert built.balls == sum(key.startswith("x_start[") for key in wanted)
        assert {key: built.built_with(key) for key in wanted} == wanted
        told = in_set(built, name)
        assert {key: told.get(key, built.built_with(key)) for key in wanted} == wanted


def test_presets_of_the_page_have_the_same_start_values(page, fmu):
    """What it leaves out are the FMU's own; where one lifts by hand, balls are at rest and on arcs."""
    starts = page.execute_script("return Object.keys(PRESETS).map((name) => PRESETS[name].setup().recipe().start)")
    assert page.execute_script("return Object.keys(PRESETS)") == nc.presets()
    for name, start in zip(nc.presets(), starts, strict=True):
        rest = ("x_start", "v_start", "pendulum.model") if name in LIFTED_BY_HAND else ()
        for key, value in nc.preset(name).items():
            if not key.startswith(rest or "?"):
                assert start[key] == value if key in start else fmu.built_with(key) == fmu.number(key, value), (
                    name,
                    key,
                )


@pytest.mark.parametrize("balls", [1, 5, 13])
def test_presets_parameter_sets_give_the_reference_results(cradle, fmu_path, balls):
    """Each parameter set of the manifest, applied by FMPy, gives the results with the same label."""
    fmu, files = cradle(balls=balls, binaries=fmu_path), {}
    folder = Path(fmu.folder, REFERENCE)
    for related in ElementTree.parse(folder / "fmi-ls-manifest.xml").getroot():
        source = (folder / related.get("source")).resolve()
        assert source.exists(), source
        for label in related.findall("Label"):
            files.setdefault(label.get("name"), {})[related.get("role")] = source
    of_balls = {name: sum(key.startswith("v_start[") for key in nc.preset(name)) for name in nc.presets()}
    presets = [name for name, n in of_balls.items() if n == balls]
    assert set(files) == {f"cradle:{name}" for name in ["start", *presets]}
    for name, roles in files.items():
        expected = np.genfromtxt(roles["result"], delimiter=",", names=True, deletechars="")
        set_up = read_ssv(str(roles["parameter"])).parameters
        start = {p.name: fmu.number(p.name, p.value) for p in set_up}
        columns, stop = list(expected.dtype.names)[1:], expected["time"][-1]
        options = {"stop_time": stop, "output_interval": 0.1, "output": columns}
        result = fmpy.simulate_fmu(str(fmu.path), start_values=start, **options)
        for column in ("time", *columns):
            error = np.abs(result[column] - expected[column]).max()
            assert error <= 1e-9 * np.abs(expected[column]).max(), (name, column, error)


def test_preset_desk_comes_to_rest(cradle, fmu_path):
    """Below 1 mm after about a minute."""
    result = cradle(preset="desk", binaries=fmu_path).simulate(stop=70.0, record=["x"])
    assert 50.0 < result["time"][np.abs(result["x"]).max(axis=1) > 1e-3][-1] < 65.0


def test_presets_lines_of_the_documentation_run(cradle, fmu_path, tmp_path):
    """The Python program and the command of the page, as they stand."""
    two = cradle(balls=2, out=tmp_path / "NewtonsCradle.fmu", binaries=fmu_path)
    page = Path(two.folder, "documentation/index.html").read_text(encoding="utf-8")
    program, command = (
        unescape(re.search(rf'id="{name}"[^>]*>(.*?)</', page, re.DOTALL)[1]) for name in ("python", "command")
    )
    printed = ended(sys.executable, "-c", program, cwd=tmp_path).stdout.splitlines()
    assert len(printed) == 21 and "ball 1 at -0.1000 m" in printed[0]
    environment = os.environ | {"PATH": f"{SCRIPTS}{os.pathsep}{os.environ['PATH']}"}
    ended("sh", "-c", command, cwd=tmp_path, env=environment)
    header, *rows = (tmp_path / "result.csv").read_text().splitlines()
    assert '"x[2]"' in header and len(rows) == 1001


def test_presets_of_spheres_are_drawn_at_their_sizes(page):
    """Radii where they are set or materials differ; otherwise those of one material, by the masses."""
    sizes = {
        name: page.execute_script(f"return PRESETS.{name}.setup().drawing.sizes") for name in ("tapered", "unlike")
    }
    assert sizes == {"tapered": [1, 0.8, 0.64, 0.512, 0.4096], "unlike": [1] * 5}
    heavy = page.execute_script("return PRESETS.steel.setup().with({ 'ball.massRatio': [1, 8] }).drawing.sizes")
    assert heavy == [1, 2, 1, 1, 1]
