"""The binaries for other platforms: what they need, and that they give the same doubles and read the states of one
another.

The FMU with the binaries for Linux and Windows, 32 and 64 bits, Linux on ARM and macOS is made by `cradle.py test
--all` where the tools are to be had; these tests skip, and say so, where it or what runs it is missing or runs
nothing. What is for macOS is inspected, not run: by `cradle-fmu check`, and here its signature.
"""

import hashlib
import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from conftest import ROOT, ended

from checkout.platforms import TO_TEST
from checkout.suite import COPY

pytestmark = pytest.mark.all

PATH = ROOT / "target/fmu/platforms/NewtonsCradle.fmu"
ZIG = [sys.executable, "-m", "ziglang", "cc", "-target"]
# A C library for ARM lies where Debian's cross compilers have it.
QEMU = [[name, "-L", "/usr/aarch64-linux-gnu"] for name in ("qemu-aarch64-static", "qemu-aarch64")]
WINE32 = ROOT / os.environ.get("CRADLE_WINE32", "target/wine32") / "wine"  # unpacked by .ci/wine32


@pytest.fixture(scope="module")
def platforms(tmp_path_factory) -> Path:
    """The FMU for all platforms, unpacked."""
    if not PATH.exists():
        pytest.skip(f"{PATH} is missing: cradle.py test --all makes it where a toolchain is to be had")
    folder = tmp_path_factory.mktemp("platforms")
    with zipfile.ZipFile(PATH) as archive:
        archive.extractall(folder)
    return folder


def test_platforms_fmu_is_small_and_sound(producer, platforms):
    """A newer glibc than 2.17, and libraries that not every system has, would be remarks."""
    assert "0 problem(s), 0 remark(s)" in ended(producer, "check", PATH).stdout
    info = ended(producer, "info", PATH).stdout
    folders = {path.name for path in (platforms / "binaries").iterdir()}
    assert "linux64" in folders
    for folder in folders & {"linux32", "linux64", "aarch64-linux"}:
        assert re.search(rf"(?m)^{folder} .*, for glibc 2\.\d+ or newer, linked with .*libc\.so", info)
    with zipfile.ZipFile(PATH) as archive:
        sizes = {entry.filename: entry.compress_size for entry in archive.infolist()}

    def without(*folders):
        return sum(size for name, size in sizes.items() if not name.startswith(folders))

    # The others are unoptimised, where they are only tested.
    assert without() < 16_000_000
    assert without(*(f"binaries/{other}/" for other in ("linux32", "win64", "win32", "darwin64"))) < 2_600_000


def test_platforms_binaries_do_not_depend_on_the_folder():
    """Of each linker a binary has the same bytes from another folder; for Linux see test_documents.py."""
    copy = COPY / TO_TEST.relative_to(ROOT)
    if not copy.exists():
        pytest.skip(f"{copy} is missing: cradle.py test --all makes it where a toolchain is to be had")

    def compiled(folder):
        return [path for path in folder.glob("*/release/*newtons_cradle*") if path.suffix in (".dylib", ".dll")]

    # Of as many linkers as there are here.
    assert {path.suffix for path in compiled(copy)} == {path.suffix for path in compiled(TO_TEST)} != set()
    for path in compiled(copy):
        assert path.read_bytes() == (TO_TEST / path.relative_to(copy)).read_bytes(), path


def test_platforms_binary_for_macos_on_arm_is_signed(platforms):
    """Each page has its hash, which macOS computes when it loads the page. The numbers are those of <mach-o/fat.h>,
    <mach-o/loader.h> and cs_blobs.h."""
    path = platforms / "binaries/darwin64/NewtonsCradle.dylib"
    if not path.exists():
        pytest.skip("there is no binary for macOS")
    data = path.read_bytes()
    _, count = struct.unpack_from(">2I", data)
    places = {part[0]: part[2:4] for part in struct.iter_unpack(">5I", data[8 : 8 + 20 * count])}
    intel, arm = 0x01000007, 0x0100000C
    assert set(places) == {intel, arm}
    begin, length = places[arm]
    library, at = data[begin : begin + length], 32
    for _ in range(struct.unpack_from("<I", library, 16)[0]):
        command, length = struct.unpack_from("<2I", library, at)
        if command == 0x1D:  # LC_CODE_SIGNATURE
            begin, size = struct.unpack_from("<2I", library, at + 8)
        at += length
    blob = library[begin : begin + size]
    magic, _, count = struct.unpack_from(">3I", blob)
    kinds = dict(struct.iter_unpack(">2I", blob[12 : 12 + 8 * count]))
    directory = blob[kinds[0] :]
    of_directory, _, _, flags, hashes, _, _, pages, limit = struct.unpack_from(">9I", directory)
    size, kind, _, bits = struct.unpack_from(">4B", directory, 36)
    assert (magic, of_directory, size, kind) == (0xFADE0CC0, 0xFADE0C02, 32, 2)  # SHA-256
    assert flags & 0x2  # ad hoc
    assert limit == begin  # all but the signature itself
    assert pages == -(-limit >> bits) > 10
    for page in range(pages):
        part = library[page << bits : min((page + 1) << bits, limit)]
        assert hashlib.sha256(part).digest() == directory[hashes + 32 * page : hashes + 32 * (page + 1)], page


PRESSED = {"contact.deadBand": 0, "contact.damping": 2e4, "F_ext[1]": 3, "pendulum.lengthRatio[3]": 1.1}
# What is run, for how many steps: states of balls in flight, of balls that rest against each other, which take long
# where the binary is unoptimised, and of a solver of the whole chain.
EXPERIMENTS = {
    "default": (1000, {}),
    "pressed": (100, PRESSED),
    "adams": (1000, {"solver.method": 3, "solver.tolerance": 1e-8}),
}


@pytest.fixture(scope="module")
def host(tmp_path_factory):
    """Compiles the C host for a platform: its command and environment. Skips where it does not even say how it is
    used, as with a wine that lacks its loader, a library or a place for its settings."""
    known = {}

    def host(folder, compiler, runner) -> tuple[list, dict]:
        key = (folder, *runner)
        if key not in known:
            place = tmp_path_factory.mktemp(folder)
            environment = os.environ | {"ZIG_GLOBAL_CACHE_DIR": str(ROOT / "target/zig")}
            libraries = ["-ldl"]
            if folder.startswith("win"):
                environment |= {"WINEARCH": folder, "WINEDEBUG": "-all", "WINEPREFIX": str(place / "wine")}
                libraries = []
            program, said = place / "outputs.exe", place / "said"
            flags = ["-O1", "-Wall", "-Wextra", f"-I{Path(fmpy.__file__).with_name('c-code')}", "-o", program]
            ended(*compiler, *flags, ROOT / "tests/hosts/outputs.c", *libraries, env=environment)
            # What wine has started ends with it; what stays does not hold a file, as it would a pipe.
            alone = ["timeout", "--signal=KILL", "180", *runner, program]
            with said.open("w") as log:
                subprocess.run([str(part) for part in alone], env=environment, stdout=log, stderr=log)
            known[key] = [*runner, program], environment, said.read_text(errors="replace")
        command, environment, said = known[key]
        if "usage: outputs" not in said:
            pytest.skip(f"the C host for {folder} does not run: {said}")
        return command, environment

    return host


@pytest.fixture(scope="module", params=EXPERIMENTS)
def outputs(request, platforms, host, tmp_path_factory):
    """Runs an experiment in a C host: every output at every step, bit by bit, the second half twice, the second time
    from the state in the file `given` or the own one; and the file with the own one."""
    steps, values = EXPERIMENTS[request.param]
    description = fmpy.read_model_description(str(platforms))
    variables = {v.name: v for v in description.modelVariables}
    start = [(variables[name], value) for name, value in values.items()]
    letters = {"Real": "r", "Integer": "i", "Enumeration": "i", "Boolean": "b"}
    items = [f"{letters[v.type]}:{v.valueReference}={value}" for v, value in start]
    items += [f"{letters[v.type]}:{v.valueReference}" for v in variables.values() if v.causality == "output"]

    def outputs(folder, compiler, runner, given=None) -> tuple[list[str], Path]:
        command, environment = host(folder, compiler, runner)
        own = tmp_path_factory.mktemp("states") / "state"
        library, uri = platforms / f"binaries/{folder}/NewtonsCradle.so", (platforms / "resources").as_uri()
        step = description.defaultExperiment.stepSize
        arguments = [library, uri, description.guid, step, steps, own, given or own, *items]
        if folder.startswith("win"):
            arguments[:2] = library.with_suffix(".dll"), f"file:///Z:{platforms}/resources"
            arguments = [f"Z:{a}".replace("/", "\\") if isinstance(a, Path) else a for a in arguments]
        lines = ended(*command, *arguments, env=environment).stdout.splitlines()
        assert len(lines) == steps + 1 + steps - steps // 2
        assert lines[steps // 2 + 1 : steps + 1] == lines[steps + 1 :]
        return lines, own

    return outputs


@pytest.fixture(scope="module")
def linux(outputs) -> tuple[list[str], Path]:
    """The outputs and the state that the others are compared with."""
    return outputs("linux64", ["cc", "-Werror"], [])


RUNNERS = {  # folder: compiler, what may run it, and the packages that bring them
    "linux32": ([*ZIG, "x86-linux-gnu.2.17"], [["/lib/ld-linux.so.2"]], "libc6-i386"),
    "win64": (["x86_64-w64-mingw32-gcc"], [["wine64"], ["/usr/lib/wine/wine64"]], "gcc-mingw-w64-x86-64-win32 wine64"),
    "win32": (["i686-w64-mingw32-gcc"], [[WINE32], ["/usr/lib/wine/wine"]], "gcc-mingw-w64-i686-win32 wine32:i386"),
    "aarch64-linux": ([*ZIG, "aarch64-linux-gnu.2.17"], QEMU, "qemu-user-static libc6-arm64-cross"),
}  # fmt: skip


@pytest.mark.parametrize("folder", RUNNERS)
def test_platforms_give_the_same_doubles_and_read_each_others_states(platforms, outputs, linux, folder):
    compiler, runners, packages = RUNNERS[folder]
    if not (platforms / "binaries" / folder).exists():
        pytest.skip(f"there is no binary for {folder}")
    runner = next((command for command in runners if shutil.which(command[0])), None)
    if not shutil.which(compiler[0]) or runner is None:
        pytest.skip(f"what runs {folder} is missing: on Debian, `apt install {packages}`")
    lines, state = outputs(folder, compiler, runner, given=linux[1])
    assert lines == linux[0]
    # Hence 64-bit Linux reads the state of this platform, too.
    assert state.read_bytes() == linux[1].read_bytes()


def test_platforms_old_glibc_gives_the_same_doubles(platforms, outputs, linux):
    """glibc 2.31 loads the binary, which is tested on whatever this machine has else."""
    if "CRADLE_OLD_GLIBC" not in os.environ:
        pytest.skip("CRADLE_OLD_GLIBC is not set to a folder that .ci/old-glibc has made")
    library = ROOT / os.environ["CRADLE_OLD_GLIBC"] / "lib/x86_64-linux-gnu"
    runner = [library / "ld-linux-x86-64.so.2", "--library-path", library]
    lines, _ = outputs("linux64", [*ZIG, "x86_64-linux-gnu.2.17"], runner, given=linux[1])
    assert lines == linux[0]
