"""FMUs of any number of balls, and the binaries for other platforms: what they need, and that they give the same doubles.

The FMU with the binaries for old Linux systems and for Windows is made by `cradle.py test` where the tools are to be had; these
tests skip, and say so, where it is missing.
"""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT
from fmpy.validation import validate_fmu

STEPS = 1000
SCRIPTS = Path(sys.executable).parent  # the virtual environment's programs
LETTERS = {"Real": "r", "Integer": "i", "Boolean": "b"}


def run(command, **options) -> str:
    """Runs a program; what it printed."""
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, timeout=300, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def packed(producer, fmu_path, tmp_path_factory):
    """Packs an FMU of n balls with the binaries of the FMU under test."""
    folder = tmp_path_factory.mktemp("packed")
    with zipfile.ZipFile(fmu_path) as archive:
        binaries = [name for name in archive.namelist() if name.startswith("binaries/")]
        archive.extractall(folder, binaries)
    given = [f"--binary={name.split('/')[1]}={folder / name}" for name in binaries]

    def pack(*arguments) -> Path:
        out = folder / f"{len(list(folder.iterdir()))}.fmu"
        run([producer, "build", *given, "--out", out, *arguments])
        return out

    return pack


@pytest.mark.parametrize("balls", [1, 2, 5, 13, 100, 1000])
def test_any_number_of_balls(producer, packed, balls):
    """One binary, valid for FMPy and for our own check; the first ball strikes and the FMU runs for a second."""
    line = ["--set", "gravity=0", "--set", "v_start[1]=1", "--set", f"x_start={','.join(['0'] * balls)}"]
    path = packed("--balls", balls, *line)
    assert "0 problem(s)" in run([producer, "check", path])
    assert validate_fmu(str(path)) == []
    result = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.1, output=["p_total", "E_total"])
    assert np.allclose(result["p_total"], 1.0, rtol=1e-12)
    assert np.allclose(result["E_total"], 0.5, rtol=1e-12)


def test_presets_are_the_setups_of_the_package(packed):
    """An FMU packed for a figure does what the default one does with the figure's start values."""
    for preset, setup in (("figure5", nc.figure5()), ("figure6", nc.figure6())):
        with nc.Fmu(packed("--preset", preset)) as fmu:
            described = {
                variable.name: float(variable.start)
                for variable in fmu.description.modelVariables
                if variable.start
            }
        assert {name: described[name] for name in setup} == setup


def test_start_values_count_whether_or_not_the_host_writes_them(fmu_path, packed):
    """The same run from values in the FMU, from the host, and from both."""
    values = {"contact.stiffness": 1e9, "x_start[1]": -0.2, "ball.massRatio[3]": 2.0}
    own = packed(*[part for name, value in values.items() for part in ("--set", f"{name}={value}")])
    runs = [
        fmpy.simulate_fmu(str(path), stop_time=2.0, output_interval=0.01, start_values=start)
        for path, start in ((own, {}), (own, values), (fmu_path, values))
    ]
    assert runs[0].tobytes() == runs[1].tobytes() == runs[2].tobytes()


# ---------------------------------------------------------------- other platforms


@pytest.fixture(scope="module")
def platforms(tmp_path_factory) -> Path:
    """The FMU for all platforms, unpacked."""
    path = ROOT / "target/fmu/platforms/NewtonsCradle.fmu"
    if not path.exists():
        pytest.skip(
            f"{path} is missing: cradle.py test makes it where zig or a toolchain for Windows is to be had"
        )
    folder = tmp_path_factory.mktemp("platforms")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    return folder


def test_the_fmu_for_all_platforms_is_small_and_sound(producer, platforms):
    path = ROOT / "target/fmu/platforms/NewtonsCradle.fmu"
    assert path.stat().st_size < 2_000_000
    assert "0 problem(s), 0 remark(s)" in run([producer, "check", path])
    assert validate_fmu(str(path)) == []


def test_linux_needs_glibc_2_17_and_nothing_else(producer, platforms):
    if not (SCRIPTS / "cargo-zigbuild").exists():
        pytest.skip("the binary is for this machine: cargo-zigbuild is missing in .venv")
    info = run([producer, "info", ROOT / "target/fmu/platforms/NewtonsCradle.fmu"])
    needed = re.search(r"^linux64 .* for glibc (\d+)\.(\d+) or newer, linked with (.*)$", info, re.MULTILINE)
    assert (int(needed[1]), int(needed[2])) <= (2, 17)
    of_glibc = {"ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0"}
    assert set(needed[3].split(", ")) <= of_glibc


@pytest.fixture(scope="module")
def outputs(platforms):
    """Runs the default experiment of the FMU for all platforms in a C host."""
    description = fmpy.read_model_description(str(platforms))
    variables = [v for v in description.modelVariables if v.causality == "output"]
    wanted = [f"{LETTERS[v.type]}:{v.valueReference}" for v in variables]

    def outputs(host, library, resources, **options) -> str:
        experiment = [description.guid, description.defaultExperiment.stepSize, STEPS]
        return run([*host, library, resources, *experiment, *wanted], **options)

    return outputs


def test_windows_gives_the_numbers_of_linux(platforms, outputs, tmp_path):
    """The same C host, the same experiment, every double the same bit for bit."""
    compiler = shutil.which("x86_64-w64-mingw32-gcc")
    wine = shutil.which("wine64") or next((p for p in ["/usr/lib/wine/wine64"] if Path(p).exists()), None)
    if not (platforms / "binaries/win64").exists():
        pytest.skip("there is no binary for win64")
    if not compiler or not wine:
        pytest.skip("mingw or wine is missing: on Debian, `apt install gcc-mingw-w64-x86-64-win32 wine64`")
    source = ROOT / "tests/hosts/outputs.c"
    run(["cc", "-O1", "-Wall", "-Wextra", "-Werror", "-o", tmp_path / "outputs", source, "-ldl"])
    run([compiler, "-O1", "-o", tmp_path / "outputs.exe", source])
    resources = platforms / "resources"
    linux = outputs(
        [tmp_path / "outputs"], platforms / "binaries/linux64/NewtonsCradle.so", resources.as_uri()
    )
    environment = os.environ | {
        "WINEARCH": "win64",
        "WINEDEBUG": "-all",
        "WINEPREFIX": str(tmp_path / "wine"),
    }
    windows = outputs(
        [wine, tmp_path / "outputs.exe"],
        f"Z:{platforms}/binaries/win64/NewtonsCradle.dll".replace("/", "\\"),
        f"file:///Z:{resources}",
        env=environment,
    )
    assert len(linux.splitlines()) == STEPS + 1
    assert windows.splitlines() == linux.splitlines()
