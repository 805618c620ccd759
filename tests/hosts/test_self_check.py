"""What an FMU brings along to be checked and tried by: parameter sets, reference results, and the lines of its
documentation."""

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
from conftest import SCRIPTS, ended
from fmpy.ssp.ssd import read_ssv

pytestmark = pytest.mark.all


@pytest.mark.parametrize("balls", [1, 5, 13])
def test_parameter_sets_give_the_reference_results(cradle, fmu_path, balls):
    """Each parameter set of the manifest, applied by FMPy, gives the results with the same label."""
    fmu, files = cradle(balls=balls, binaries=fmu_path), {}
    folder = Path(fmu.folder, "extra/org.fmi-standard.fmi-ls-ref")
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


def test_a_desk_cradle_comes_to_rest(cradle, fmu_path):
    """Below 1 mm after about a minute."""
    result = cradle(preset="desk", binaries=fmu_path).simulate(stop=70.0, record=["x"])
    assert 50.0 < result["time"][np.abs(result["x"]).max(axis=1) > 1e-3][-1] < 65.0


def test_the_lines_of_the_documentation_run(cradle, fmu_path, tmp_path):
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
