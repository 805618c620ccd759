"""One list of presets, with equal values: in the command line, Python, the live page, SSP and both kinds of FMUs."""

import json
from pathlib import Path
from xml.etree import ElementTree

import newtons_cradle as nc
import pytest
from conftest import ROOT, ended

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
        values |= {key: text for key, text in named.items() if key != f"contact.gap[{fmu.balls}]"}
    return numbers(fmu, values)


def test_names_are_listed_in_one_order(producer):
    lines = ended(producer, "presets").stdout.splitlines()
    assert [line.split()[0] for line in lines] == nc.presets()
    for path in (ROOT / "web/page/texts").glob("*.json"):
        assert list(json.loads(path.read_bytes())["presets"]) == nc.presets()


@pytest.mark.parametrize("name", nc.presets())
@pytest.mark.parametrize("standard", [2, 3])
def test_an_fmu_built_with_a_preset_has_its_start_values(fmu_path, producer, name, standard):
    with nc.build(preset=name, fmi=standard, binaries=fmu_path) as built:
        wanted = numbers(built, nc.preset(name))
        assert "0 problem(s)" in ended(producer, "check", built.path).stdout
        assert built.balls == sum(key.startswith("x_start[") for key in wanted)
        assert {key: built.built_with(key) for key in wanted} == wanted
        told = in_set(built, name)
        assert {key: told.get(key, built.built_with(key)) for key in wanted} == wanted


def test_the_page_has_their_start_values(page, fmu):
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
