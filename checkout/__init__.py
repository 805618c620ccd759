"""Commands that work on a checkout: cradle.py's, releases, binaries for other platforms. Shared here: paths, the
virtual environment, building the FMU, running programs."""

import hashlib
import os
import shutil
import subprocess
import sys
import sysconfig
import threading
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
# Compiled together with the tests: cargo would compile it alone without the feature `engine`, and for the next tests
# again.
PRODUCER = ROOT / "target/debug" / ("cradle-fmu.exe" if os.name == "nt" else "cradle-fmu")
FMU = ROOT / "target/fmu/NewtonsCradle.fmu"
LIVE = ROOT / "target/web/cradle.html"
ENGINE = LIVE.with_name("engine.html")  # the engine for browsers, as a part of the page
# Packages for the paper, for the short test, for the site, and for everything; each file includes the one before it.
STAGES = ("paper", "test", "docs", "all")
REQUIREMENTS = SOME, TESTS, DOCS, ALL = [ROOT / f"checkout/requirements/{name}.txt" for name in STAGES]
# Linkers, installed with ALL. They have hashes, and pip wants hashes for all packages of a call or for none.
LINKERS = SOME.with_name("linkers.txt")
LANE = threading.local()  # `name`: the lane that this thread runs, printed in front of its lines


class Stop(Exception):
    """Something is missing; the message says what to do."""


def say(text: str) -> None:
    """Prints lines, each after the name of the thread's lane, if it has one: flushed even into a pipe, and in one
    write, because several threads may print."""
    lane = getattr(LANE, "name", "")
    lines = [f"{lane:9}| {line}" if lane else line for line in text.split("\n")]
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


def run(command: list, check: bool = True, lines: list | None = None, **options) -> int:
    """Runs a command in the checkout. With `lines`, each line of its output is appended to them and printed.

    Raises `Stop` if the command fails and `check` is true."""
    command = [str(part) for part in command]
    say("  $ " + " ".join(part.removeprefix(f"{ROOT}{os.sep}") for part in command))
    # Keeps compiled modules, whatever the environment says: hundreds of programs import the same.
    python = {"PYTHONUNBUFFERED": "1", "PYTHONDONTWRITEBYTECODE": ""}
    environment = os.environ | python | options.pop("env", {})
    options = {"cwd": ROOT, "env": environment} | options
    if lines is None:
        code = subprocess.run(command, **options).returncode
    else:
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True, "errors": "replace"}
        with subprocess.Popen(command, **pipes, **options) as process:
            for line in process.stdout:
                lines.append(line.rstrip("\n"))
                say(lines[-1])
        code = process.returncode
    if check and code != 0:
        raise Stop(f"`{Path(command[0]).name}` ended with code {code}; its messages are above.")
    return code


@contextmanager
def stage(title: str):
    """Announces a stage and, at its end, says how long it took."""
    begin = time.perf_counter()
    outcome = "stopped"
    say(f"\n== {title}")
    try:
        yield
        outcome = "done"
    finally:
        say(f"== {title}: {outcome} after {time.perf_counter() - begin:.1f} s")


def check_machine() -> None:
    """Stops with advice when cargo or a C compiler is missing."""
    if shutil.which("cargo") is None:
        raise Stop("cargo is missing: install Rust from https://rustup.rs and open a new shell.")
    if not any(shutil.which(name) for name in ("cc", "gcc", "clang", "cl")):
        raise Stop("a C compiler is missing; Rust needs it to link programs: on Debian, `apt install gcc libc6-dev`.")


def make_venv(requirements: Path) -> None:
    """Makes .venv with the packages of one of REQUIREMENTS, or adds them, unless it has them. A .venv that is made anew
    has at least the packages of the old one."""
    # Its path counts as well: a virtual environment does not survive being moved.
    files = b"".join(file.read_bytes() for file in (*REQUIREMENTS, LINKERS))
    digest = hashlib.sha256(str(VENV.resolve()).encode() + files).hexdigest()
    stamp = VENV / "requirements.sha256"
    present, _, name = (stamp.read_text() if PYTHON.exists() and stamp.exists() else "").partition(" ")
    wanted = max([requirements, *(file for file in REQUIREMENTS if file.name == name)], key=REQUIREMENTS.index)
    if (present, name) == (digest, wanted.name):
        say("  .venv is up to date")
        return
    if present != digest:
        shutil.rmtree(VENV, ignore_errors=True)
        if run([sys.executable, "-m", "venv", VENV], check=False) != 0:
            raise Stop("this Python cannot make virtual environments: on Debian, `apt install python3-venv`.")
    quietly = ["--disable-pip-version-check", "--progress-bar", "off"]
    # The files list all dependencies. Modules are compiled at their first import; most are never imported.
    for file in (wanted, LINKERS) if wanted == ALL else (wanted,):
        run([PYTHON, "-m", "pip", "install", *quietly, "--no-deps", "--no-compile", "-r", file])
    packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(VENV)}))
    (packages / "newtons_cradle.pth").write_text(f"{ROOT / 'python'}\n")
    stamp.write_text(f"{digest} {wanted.name}")


def fmu_build(*producer) -> tuple[list, dict]:
    """The command that builds the FMU in target/fmu with cradle-fmu, and its environment."""
    options, environment = old_linux()
    FMU.parent.mkdir(parents=True, exist_ok=True)
    return [*producer, "build", "--release", *options, "--out", FMU], environment


def old_linux() -> tuple[list, dict]:
    """Options and environment for a binary that runs on every Linux from glibc 2.17 on. This needs cargo-zigbuild,
    which `test --all` puts into .venv."""
    programs, host = VENV / "bin", rustc("host-tuple")
    if not (programs / "cargo-zigbuild").exists() or not host.endswith("-unknown-linux-gnu"):
        say(
            "  !! the binary will need this machine's glibc or a newer one: cargo-zigbuild is not in .venv, or "
            "not for this machine"
        )
        return [], {}
    caches = {name: str(ROOT / "target/zig") for name in ("ZIG_GLOBAL_CACHE_DIR", "CARGO_ZIGBUILD_CACHE_DIR")}
    return ["--target", f"{host}.2.17"], caches | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}


def rustc(what: str) -> str:
    """What `rustc --print` prints: the `sysroot`, or the `host-tuple` for which it compiles."""
    return subprocess.run(["rustc", "--print", what], capture_output=True, text=True, check=True).stdout.strip()
