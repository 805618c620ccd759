#!/usr/bin/env python3
"""Makes target/fmu/platforms/NewtonsCradle.fmu: one FMU with a binary for each platform that can be compiled for here.

    python3 packaging/platforms.py PRODUCER FMU

PRODUCER is the program cradle-fmu. FMU is an FMU for this machine, whose binary is taken over. For the others it takes the
Rust that .ci/debian-rust has put into the folder CRADLE_DEBIAN_RUST, or else the targets that rustup has. It says what it
skips, in lines that begin with SKIPPED.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "target/fmu/platforms"
BUILD = ROOT / "target/platforms"  # what is compiled: what runs while compiling serves all targets


@dataclass(frozen=True)
class Platform:
    """A platform of the standard, and what compiles for it."""

    folder: str
    targets: tuple[str, ...]  # with a version of glibc where cargo-zigbuild is to link
    along: tuple[str, ...]  # the targets if the standard library is compiled along
    linker: str
    advice: str


def by_zig(folder: str, *targets: str) -> Platform:
    """A platform that cargo-zigbuild links for."""
    return Platform(folder, targets, targets, "cargo-zigbuild", "pip install ziglang cargo-zigbuild")


def by_mingw(folder: str, processor: str) -> Platform:
    """Windows. The standard library for Windows 7 needs nothing newer, and nothing that an old wine lacks."""
    return Platform(
        folder,
        (f"{processor}-pc-windows-gnu",),
        (f"{processor}-win7-windows-gnu",),
        f"{processor}-w64-mingw32-gcc",
        f"on Debian, apt install gcc-mingw-w64-{processor.replace('_', '-')}-win32",
    )


PLATFORMS = (
    by_zig("linux32", "i686-unknown-linux-gnu.2.17"),
    by_zig("aarch64-linux", "aarch64-unknown-linux-gnu.2.17"),
    by_zig("darwin64", "x86_64-apple-darwin", "aarch64-apple-darwin"),
    by_mingw("win64", "x86_64"),
    by_mingw("win32", "i686"),
)

# What makes Cargo compile the standard library along. Its code is optimised less, which saves a third of the time: what is
# inlined or generic is compiled with the FMU's own code. No backtraces, which nobody sees in a host. Debian's Rust has
# nothing to strip binaries for macOS with: the linkers do it.
WITH_SOURCES = """
[unstable]
build-std = ["std", "panic_unwind"]
build-std-features = ["panic-unwind"]

[profile.release]
strip = "none"

[profile.release.package]
alloc.opt-level = 1
compiler_builtins.opt-level = 1
core.opt-level = 1
proc_macro.opt-level = 0
std.opt-level = 1
"""


def with_sources(usr: Path) -> dict:
    """The environment in which Cargo takes the Rust in a folder."""
    return {
        "CARGO": str(usr / "bin/cargo"),
        "RUSTC": str(usr / "bin/rustc"),
        "LD_LIBRARY_PATH": str(usr / "lib/x86_64-linux-gnu"),
        "RUSTC_BOOTSTRAP": "1",
        "RUSTFLAGS": "-Clink-arg=-s",
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


def possible(toolchain: Path | None) -> list[tuple[Platform, tuple[str, ...]]]:
    """The platforms that can be compiled for, each with its targets."""
    older = toolchain and too_old(with_sources(toolchain))
    sysroot = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True)
    rustup = Path(sysroot.stdout.strip()) / "lib/rustlib"
    found = []
    for platform in PLATFORMS:
        missing = [
            name for target in platform.targets if not (rustup / (name := target.split(".")[0])).exists()
        ]
        if shutil.which(platform.linker) is None:
            skip(platform, f"{platform.linker} is missing: {platform.advice}")
        elif older:
            skip(
                platform,
                f"{older}; `apt-get update`, delete {toolchain}, and .ci/debian-rust unpacks a newer one",
            )
        elif toolchain:
            found.append((platform, platform.along))
        elif missing:
            skip(
                platform,
                f"there is no Rust for it: rustup target add {' '.join(missing)}, or .ci/debian-rust",
            )
        else:
            found.append((platform, platform.targets))
    return found


def main() -> int:
    """Compiles for all platforms together, and packs what comes out with the binary for this machine."""
    folder = os.environ.get("CRADLE_DEBIAN_RUST")
    toolchain = Path(folder).resolve() / "usr" if folder else None
    platforms = possible(toolchain)
    shutil.rmtree(FOLDER, ignore_errors=True)
    with zipfile.ZipFile(sys.argv[2]) as archive:
        ready = [name for name in archive.namelist() if name.startswith("binaries/")]
        archive.extractall(FOLDER, ready)
    command = [Path(sys.argv[1]).resolve(), "build", "--release", "--out", FOLDER / "NewtonsCradle.fmu"]
    command += [f"--binary={name.split('/')[1]}={FOLDER / name}" for name in ready]
    settings = WITH_SOURCES if toolchain else ""
    for platform, targets in platforms:
        command += [f"--target={target}" for target in targets]
        if "mingw" in platform.linker:
            settings += f'[target.{targets[0]}]\nlinker = "{platform.linker}"\n'
    # Cargo reads its settings from the folder it runs in, and from those above.
    (BUILD / ".cargo").mkdir(parents=True, exist_ok=True)
    (BUILD / ".cargo/config.toml").write_text(settings)
    environment = {
        "CARGO_TARGET_DIR": str(BUILD),
        "CARGO_TERM_QUIET": "true",
        "MACOSX_DEPLOYMENT_TARGET": "11.0",
    }
    environment |= with_sources(toolchain) if toolchain else {}
    return subprocess.run([str(part) for part in command], cwd=BUILD, env=os.environ | environment).returncode


if __name__ == "__main__":
    sys.exit(main())
