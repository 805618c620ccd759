#!/usr/bin/env python3
"""Makes target/fmu/platforms/NewtonsCradle.fmu: one FMU with a binary for each platform that can be compiled for here.

    python3 packaging/platforms.py FMU

FMU is an FMU for this machine, whose binary is taken over. For Windows it takes the toolchain that .ci/windows-toolchain has put
into the folder CRADLE_WINDOWS_RUST, or else rustup's target x86_64-pc-windows-gnu; both need the linker of mingw. It says what
it skips, in lines that begin with SKIPPED.
"""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "target/fmu/platforms"
LINKER = "x86_64-w64-mingw32-gcc"


def producer(*arguments, **environment) -> None:
    """Runs cradle-fmu from the sources."""
    subprocess.run(["cargo", "build", "--quiet", "--package", "cradle-packaging"], cwd=ROOT, check=True)
    program = ROOT / "target/debug" / ("cradle-fmu.exe" if os.name == "nt" else "cradle-fmu")
    command = [str(part) for part in (program, *arguments)]
    subprocess.run(command, cwd=ROOT, env=os.environ | environment, check=True)


def windows() -> Path | None:
    """An FMU for 64-bit Windows, or nothing where there is no toolchain for it."""
    if shutil.which(LINKER) is None:
        print(f"SKIPPED win64: {LINKER} is missing: on Debian, `apt install gcc-mingw-w64-x86-64-win32`")
        return None
    out = FOLDER / "win64.fmu"
    toolchain = os.environ.get("CRADLE_WINDOWS_RUST")
    if toolchain:
        usr = Path(toolchain).resolve() / "usr"
        # Windows 7 is what the standard library needs nothing newer than; it has to be compiled along.
        target = "x86_64-win7-windows-gnu"
        environment = {
            "CARGO": str(usr / "bin/cargo"),
            "RUSTC": str(usr / "bin/rustc"),
            "LD_LIBRARY_PATH": str(usr / "lib/x86_64-linux-gnu"),
            "RUSTC_BOOTSTRAP": "1",
            "CARGO_UNSTABLE_BUILD_STD": "std,panic_unwind",
            "CARGO_TARGET_X86_64_WIN7_WINDOWS_GNU_LINKER": LINKER,
            "CARGO_TARGET_DIR": str(ROOT / "target/windows"),
        }
    else:
        target = "x86_64-pc-windows-gnu"
        sysroot = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True)
        if not (Path(sysroot.stdout.strip()) / "lib/rustlib" / target).exists():
            print(
                f"SKIPPED win64: there is no Rust for it: `rustup target add {target}`, or .ci/windows-toolchain"
            )
            return None
        environment = {"CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER": LINKER}
    producer("build", "--release", "--target", target, "--out", out, **environment)
    return out


def main() -> int:
    """Collects the binaries of all FMUs and packs them together."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    binaries = []
    for fmu in filter(None, [Path(sys.argv[1]), windows()]):
        with zipfile.ZipFile(fmu) as archive:
            names = [name for name in archive.namelist() if name.startswith("binaries/")]
            archive.extractall(FOLDER, names)
        binaries += [f"--binary={name.split('/')[1]}={FOLDER / name}" for name in names]
    producer("build", *binaries, "--out", FOLDER / "NewtonsCradle.fmu")
    return 0


if __name__ == "__main__":
    sys.exit(main())
