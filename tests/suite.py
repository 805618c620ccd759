"""The stages of `cradle.py test`, which counts what they pass, fail and skip."""

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from checkout import (
    ALL,
    FMU,
    PYTHON,
    ROOT,
    TESTS,
    fmu_builds,
    host_target,
    make_venv,
    old_linux,
    run,
    say,
    stage,
)

# As the tests compile it, with the engine. Cargo would compile it without when asked for it alone, and for the next tests anew.
PRODUCER = ROOT / "target/debug" / ("cradle-fmu.exe" if os.name == "nt" else "cradle-fmu")
TOOLS = ROOT / "target/tools"
# About half a minute each, but for `calls`, which takes a whole one.
FUZZ_RUNS = {"calls": 5_000, "check": 1_500, "corners": 1_000, "events": 10_000, "states": 20_000}

# Cases of each property in `test` without `--all`.
FEW_CASES = 20

# Parts of the lines of skips that `--strict` accepts, because installing something does not help.
EXPECTED_SKIPS = ("advisories: their database cannot be reached",)


@dataclass
class Results:
    """What stages have counted, and the remarks to repeat at the end."""

    lane: str = ""  # before each line, where stages run beside others
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    remarks: list = field(default_factory=list)
    skips: list = field(default_factory=list)  # a line for each, with its reason

    def show(self, text: str) -> None:
        """Prints lines, each after the name of its lane."""
        say("\n".join(f"{self.lane:9}| {line}" if self.lane else line for line in text.split("\n")))

    def skip(self, what: str, why: str) -> None:
        """Notes what cannot run here, and why."""
        self.skipped += 1
        self.remarks.append(f"SKIPPED  {what}: {why}")
        self.skips.append(f"{what}: {why}")
        self.show(f"\n!! SKIPPED {what}: {why}")

    def fail(self, what: str) -> None:
        """Notes a failure that no runner counts."""
        self.failed += 1
        self.remarks.append(f"FAILED   {what}")
        self.show(f"\n!! FAILED {what}")

    def step(self, what: str, command: list, counts=None, **options) -> bool:
        """Runs one stage, and says whether it passed. `counts(line)` gives (passed, failed, skipped) of a runner's summary line;
        a stage without any counts as one test, and a crash that no summary shows as one failure. Failed tests are named."""
        total = [0, 0, 0]
        failures = []

        def watch(line):
            self.show(line)
            if is_failure(line):
                failures.append(line.rstrip())
            if line.startswith("SKIPPED"):
                self.skips.append(line)
            for i, number in enumerate((counts and counts(line)) or ()):
                total[i] += number

        with stage(what, self.show):
            code = run(command, check=False, watch=watch, **options)
        if counts is None and code == 0:
            total[0] += 1
        self.passed, self.skipped = self.passed + total[0], self.skipped + total[2]
        if code != 0 and total[1] == 0:
            self.fail(f"{what} (code {code})")
        elif total[1]:
            self.failed += total[1]
            self.remarks.append(f"FAILED   {what}: {total[1]} tests")
            self.remarks += [f"         {failure}" for failure in failures]
        if total[2]:
            self.remarks.append(f"SKIPPED  {what}: {total[2]} tests, see above")
        return code == 0

    def beside(self, **lanes) -> None:
        """Runs lanes of stages beside each other, and adds what they count. Few stages keep two cores busy by themselves."""
        parts = [Results(name) for name in lanes]
        with ThreadPoolExecutor(len(parts)) as pool:
            list(pool.map(lambda stages, part: stages(part), lanes.values(), parts))
        for part in parts:
            self.passed += part.passed
            self.failed += part.failed
            self.skipped += part.skipped
            self.remarks += part.remarks
            self.skips += part.skips


def cargo_counts(line: str):
    """(passed, failed, skipped) of `test result: ok. 3 passed; 0 failed; 1 ignored; ...`."""
    match = re.search(r"test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", line)
    return match and tuple(map(int, match.groups()))


def short_counts(line: str):
    """As `cargo_counts`; what is ignored is left out on purpose."""
    counts = cargo_counts(line)
    return counts and (*counts[:2], 0)


def pytest_counts(line: str):
    """(passed, failed, skipped) of `=== 34 passed, 1 skipped in 5.01s ===`."""
    if not re.search(r"\d+ (passed|failed|skipped|errors?)\b.* in [\d.]+s", line):
        return None
    numbers = {what: int(n) for n, what in re.findall(r"(\d+) (passed|failed|skipped|error)", line)}
    failed = numbers.get("failed", 0) + numbers.get("error", 0)
    return numbers.get("passed", 0), failed, numbers.get("skipped", 0)


def is_failure(line: str) -> bool:
    """Whether a line is cargo's `test name ... FAILED`, or pytest's `FAILED file::name - reason`."""
    return re.match(r"test \S+ \.\.\. FAILED|(FAILED|ERROR) tests/", line) is not None


def skipped_lines(line: str):
    """(passed, failed, skipped) of a line of packaging/platforms.py, packaging/deny.py or web/build.py."""
    return (0, 0, 1) if line.startswith("SKIPPED") else None


def test(options) -> int:
    """Runs what a change needs, or everything that checks the project, and prints one line of totals."""
    begin = time.perf_counter()
    results = Results()
    with stage("Python packages"):
        make_venv(ALL if options.all else TESTS)
    (everything if options.all else what_a_change_needs)(results)
    for skip in unexpected_skips(results.skips) if options.strict else ():
        results.fail(f"unexpected skip: {skip}")
    say(f"\n== {'all tests' if options.all else 'tests'}: {time.perf_counter() - begin:.0f} s")
    for remark in results.remarks:
        say(f"!! {remark}")
    say(f"{results.passed} passed, {results.failed} failed, {results.skipped} skipped")
    if not options.all:
        say(
            "The rest (more random cases, other hosts and platforms, fuzzing, ...): python3 cradle.py test --all"
        )
    return 1 if results.failed else 0


def unexpected_skips(skips: list[str]) -> list[str]:
    """The skips that a machine with everything installed does not have."""
    return [skip for skip in skips if not any(expected in skip for expected in EXPECTED_SKIPS)]


def what_a_change_needs(results: Results) -> None:
    """The Rust tests but for the longest, and FMPy with the FMU as they have compiled it."""
    style(results)
    fmu = FMU.parent / "tested" / FMU.name
    tests = ["cargo", "test", "--workspace", "--no-fail-fast"]
    results.step("Rust tests", tests, short_counts, env={"PROPTEST_CASES": str(FEW_CASES)})
    if not PRODUCER.exists():
        return results.fail("FMU: the Rust tests have not compiled what builds it")
    system, library = {
        "win32": ("win", "newtons_cradle.dll"),
        "darwin": ("darwin", "libnewtons_cradle.dylib"),
    }.get(sys.platform, ("linux", "libnewtons_cradle.so"))
    platform = f"{system}{64 if sys.maxsize > 2**32 else 32}"
    binary = f"--binary={platform}={PRODUCER.parent / 'deps' / library}"
    results.step("FMU", [PRODUCER, "build", binary, "--out", fmu])
    python_hosts(results, fmu, "-m", "not all")
    return None


def everything(results: Results) -> None:
    """All tests of all kinds."""
    FMU.unlink(missing_ok=True)
    results.beside(build=compiled, fuzz=fuzz, others=apart)
    if not FMU.exists():
        return results.fail("hosts: without the FMU they cannot run")

    def python(part):
        part.step("Wheel", [sys.executable, "cradle.py", "wheel", "--fmu", FMU])
        python_hosts(part, FMU)

    def others(part):
        rust_host(part)
        leak_check(part)

    results.beside(python=python, others=others)
    return None


def compiled(results: Results) -> None:
    """What compiles the root package: lints, its tests and benches, the FMU for this and other platforms."""
    style(results)
    tests = ["cargo", "test", "--workspace", "--no-fail-fast", "--", "--include-ignored"]
    results.step("Rust tests", tests, cargo_counts)
    results.step("Benches, each once", ["cargo", "bench", "--profile", "dev", "--", "--test"])
    if not PRODUCER.exists():
        return results.fail("FMU: the Rust tests have not compiled what builds it")
    commands, environment = fmu_builds(PRODUCER)
    for command in commands:
        if not results.step("FMU", command, env=environment):
            return None
    same_bytes(results)
    platforms = [sys.executable, "packaging/platforms.py", PRODUCER, FMU]
    results.step("FMU for all platforms", platforms, skipped_lines, env=environment)
    return None


def apart(results: Results) -> None:
    """What is compiled in folders of its own: a host, the live page, and what looks at the packages of others."""
    install_fmi_sim(results)
    results.step("Live page", [sys.executable, "web/build.py", "--or-skip"], skipped_lines)
    results.step("Licences, bans and sources", [sys.executable, "packaging/deny.py"], skipped_lines)
    results.step("Bill of materials", [PYTHON, "packaging/sbom.py", ROOT / "target/newtons-cradle.cdx.json"])


def style(results: Results) -> None:
    """rustfmt and clippy, where the toolchain has them, and ruff."""
    fmt = ["cargo", "fmt", "--check"]
    clippy = ["cargo", "clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"]
    for what, tool, command in (
        ("Rust format", "cargo-fmt", [*fmt, "--all"]),
        ("Format of the fuzz targets", "cargo-fmt", [*fmt, "--manifest-path", "fuzz/Cargo.toml"]),
        ("Rust lints", "cargo-clippy", clippy),
    ):
        if shutil.which(tool):
            results.step(what, command)
        else:
            results.skip(what, f"{tool} is missing: `rustup component add {tool.removeprefix('cargo-')}`")
    results.step("Python lints", [PYTHON, "-m", "ruff", "check", "."])
    results.step("Python format", [PYTHON, "-m", "ruff", "format", "--check", "."])


def python_hosts(results: Results, fmu: Path, *options) -> None:
    """tests/hosts by pytest, on all cores."""
    parallel = ["--numprocesses", "auto", "--dist", "loadfile"]
    results.step(
        "Python hosts",
        [PYTHON, "-m", "pytest", "tests/hosts", "--fmu", fmu, *parallel, *options],
        pytest_counts,
    )


def rust_host(results: Results) -> None:
    """The crates `fmi` and `fmi-rs` as hosts: a workspace of its own, because the bindings of `fmi` need libclang."""
    manifest = ROOT / "tests/hosts/fmi-rs/Cargo.toml"
    if not manifest.exists():
        return results.skip("Rust host", f"{manifest.relative_to(ROOT)} is not there")
    if not has_libclang():
        return results.skip("Rust host", "libclang is missing: on Debian, `apt install libclang-dev`")
    if not PRODUCER.exists():
        return results.skip("Rust host", f"{PRODUCER} is not there")
    fmi3 = FMU.with_suffix(".fmi3.fmu")
    subprocess.run(
        [PRODUCER, "build", "--from", FMU, "--fmi", "3", "--out", fmi3], check=True, capture_output=True
    )
    command = ["cargo", "test", "--manifest-path", manifest, "--target-dir", ROOT / "target/hosts"]
    return results.step(
        "Rust host", command, cargo_counts, env={"CRADLE_FMU": str(FMU), "CRADLE_FMU3": str(fmi3)}
    )


def same_bytes(results: Results) -> None:
    """Builds the FMU once more from a copy of the sources in another folder: the same bytes."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "another/checkout"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns("target", ".venv", "out", ".git"))
        options, environment = old_linux()
        command = [PRODUCER, "build", "--release", *options, "--out", copy / FMU.name]
        environment["CARGO_TARGET_DIR"] = str(copy / "target")
        results.step("FMU from another folder", command, cwd=copy, env=environment)
        if (copy / FMU.name).exists() and (copy / FMU.name).read_bytes() != FMU.read_bytes():
            results.fail("FMU from another folder: not the same bytes")


def install_fmi_sim(results: Results) -> None:
    """fmi-sim, a host that tests/hosts/test_hosts.py runs if it is there.

    It is compiled unoptimised, which takes half the time, and in the folder of the Rust host, which shares some crates."""
    if not has_libclang():
        return results.skip("fmi-sim", "libclang is missing: on Debian, `apt install libclang-dev`")
    # Its part for FMI 2 alone does not compile.
    features = ["--no-default-features", "--features", "fmi2,fmi3,cs,me"]
    command = ["cargo", "install", "--locked", "--debug", "--root", TOOLS, *features, "fmi-sim@0.7.0"]
    environment = {"CARGO_TARGET_DIR": str(ROOT / "target/hosts"), "CARGO_PROFILE_DEV_DEBUG": "0"}
    with stage("fmi-sim", results.show):
        installed = run(command, check=False, watch=results.show, env=environment) == 0
    return None if installed else results.skip("fmi-sim", "it could not be installed; the reason is above")


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


def leak_check(results: Results) -> None:
    """2,000 cycles of instantiate, run, free in a C host for each version: no crash, and no leak or error under valgrind."""
    if sys.platform != "linux":
        return results.skip("C host", "it is written for Linux")
    if shutil.which("valgrind") is None:
        results.skip("leak check of the C hosts", "valgrind is missing: on Debian, `apt install valgrind`")
    folder = ROOT / "target/hosts/cycles"
    shutil.rmtree(folder, ignore_errors=True)
    description = unpacked(FMU, folder)
    guid = re.search(r'guid="([^"]+)"', description)[1]
    library = next((folder / "binaries").glob(f"linux*/{FMU.stem}.so"))
    cycles = [library, (folder / "resources").as_uri(), guid, "2000"]
    kinds = {"co-simulation": cycles, "model exchange": [*cycles, "0"]}
    check_cycles(results, "cycles", folder, kinds)

    fmi3 = folder / f"{FMU.stem}.fmi3.fmu"
    build = [PRODUCER, "build", "--from", FMU, "--fmi", "3", "--out", fmi3]
    if not results.step("FMU of FMI 3.0", build):
        return None
    description = unpacked(fmi3, folder / "fmi3")
    token = re.search(r'instantiationToken="([^"]+)"', description)[1]
    names = ("n", "x", "onset.clock", "onset.closed")
    places = [
        re.search(rf'name="{re.escape(name)}" valueReference="(\d+)"', description)[1] for name in names
    ]
    library = next((folder / "fmi3/binaries").glob(f"{platform.machine()}-linux/{FMU.stem}.so"))
    cycles = [library, f"{folder / 'fmi3/resources'}/", token, *places, "2000"]
    return check_cycles(results, "cycles3", folder, {"FMI 3.0 with events": cycles})


def unpacked(fmu: Path, folder: Path) -> str:
    """Unpacks an FMU; its description."""
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    return (folder / "modelDescription.xml").read_text(encoding="utf-8")


def check_cycles(results: Results, name: str, folder: Path, kinds: dict[str, list]) -> None:
    """Compiles a C host and runs it with these arguments for each kind, under valgrind if there is one."""
    host = folder / name
    flags = ["-O1", "-g", "-Wall", "-Wextra", "-Werror"]
    if not results.step(
        f"C host {name}: compile", ["cc", *flags, "-o", host, ROOT / f"tests/hosts/{name}.c", "-ldl"]
    ):
        return
    checks = ["valgrind", "--leak-check=full", "--errors-for-leak-kinds=definite", "--error-exitcode=9"]
    checks = checks if shutil.which("valgrind") else []
    for kind, arguments in kinds.items():
        under = " under valgrind" if checks else ""
        results.step(f"C host: 2,000 cycles of {kind}{under}", [*checks, host, *arguments])


# As cargo-fuzz has it: counts of branches taken and values compared tell libFuzzer what an input has reached.
COVERAGE = (
    "--cfg=fuzzing -Cdebug-assertions -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
    " -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
    " -Cllvm-args=-sanitizer-coverage-trace-compares -Cllvm-args=-sanitizer-coverage-stack-depth"
)


def fuzz(results: Results) -> None:
    """The C interface's tests with AddressSanitizer; then each fuzz target: its seeds, and a fixed sequence of inputs from them."""
    if sys.platform != "linux":
        return results.skip("Fuzzing", "it is tried on Linux only")
    if not any(shutil.which(name) for name in ("c++", "g++", "clang++")):
        return results.skip(
            "Fuzzing", "a C++ compiler is missing, for libFuzzer: on Debian, `apt install g++`"
        )
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
        with stage(f"Fuzz targets {sanitizer or 'without sanitizer'}", results.show):
            build = ["cargo", "build", "--bins", *options]
            built = run(build, check=False, watch=results.show, env=environment) == 0
        if built:
            break
        results.skip("AddressSanitizer", "the fuzz targets could not be built with it; the reason is above")
    else:
        return results.fail("Fuzzing: the targets could not be built")
    if sanitizer:
        # Forged states are the fuzzer's business.
        ffi = [
            "cargo",
            "test",
            "--test",
            "ffi",
            *options,
            "--",
            "--include-ignored",
            "--skip",
            "forged_states",
        ]
        results.step("C interface with AddressSanitizer", ffi, cargo_counts, env=environment)
    for name, runs in FUZZ_RUNS.items():
        corpus = target / "tests" / name
        shutil.rmtree(corpus, ignore_errors=True)  # so that each run begins with the seeds
        corpus.mkdir(parents=True)
        limits = ["-seed=1", f"-runs={runs}", "-timeout=300", "-max_len=600", "-print_final_stats=1"]
        crashes = f"-artifact_prefix={corpus}/crash-"
        program = target / host_target() / "release" / name
        results.step(
            f"Fuzzing: {name}",
            [program, *limits, crashes, corpus, ROOT / "fuzz/seeds" / name],
            env=environment,
        )
    return None
