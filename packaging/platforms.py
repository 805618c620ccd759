#!/usr/bin/env python3
"""Makes target/fmu/platforms/NewtonsCradle.fmu: one FMU with a binary for each platform that can be compiled for here.

    python3 packaging/platforms.py PRODUCER FMU

PRODUCER is the program cradle-fmu. FMU is an FMU for this machine, whose binary is taken over. For the others it takes the Rust that .ci/debian-rust has put into the
folder CRADLE_DEBIAN_RUST, or else the targets that rustup has. It says what it skips, in lines that begin with SKIPPED.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "target/fmu/platforms"


@dataclass(frozen=True)
class Platform:
    """A platform of the standard, and what compiles for it."""

    folder: str
    target: str  # with a version of glibc where cargo-zigbuild is to link
    along: str  # the target if the standard library is compiled along
    linker: str
    advice: str


PLATFORMS = (
    Platform(
        "linux32",
        target="i686-unknown-linux-gnu.2.17",
        along="i686-unknown-linux-gnu.2.17",
        linker="cargo-zigbuild",
        advice="pip install ziglang cargo-zigbuild",
    ),
    # The standard library for Windows 7 needs nothing newer, and nothing that an old wine lacks.
    Platform(
        "win64",
        target="x86_64-pc-windows-gnu",
        along="x86_64-win7-windows-gnu",
        linker="x86_64-w64-mingw32-gcc",
        advice="on Debian, apt install gcc-mingw-w64-x86-64-win32",
    ),
    Platform(
        "win32",
        target="i686-pc-windows-gnu",
        along="i686-win7-windows-gnu",
        linker="i686-w64-mingw32-gcc",
        advice="on Debian, apt install gcc-mingw-w64-i686-win32",
    ),
)


def producer(*arguments, **environment) -> None:
    """Runs cradle-fmu."""
    command = [str(part) for part in (sys.argv[1], *arguments)]
    subprocess.run(command, cwd=ROOT, env=os.environ | environment, check=True)


def build(platform: Platform) -> Path | None:
    """An FMU for a platform, or nothing where something is missing."""
    if shutil.which(platform.linker) is None:
        return skip(platform, f"{platform.linker} is missing: {platform.advice}")
    toolchain = os.environ.get("CRADLE_DEBIAN_RUST")
    if toolchain:
        target, environment = platform.along, with_sources(Path(toolchain).resolve() / "usr")
        if older := too_old(environment):
            return skip(
                platform,
                f"{older}; `apt-get update`, delete {toolchain}, and .ci/debian-rust unpacks a newer one",
            )
    else:
        target, environment = platform.target, {}
        sysroot = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True)
        name = target.split(".")[0]
        if not (Path(sysroot.stdout.strip()) / "lib/rustlib" / name).exists():
            return skip(platform, f"there is no Rust for it: rustup target add {name}, or .ci/debian-rust")
    # A target folder for each, so that they need not wait for one another.
    environment |= {
        "CARGO_TARGET_DIR": str(ROOT / "target/platforms" / platform.folder),
        "CARGO_TERM_QUIET": "true",
    }
    if "windows" in target:
        environment[f"CARGO_TARGET_{target.upper().replace('-', '_')}_LINKER"] = platform.linker
    out = FOLDER / f"{platform.folder}.fmu"
    producer("build", "--release", "--target", target, "--out", out, **environment)
    return out


def with_sources(usr: Path) -> dict:
    """What makes Cargo compile the standard library along, with the Rust in a folder."""
    return {
        "CARGO": str(usr / "bin/cargo"),
        "RUSTC": str(usr / "bin/rustc"),
        "LD_LIBRARY_PATH": str(usr / "lib/x86_64-linux-gnu"),
        "RUSTC_BOOTSTRAP": "1",
        "CARGO_UNSTABLE_BUILD_STD": "std,panic_unwind",
        "CARGO_UNSTABLE_BUILD_STD_FEATURES": "panic-unwind",  # no backtraces, which nobody sees in a host
    }


def too_old(environment: dict) -> str | None:
    """What is wrong with the version of a Rust, if it is older than the sources need: apt may know of an old one only."""
    command = [environment["RUSTC"], "--version"]
    answer = subprocess.run(command, env=os.environ | environment, capture_output=True, text=True)
    version = re.match(r"rustc (\d+)\.(\d+)", answer.stdout)
    needed = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["rust-version"]
    if version and tuple(map(int, version.groups())) >= tuple(map(int, needed.split("."))):
        return None
    return f"Rust {needed} is needed, this is {answer.stdout.strip() or 'none that runs'}"


def skip(platform: Platform, reason: str) -> None:
    print(f"SKIPPED {platform.folder}: {reason}", flush=True)


def main() -> int:
    """Collects the binaries of all FMUs and packs them together."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        fmus = [Path(sys.argv[2]), *pool.map(build, PLATFORMS)]
    binaries = []
    for fmu in filter(None, fmus):
        with zipfile.ZipFile(fmu) as archive:
            names = [name for name in archive.namelist() if name.startswith("binaries/")]
            archive.extractall(FOLDER, names)
        binaries += [f"--binary={name.split('/')[1]}={FOLDER / name}" for name in names]
    producer("build", *binaries, "--out", FOLDER / "NewtonsCradle.fmu")
    return 0


if __name__ == "__main__":
    sys.exit(main())
