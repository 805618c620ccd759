"""Makes target/fmu/platforms/NewtonsCradle.fmu: one FMU with a binary for each platform that this machine
can compile for.

    python3 -m checkout.platforms [--to-test] [PLATFORM...]

It needs `cargo build --package cradle-packaging`, and reuses the binary of target/fmu/NewtonsCradle.fmu, which is for
this machine. For the other platforms it takes the Rust that .ci/debian-rust has put into the folder CRADLE_DEBIAN_RUST,
or else the targets that rustup has. Lines that begin with SKIPPED say what it skips. With --to-test, only the binary
for Linux on ARM is optimised, at level 1, because it runs in an emulator: the others compile in a third of the time.
Given platforms, such as win64, it compiles for these only.
"""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

from checkout import FMU, PRODUCER, ROOT, rustc

FOLDER = ROOT / "target/fmu/platforms"
TO_TEST = ROOT / "target/platforms-to-test"  # Cargo's target folder

# Linked by Rust's lld, because zig's own linker exports every function; zig provides the names of the system's
# functions.
MACOS = ("x86_64-apple-darwin", "aarch64-apple-darwin")
# The targets for each folder of the standard, with a version of glibc where cargo-zigbuild is to link.
PLATFORMS = {
    "linux32": ("i686-unknown-linux-gnu.2.17",),
    "aarch64-linux": ("aarch64-unknown-linux-gnu.2.17",),
    "darwin64": MACOS,
    "win64": ("x86_64-pc-windows-gnu",),
    "win32": ("i686-pc-windows-gnu",),
}

# Makes Cargo compile the standard library, too, with less optimisation, which saves a third of the time: inlined and
# generic code is compiled with the FMU's own. No backtraces: no host shows them.
WITH_SOURCES = """
[unstable]
build-std = ["std", "panic_unwind"]
build-std-features = ["panic-unwind"]

[profile.release.package]
alloc.opt-level = 1
compiler_builtins.opt-level = 1
core.opt-level = 1
proc_macro.opt-level = 0
std.opt-level = 1
"""

# A wrapper that translates options for lld, which strips local symbols by -x instead of -s, and takes its options
# without a compiler's `-Wl,`.
LLD = """#!/bin/sh
for argument; do
    shift
    case $argument in
    -s) set -- "$@" -x ;;
    -Wl,-install_name,*) set -- "$@" -install_name "${{argument##*,}}" ;;
    *) set -- "$@" "$argument" ;;
    esac
done
exec {} "$@"
"""

# A wrapper that gets the compiler and its arguments. Without optimisation, code by default has debug assertions and
# overflow checks, which released binaries do not have.
UNOPTIMISED = """#!/bin/sh
case " $* " in *aarch64-unknown-linux*) level=1;; *) level=0;; esac
exec "$@" -Copt-level=$level -Cdebug-assertions=no
"""


def with_sources(usr: Path) -> dict:
    """The environment in which Cargo takes the Rust in a folder."""
    return {
        "CARGO": str(usr / "bin/cargo"),
        "RUSTC": str(usr / "bin/rustc"),
        "LD_LIBRARY_PATH": str(usr / "lib/x86_64-linux-gnu"),
        # rustup's Rust has this allocator built in; glibc's takes a tenth longer.
        "LD_PRELOAD": "libjemalloc.so.2",
        "RUSTC_BOOTSTRAP": "1",
    }


def script(path: Path, text: str) -> Path:
    """Writes an executable script; returns its path."""
    path.write_text(text)
    path.chmod(0o755)
    return path


def for_macos(sysroot: Path, build: Path) -> tuple[str, dict]:
    """Cargo's settings and environment to link for macOS; makes the files that they refer to in the folder `build`."""
    (lld,) = sysroot.glob("lib/rustlib/*/bin/rust-lld")
    linker = script(build / "rust-lld", LLD.format(shlex.quote(str(lld))))  # by the name rustc knows the kind of linker
    library = build / "sdk/usr/lib"
    shutil.rmtree(library, ignore_errors=True)
    library.mkdir(parents=True)
    # The Python environment of cargo-zigbuild also has zig.
    environment = Path(shutil.which("cargo-zigbuild")).parents[1]
    (names,) = environment.glob("lib/python3*/site-packages/ziglang/lib/libc/darwin/libSystem.tbd")
    # Apple's libraries are for arm64e, which takes calls from arm64; lld does not know the later variant arm64e.x1.
    text = re.sub(r"arm64e\.x1-\w+,?\s*", "", names.read_text()).replace("arm64e-", "arm64-")
    (library / names.name).write_text(text)
    for part in ("c", "iconv", "m", "objc"):
        (library / f"lib{part}.tbd").symlink_to(names.name)
    settings = "".join(f'[target.{target}]\nlinker = "{linker}"\n' for target in MACOS)
    return settings, {"SDKROOT": str(build / "sdk"), "MACOSX_DEPLOYMENT_TARGET": "11.0"}


def linker(target: str) -> tuple[str, str]:
    """The program that links for a target, and advice on how to get it."""
    if "windows" not in target:
        return "cargo-zigbuild", "pip install ziglang cargo-zigbuild"
    processor = target.split("-")[0]
    return f"{processor}-w64-mingw32-gcc", f"on Debian, apt install gcc-mingw-w64-{processor.replace('_', '-')}-win32"


def possible(wanted: list[str], toolchain: Path | None, sysroot: Path) -> Iterator[tuple[str, ...]]:
    """The targets of each of these platforms that this machine can compile for; prints which platforms it skips, and
    why."""
    for folder in wanted:
        targets = PLATFORMS[folder]
        triples = [target.split(".")[0] for target in targets]
        missing = [triple for triple in triples if not (sysroot / "lib/rustlib" / triple).exists()]
        program, advice = linker(targets[0])
        if shutil.which(program) is None:
            print(f"SKIPPED {folder}: {program} is missing: {advice}", flush=True)
        elif toolchain:
            # The standard library is compiled for Windows 7, so it needs nothing that an old wine lacks.
            yield tuple(target.replace("-pc-", "-win7-") for target in targets)
        elif missing:
            advice = f"rustup target add {' '.join(missing)}, or .ci/debian-rust"
            print(f"SKIPPED {folder}: there is no Rust for it: {advice}", flush=True)
        else:
            yield targets


def main() -> int:
    """Compiles for the platforms together, and packs the results with the binary for this machine."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--to-test", action="store_true")
    parser.add_argument("platforms", nargs="*", metavar="PLATFORM")
    options = parser.parse_args()
    if unknown := set(options.platforms) - set(PLATFORMS):
        parser.error(f"{', '.join(unknown)}: no such platform; allowed: {', '.join(PLATFORMS)}")
    folder = os.environ.get("CRADLE_DEBIAN_RUST")
    toolchain = Path(folder).resolve() / "usr" if folder else None
    sysroot = Path(rustc("sysroot"))
    shutil.rmtree(FOLDER, ignore_errors=True)
    with zipfile.ZipFile(FMU) as archive:
        ready = [name for name in archive.namelist() if name.startswith("binaries/")]
        archive.extractall(FOLDER, ready)
    command = [PRODUCER, "build", "--release", "--out", FOLDER / "NewtonsCradle.fmu"]
    command += [f"--binary={name.split('/')[1]}={FOLDER / name}" for name in ready]
    # Cargo's target folder; all targets share its build scripts and macros.
    build = TO_TEST if options.to_test else ROOT / "target/platforms"
    # Cargo reads settings from the folder that it runs in, and from its parents.
    (build / ".cargo").mkdir(parents=True, exist_ok=True)
    environment = {"CARGO_TARGET_DIR": str(build), "CARGO_TERM_QUIET": "true", "RUSTFLAGS": "-Clink-arg=-s"}
    environment |= with_sources(toolchain) if toolchain else {}
    if options.to_test:
        environment["RUSTC_WRAPPER"] = str(script(build / "unoptimised", UNOPTIMISED))
    # The linkers strip the binaries, because Debian's Rust cannot strip those for macOS.
    settings = '[profile.release]\nstrip = "none"\n' + (WITH_SOURCES if toolchain else "")
    for targets in possible(options.platforms or [*PLATFORMS], toolchain, sysroot):
        command += [f"--target={target}" for target in targets]
        if targets == MACOS:
            linking, more = for_macos(sysroot, build)
            settings, environment = settings + linking, environment | more
        elif "windows" in targets[0]:
            settings += f'[target.{targets[0]}]\nlinker = "{linker(targets[0])[0]}"\n'
    (build / ".cargo/config.toml").write_text(settings)
    return subprocess.run([str(part) for part in command], cwd=build, env=os.environ | environment).returncode


if __name__ == "__main__":
    sys.exit(main())
