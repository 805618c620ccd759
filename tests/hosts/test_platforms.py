"""FMUs of any number of balls, and the binaries for other platforms: what they need, and that they give the same doubles.

The FMU with the binaries for Linux and Windows, 32 and 64 bits, is made by `cradle.py test` where the tools are to be had; these
tests skip, and say so, where it or what runs it is missing.
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
ZIG = [sys.executable, "-m", "ziglang", "cc", "-target"]
WINE32 = ROOT / os.environ.get("CRADLE_WINE32", "target/wine32") / "wine"  # unpacked by .ci/wine32
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
    assert "0 problem(s), 0 remark(s)" in run([producer, "check", path])
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        sizes = [
            e.compress_size
            for e in archive.infolist()
            if "linux32" not in e.filename and "win32" not in e.filename
        ]
    assert sum(sizes) < 2_000_000


@pytest.mark.parametrize(
    ("folder", "loader"), [("linux64", "ld-linux-x86-64.so.2"), ("linux32", "ld-linux.so.2")]
)
def test_linux_needs_glibc_2_17_and_nothing_else(producer, platforms, folder, loader):
    if not (SCRIPTS / "cargo-zigbuild").exists():
        pytest.skip("the binary is for this machine: cargo-zigbuild is missing in .venv")
    skip_without(platforms, folder)
    info = run([producer, "info", ROOT / "target/fmu/platforms/NewtonsCradle.fmu"])
    needed = re.search(
        rf"^{folder} .* for glibc (\d+)\.(\d+) or newer, linked with (.*)$", info, re.MULTILINE
    )
    assert (int(needed[1]), int(needed[2])) <= (2, 17)
    assert set(needed[3].split(", ")) <= {loader, "libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0"}


def skip_without(platforms, folder) -> None:
    if not (platforms / "binaries" / folder).exists():
        pytest.skip(f"there is no binary for {folder}")


@pytest.fixture(scope="module")
def outputs(platforms, tmp_path_factory):
    """Compiles a C host for a platform and runs the default experiment in it: every output at every step, bit by bit."""
    description = fmpy.read_model_description(str(platforms))
    experiment = [description.guid, description.defaultExperiment.stepSize, STEPS]
    variables = [v for v in description.modelVariables if v.causality == "output"]
    wanted = [f"{LETTERS[v.type]}:{v.valueReference}" for v in variables]

    def outputs(folder, compiler, runner, **environment) -> list[str]:
        program = tmp_path_factory.mktemp("host") / "outputs.exe"
        libraries = [] if folder.startswith("win") else ["-ldl"]
        source = ROOT / "tests/hosts/outputs.c"
        cache = {"ZIG_GLOBAL_CACHE_DIR": str(ROOT / "target/zig")}
        command = [*compiler, "-O1", "-Wall", "-Wextra", "-o", program, source, *libraries]
        run(command, env=os.environ | cache)
        resources = platforms / "resources"
        if folder.startswith("win"):
            library = f"Z:{platforms}/binaries/{folder}/NewtonsCradle.dll".replace("/", "\\")
            uri = f"file:///Z:{resources}"
            prefix = str(program.with_name("wine"))
            environment |= {"WINEARCH": folder, "WINEDEBUG": "-all", "WINEPREFIX": prefix}
        else:
            library, uri = platforms / f"binaries/{folder}/NewtonsCradle.so", resources.as_uri()
        command = [*runner, program, library, uri, *experiment, *wanted]
        return run(command, env=os.environ | environment).splitlines()

    return outputs


@pytest.fixture(scope="module")
def linux(outputs) -> list[str]:
    """The outputs that the others are compared with."""
    lines = outputs("linux64", ["cc", "-Werror"], [])
    assert len(lines) == STEPS + 1
    return lines


@pytest.mark.parametrize(
    ("folder", "compiler", "runners", "packages"),
    [
        ("linux32", [*ZIG, "x86-linux-gnu.2.17"], ["/lib/ld-linux.so.2"], "libc6-i386"),
        (
            "win64",
            ["x86_64-w64-mingw32-gcc"],
            ["wine64", "/usr/lib/wine/wine64"],
            "gcc-mingw-w64-x86-64-win32 wine64",
        ),
        (
            "win32",
            ["i686-w64-mingw32-gcc"],
            [WINE32, "/usr/lib/wine/wine"],
            "gcc-mingw-w64-i686-win32 wine32:i386",
        ),
    ],
)
def test_every_platform_gives_the_same_doubles(
    platforms, outputs, linux, folder, compiler, runners, packages
):
    skip_without(platforms, folder)
    runner = next(filter(shutil.which, runners), None)
    if not shutil.which(compiler[0]) or runner is None:
        pytest.skip(f"what runs {folder} is missing: on Debian, `apt install {packages}`")
    assert outputs(folder, compiler, [runner]) == linux


def test_an_old_glibc_gives_the_same_doubles(platforms, outputs, linux):
    """glibc 2.31 loads the binary, which is tested on whatever this machine has else."""
    if "CRADLE_OLD_GLIBC" not in os.environ:
        pytest.skip("CRADLE_OLD_GLIBC is not set to a folder that .ci/old-glibc has made")
    library = ROOT / os.environ["CRADLE_OLD_GLIBC"] / "lib/x86_64-linux-gnu"
    runner = [library / "ld-linux-x86-64.so.2", "--library-path", library]
    assert outputs("linux64", [*ZIG, "x86_64-linux-gnu.2.17"], runner) == linux
