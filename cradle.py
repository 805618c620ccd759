#!/usr/bin/env python3
"""Newton's cradle as an FMU: run the paper's experiments, or run the tests.

    python3 cradle.py paper         build the FMU, run the experiments through FMPy, write report and pictures to out/paper
    python3 cradle.py test          run what a change needs, in minutes
    python3 cradle.py test --all    run everything that checks this project

Both need cargo, a C compiler and Python 3.11 or newer. What else is needed goes into this folder: Python
packages into .venv, compiled code into target. Delete either at any time; it is made again.
"""

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
import zipfile
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
FMU = ROOT / "target/fmu/NewtonsCradle.fmu"
FMU13 = FMU.with_stem("NewtonsCradle13")  # of 13 balls, for the paper's Figure 3
# As the tests compile it, with the engine. Cargo would compile it without when asked for it alone, and for the next tests anew.
PRODUCER = ROOT / "target/debug" / ("cradle-fmu.exe" if os.name == "nt" else "cradle-fmu")
TOOLS = ROOT / "target/tools"
# Packages for the paper and the short test, and all.
SOME, ALL = (ROOT / name for name in ("requirements.txt", "requirements-all.txt"))
FUZZ_RUNS = {"calls": 8_000, "check": 1_500, "corners": 500, "states": 20_000}  # about half a minute each


# What `test` does without `--all`: cases of each property; Rust tests that it leaves out, which try every bit of saved states;
# and the tests in tests/hosts that take FMPy only, and few seconds.
FEW_CASES = 20
LONG_RUST_TESTS = ("damaged_bytes", "forged_states")
SHORT_HOST_TESTS = (
    "conservation",
    "derivatives",
    "description",
    "helpers",
    "reference",
    "rigid",
    "runs",
    "sequence",
    "states",
)


class Stop(Exception):
    """Something is missing that this script cannot supply; the message says what to do."""


def say(text: str) -> None:
    """Prints at once, also into a pipe."""
    print(text, flush=True)


def run(command: list, check: bool = True, watch=None, **options) -> int:
    """Runs a command in the checkout, its output passed on line by line and to `watch(line)`."""
    say("  $ " + " ".join(str(part).removeprefix(f"{ROOT}{os.sep}") for part in command))
    environment = os.environ | {"PYTHONUNBUFFERED": "1"} | options.pop("env", {})
    options = {"cwd": ROOT, "env": environment} | options
    if watch is None:
        code = subprocess.run([str(part) for part in command], **options).returncode
    else:
        with subprocess.Popen(
            [str(part) for part in command],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            **options,
        ) as process:
            for line in process.stdout:
                sys.stdout.write(line)
                sys.stdout.flush()
                watch(line)
        code = process.returncode
    if check and code != 0:
        raise Stop(f"`{Path(str(command[0])).name}` ended with code {code}; its messages are above.")
    return code


@contextmanager
def stage(title: str):
    """Announces a stage and says at its end how long it took."""
    begin = time.perf_counter()
    outcome = "stopped"
    say(f"\n== {title}")
    try:
        yield
        outcome = "done"
    finally:
        say(f"== {title}: {outcome} after {time.perf_counter() - begin:.1f} s")


# ---------------------------------------------------------------- what both commands need


def check_machine() -> None:
    """Stops with advice when cargo, a C compiler or the Python version is missing."""
    if sys.version_info < (3, 11):  # noqa: UP036 - the script is the first thing an old Python meets
        raise Stop(f"Python 3.11 or newer is needed, this is {sys.version.split()[0]}.")
    if shutil.which("cargo") is None:
        raise Stop("cargo is missing: install Rust from https://rustup.rs and open a new shell.")
    if not any(shutil.which(name) for name in ("cc", "gcc", "clang", "cl")):
        raise Stop(
            "a C compiler is missing (the linker of Rust programs): on Debian, `apt install gcc libc6-dev`."
        )


def make_venv(requirements: Path) -> None:
    """.venv with the packages of SOME or ALL; nothing to do when they have not changed."""
    # The checkout's path counts as well: a virtual environment does not survive being moved.
    wanted = {
        file: hashlib.sha256(file.read_bytes() + SOME.read_bytes() + str(ROOT).encode()).hexdigest()
        for file in (SOME, ALL)
    }
    stamps = {file: VENV / f"{file.stem}.sha256" for file in wanted}
    present = [file for file, stamp in stamps.items() if stamp.exists() and stamp.read_text() == wanted[file]]
    if PYTHON.exists() and requirements in present:
        say("  .venv is up to date")
        return
    if not (PYTHON.exists() and SOME in present):
        shutil.rmtree(VENV, ignore_errors=True)
        if run([sys.executable, "-m", "venv", VENV], check=False) != 0:
            raise Stop("this Python cannot make virtual environments: on Debian, `apt install python3-venv`.")
    quietly = ["--disable-pip-version-check", "--progress-bar", "off"]
    run([PYTHON, "-m", "pip", "install", *quietly, "-r", requirements])
    packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(VENV)}))
    (packages / "newtons_cradle.pth").write_text(f"{ROOT / 'python'}\n")
    for file in {SOME, requirements}:
        stamps[file].write_text(wanted[file])


def build_fmu(*producer) -> None:
    """The FMUs of five and 13 balls in target/fmu, by the program of the packaging member of the workspace."""
    options, environment = old_linux()
    for balls, path in ((5, FMU), (13, FMU13)):
        command = [*producer, "build", "--release", *options, "--balls", str(balls), "--out", path]
        run(command, env=environment)
        if not path.exists():
            raise Stop(f"`{' '.join(map(str, producer))} build` did not leave {path.relative_to(ROOT)}.")


def old_linux() -> tuple[list, dict]:
    """Options and environment for a binary that runs on every Linux from glibc 2.17 on, if .venv has cargo-zigbuild, which
    `test --all` puts there."""
    programs = VENV / "bin"
    if not (programs / "cargo-zigbuild").exists() or host_target() != "x86_64-unknown-linux-gnu":
        say(
            "  !! the binary will need a glibc like this machine's: cargo-zigbuild is not in .venv, or not for this machine"
        )
        return [], {}
    caches = {name: str(ROOT / "target/zig") for name in ("ZIG_GLOBAL_CACHE_DIR", "CARGO_ZIGBUILD_CACHE_DIR")}
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    return ["--target", "x86_64-unknown-linux-gnu.2.17"], caches | {"PATH": path}


def host_target() -> str:
    """The target triple that rustc compiles for."""
    version = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    return re.search(r"^host: (.+)$", version, re.MULTILINE)[1]


# ---------------------------------------------------------------- paper


def paper(_options) -> int:
    """Builds the FMU and runs the paper's experiments through FMPy."""
    with stage("1/3 Python packages"):
        make_venv(SOME)
    with stage("2/3 FMU (the first time, compiling takes a minute)"):
        build_fmu("cargo", "pack")
    with stage("3/3 the paper's experiments"):
        return run([PYTHON, "examples/paper/run_all.py"], check=False)


# ---------------------------------------------------------------- test


@dataclass
class Totals:
    """Counts over all stages, and the remarks to repeat at the end."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    remarks: list = field(default_factory=list)

    def skip(self, what: str, why: str) -> None:
        self.skipped += 1
        self.remarks.append(f"SKIPPED  {what}: {why}")
        say(f"\n!! SKIPPED {what}: {why}")

    def fail(self, what: str) -> None:
        self.failed += 1
        self.remarks.append(f"FAILED   {what}")
        say(f"\n!! FAILED {what}")

    def step(self, what: str, command: list, counts=None, **options) -> None:
        """Runs one stage. `counts(line)` gives (passed, failed, skipped) of a runner's summary line;
        a stage without any counts as one test, and a crash that no summary shows as one failure."""
        total = [0, 0, 0]

        def watch(line):
            for i, number in enumerate((counts and counts(line)) or ()):
                total[i] += number

        with stage(what):
            code = run(command, check=False, watch=watch, **options)
        if counts is None and code == 0:
            total[0] += 1
        self.passed, self.skipped = self.passed + total[0], self.skipped + total[2]
        if code != 0 and total[1] == 0:
            self.fail(f"{what} (code {code})")
        elif total[1]:
            self.failed += total[1]
            self.remarks.append(f"FAILED   {what}: {total[1]} tests")
        if total[2]:
            self.remarks.append(f"SKIPPED  {what}: {total[2]} tests, see above")


def cargo_counts(line: str):
    """(passed, failed, skipped) of `test result: ok. 3 passed; 0 failed; 1 ignored; ...`."""
    match = re.search(r"test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", line)
    return match and tuple(map(int, match.groups()))


def pytest_counts(line: str):
    """(passed, failed, skipped) of `=== 34 passed, 1 skipped in 5.01s ===`."""
    if not re.search(r"\d+ (passed|failed|skipped|errors?)\b.* in [\d.]+s", line):
        return None
    numbers = {what: int(n) for n, what in re.findall(r"(\d+) (passed|failed|skipped|error)", line)}
    failed = numbers.get("failed", 0) + numbers.get("error", 0)
    return numbers.get("passed", 0), failed, numbers.get("skipped", 0)


def skipped_platforms(line: str):
    """(passed, failed, skipped) of a line of packaging/platforms.py."""
    return (0, 0, 1) if line.startswith("SKIPPED") else None


def test(options) -> int:
    """What a change needs, or everything that checks the project, then one line of totals."""
    begin = time.perf_counter()
    tally = Totals()
    with stage("Python packages"):
        make_venv(ALL if options.all else SOME)
    rust_style(tally)
    python_style(tally)
    (everything if options.all else what_a_change_needs)(tally, options.pytest)
    say(f"\n== {'all tests' if options.all else 'tests'}: {time.perf_counter() - begin:.0f} s")
    for remark in tally.remarks:
        say(f"!! {remark}")
    say(f"{tally.passed} passed, {tally.failed} failed, {tally.skipped} skipped")
    if not options.all:
        say(
            "The rest (more random cases, other hosts and platforms, fuzzing, ...): python3 cradle.py test --all"
        )
    return 1 if tally.failed else 0


def what_a_change_needs(tally: Totals, pytest: list) -> None:
    """The Rust tests but for the longest, and FMPy with the FMU as they have compiled it."""
    fmu = FMU.parent / "tested" / FMU.name
    skipped = [option for name in LONG_RUST_TESTS for option in ("--skip", name)]
    tests = ["cargo", "test", "--workspace", "--no-fail-fast", "--", *skipped]
    tally.step("Rust tests", tests, cargo_counts, env={"PROPTEST_CASES": str(FEW_CASES)})
    if not PRODUCER.exists():
        return tally.fail("FMU: the Rust tests have not compiled what builds it")
    system, library = {
        "win32": ("win", "newtons_cradle.dll"),
        "darwin": ("darwin", "libnewtons_cradle.dylib"),
    }.get(sys.platform, ("linux", "libnewtons_cradle.so"))
    platform = f"{system}{64 if sys.maxsize > 2**32 else 32}"
    binary = f"--binary={platform}={PRODUCER.parent / 'deps' / library}"
    tally.step("FMU", [PRODUCER, "build", binary, "--out", fmu])
    hosts = [f"tests/hosts/test_{name}.py" for name in SHORT_HOST_TESTS]
    return tally.step("FMPy", [PYTHON, "-m", "pytest", *hosts, "--fmu", fmu, "-rs", *pytest], pytest_counts)


def everything(tally: Totals, pytest: list) -> None:
    """All tests of all kinds."""
    tally.step("Rust tests", ["cargo", "test", "--workspace", "--no-fail-fast"], cargo_counts)
    tally.step("Benches, each once", ["cargo", "bench", "--profile", "dev", "--", "--test"])
    try:
        with stage("FMU"):
            if not PRODUCER.exists():
                raise Stop("the Rust tests have not compiled what builds it.")
            build_fmu(PRODUCER)
    except Stop as problem:
        tally.fail(f"FMU: {problem} Without it the hosts cannot run.")
    else:
        platforms = [sys.executable, "packaging/platforms.py", PRODUCER, FMU]
        tally.step("FMU for all platforms", platforms, skipped_platforms, env=old_linux()[1])
        same_bytes(tally)
        install_fmi_sim(tally)
        hosts = [PYTHON, "-m", "pytest", "tests/hosts", "--fmu", FMU, "-rs", *pytest]
        tally.step("Python hosts", hosts, pytest_counts)
        rust_host(tally)
        leak_check(tally)
    fuzz(tally)


def rust_style(tally: Totals) -> None:
    """rustfmt and clippy, where the toolchain has them."""
    for what, tool, command in (
        ("Rust format", "cargo-fmt", ["cargo", "fmt", "--all", "--check"]),
        (
            "Format of the fuzz targets",
            "cargo-fmt",
            ["cargo", "fmt", "--manifest-path", "fuzz/Cargo.toml", "--check"],
        ),
        ("Rust lints", "cargo-clippy", ["cargo", "clippy", "--workspace", "--all-targets"]),
    ):
        if shutil.which(tool) is None:
            tally.skip(what, f"{tool} is missing: `rustup component add {tool.removeprefix('cargo-')}`")
        elif tool == "cargo-clippy":
            tally.step(what, [*command, "--", "--deny", "warnings"])
        else:
            tally.step(what, command)


def python_style(tally: Totals) -> None:
    """ruff, from the virtual environment."""
    tally.step("Python lints", [PYTHON, "-m", "ruff", "check", "."])
    tally.step("Python format", [PYTHON, "-m", "ruff", "format", "--check", "."])


def rust_host(tally: Totals) -> None:
    """The `fmi` crate as a host: a workspace of its own, because its bindings need libclang."""
    manifest = ROOT / "tests/hosts/fmi-rs/Cargo.toml"
    if not manifest.exists():
        return tally.skip("Rust host", f"{manifest.relative_to(ROOT)} is not there")
    if not has_libclang():
        return tally.skip("Rust host", "libclang is missing: on Debian, `apt install libclang-dev`")
    command = ["cargo", "test", "--manifest-path", manifest, "--target-dir", ROOT / "target/hosts"]
    return tally.step("Rust host", command, cargo_counts, env={"CRADLE_FMU": str(FMU)})


def same_bytes(tally: Totals) -> None:
    """Builds the FMU once more from a copy of the sources in another folder: the same bytes."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "another/checkout"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns("target", ".venv", "out", ".git"))
        options, environment = old_linux()
        command = [PRODUCER, "build", "--release", *options, "--out", copy / FMU.name]
        environment["CARGO_TARGET_DIR"] = str(copy / "target")
        tally.step("FMU from another folder", command, cwd=copy, env=environment)
        if (copy / FMU.name).exists() and (copy / FMU.name).read_bytes() != FMU.read_bytes():
            tally.fail("FMU from another folder: not the same bytes")


def install_fmi_sim(tally: Totals) -> None:
    """fmi-sim, a host that tests/hosts/test_hosts.py runs if it is there.

    It is compiled unoptimised, which takes half the time, and in the folder of the Rust host, which shares some crates."""
    if not has_libclang():
        return tally.skip("fmi-sim", "libclang is missing: on Debian, `apt install libclang-dev`")
    # Its part for FMI 2 alone does not compile.
    features = ["--no-default-features", "--features", "fmi2,fmi3,cs"]
    command = ["cargo", "install", "--locked", "--debug", "--root", TOOLS, *features, "fmi-sim@0.7.0"]
    environment = {"CARGO_TARGET_DIR": str(ROOT / "target/hosts"), "CARGO_PROFILE_DEV_DEBUG": "0"}
    with stage("fmi-sim"):
        installed = run(command, check=False, env=environment) == 0
    return None if installed else tally.skip("fmi-sim", "it could not be installed; the reason is above")


def has_libclang() -> bool:
    """Whether libclang's shared library is where bindgen looks for it."""
    folders = [os.environ.get("LIBCLANG_PATH", "")]
    if shutil.which("llvm-config"):
        answer = subprocess.run(["llvm-config", "--libdir"], capture_output=True, text=True)
        folders.append(answer.stdout.strip())
    folders += [str(path) for path in Path("/usr/lib").glob("llvm*/lib")]
    folders += ["/usr/lib", "/usr/lib64", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu"]
    names = ("libclang.so*", "libclang-[0-9]*.so*", "libclang.dylib", "libclang.dll")
    return any(any(Path(f).glob(name)) for f in folders if f for name in names)


def leak_check(tally: Totals) -> None:
    """2,000 cycles of instantiate, run, free in a C host: no crash, and no leak or error under valgrind."""
    if sys.platform != "linux":
        return tally.skip("C host", "it is written for Linux")
    folder = ROOT / "target/hosts/cycles"
    shutil.rmtree(folder, ignore_errors=True)
    with zipfile.ZipFile(FMU) as archive:
        archive.extractall(folder)
    description = (folder / "modelDescription.xml").read_text(encoding="utf-8")
    guid = re.search(r'guid="([^"]+)"', description)[1]
    libraries = list((folder / "binaries").glob(f"linux*/{FMU.stem}.so"))
    host = folder / "cycles"
    build = [
        "cc",
        "-O1",
        "-g",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-o",
        host,
        ROOT / "tests/hosts/cycles.c",
        "-ldl",
    ]
    cycles = [host, libraries[0], (folder / "resources").as_uri(), guid, "2000"]
    try:
        with stage("C host: compile"):
            run(build)
    except Stop as problem:
        return tally.fail(f"C host: {problem}")
    if shutil.which("valgrind") is None:
        tally.step("C host: 2,000 cycles", cycles)
        return tally.skip(
            "leak check of the C host", "valgrind is missing: on Debian, `apt install valgrind`"
        )
    checks = ["--leak-check=full", "--errors-for-leak-kinds=definite", "--error-exitcode=9"]
    return tally.step("C host: 2,000 cycles under valgrind", ["valgrind", *checks, *cycles])


# As cargo-fuzz has it: counts of branches taken and values compared tell libFuzzer what an input has reached.
COVERAGE = (
    "--cfg=fuzzing -Cdebug-assertions -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
    " -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
    " -Cllvm-args=-sanitizer-coverage-trace-compares -Cllvm-args=-sanitizer-coverage-stack-depth"
)


def fuzz(tally: Totals) -> None:
    """The C border's tests with AddressSanitizer; then each fuzz target: its seeds, and a fixed sequence of inputs from them."""
    if sys.platform != "linux":
        return tally.skip("Fuzzing", "it is tried on Linux only")
    if not any(shutil.which(name) for name in ("c++", "g++", "clang++")):
        return tally.skip("Fuzzing", "a C++ compiler is missing, for libFuzzer: on Debian, `apt install g++`")
    target = ROOT / "target/fuzz"
    # A sanitizer needs a target that is named.
    options = [
        "--manifest-path",
        "fuzz/Cargo.toml",
        "--release",
        "--target",
        host_target(),
        "--target-dir",
        target,
    ]
    for sanitizer in ("-Zsanitizer=address", ""):
        # Stable compilers know the sanitizer and its coverage, but only take their flags when told so.
        environment = {"RUSTC_BOOTSTRAP": "1", "RUSTFLAGS": f"{COVERAGE} {sanitizer}"}
        # Rust gives a constant that several crates use a symbol in each.
        environment["ASAN_OPTIONS"] = "detect_odr_violation=0"
        with stage(f"Fuzz targets {sanitizer or 'without sanitizer'}"):
            built = run(["cargo", "build", "--bins", *options], check=False, env=environment) == 0
        if built:
            break
        tally.skip("AddressSanitizer", "the fuzz targets could not be built with it; the reason is above")
    else:
        return tally.fail("Fuzzing: the targets could not be built")
    if sanitizer:
        # Forged states are the fuzzer's business.
        border = ["cargo", "test", "--test", "border", *options, "--", "--skip", "forged_states"]
        tally.step("C border with AddressSanitizer", border, cargo_counts, env=environment)
    for name, runs in FUZZ_RUNS.items():
        corpus = target / "tests" / name
        shutil.rmtree(corpus, ignore_errors=True)  # so that each run begins with the seeds
        corpus.mkdir(parents=True)
        limits = ["-seed=1", f"-runs={runs}", "-timeout=300", "-max_len=600", "-print_final_stats=1"]
        crashes = f"-artifact_prefix={corpus}/crash-"
        program = target / host_target() / "release" / name
        tally.step(
            f"Fuzzing: {name}",
            [program, *limits, crashes, corpus, ROOT / "fuzz/seeds" / name],
            env=environment,
        )
    return None


def main() -> int:
    """Parses the command line and runs the command."""
    parser = argparse.ArgumentParser(
        prog="cradle.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="{paper,test}")
    commands.add_parser("paper", help=paper.__doc__).set_defaults(function=paper)
    tests = commands.add_parser("test", help=test.__doc__)
    tests.add_argument("--all", action="store_true", help="everything that checks this project")
    tests.add_argument("pytest", nargs="*", help="more arguments for pytest, after `--`: -- -k threads")
    tests.set_defaults(function=test)
    options = parser.parse_args()
    begin = time.perf_counter()
    try:
        check_machine()
        code = options.function(options)
    except Stop as problem:
        say(f"\n{parser.prog} {options.command} stopped: {problem}")
        return 2
    if options.command == "paper":
        say(f"\nTogether {time.perf_counter() - begin:.0f} s.")
    return code


if __name__ == "__main__":
    sys.exit(main())
