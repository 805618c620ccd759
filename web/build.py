#!/usr/bin/env python3
"""Makes target/web/cradle.html: the cradle live in a browser, one file that needs no network.

    python3 web/build.py [--out FILE] [--or-skip]

The engine is compiled to WebAssembly: by the Rust in the folder CRADLE_DEBIAN_RUST if that is set (.ci/debian-rust
unpacks it), else by rustup's with its target wasm32-unknown-unknown.
With --or-skip, a line that begins with SKIPPED says what is missing, and that is no failure.
"""

import argparse
import base64
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

WEB = Path(__file__).resolve().parent
ROOT = WEB.parent
TARGET = "wasm32-unknown-unknown"
FOLDER = ROOT / "target/web"
ENGINE = FOLDER / TARGET / "release/cradle_web.wasm"
DEFAULT = FOLDER / "cradle.html"

LICENCES = ("LICENSE-MIT", "LICENSE-APACHE", "packaging/assets/third-party.txt")


class Missing(Exception):
    """What is missing, in words."""


def toolchain() -> tuple[str, dict]:
    """The program cargo, and the environment in which it compiles for the target."""
    # Paths of this machine have no place in the file.
    home = os.environ.get("CARGO_HOME", str(Path.home() / ".cargo"))
    flags = [f"--remap-path-prefix={ROOT}=.", f"--remap-path-prefix={home}=/cargo"]
    folder = os.environ.get("CRADLE_DEBIAN_RUST")
    print_root = ["rustc", "--print", "sysroot"]
    rustup = Path(subprocess.check_output(print_root, text=True).strip()) if shutil.which("rustc") else None
    if folder:
        usr = Path(folder).resolve() / "usr"
        if not (usr / "bin/rustc").exists():
            raise Missing(f"CRADLE_DEBIAN_RUST={folder} holds no Rust: `.ci/debian-rust {folder}` unpacks it")
        # Debian's Rust comes without a linker for WebAssembly.
        others = [*usr.glob("**/wasm-ld"), *usr.glob("**/rust-lld")]
        others += rustup.glob("lib/rustlib/*/bin/rust-lld") if rustup else ()
        linker = shutil.which("wasm-ld") or shutil.which("rust-lld") or next(map(str, others), None)
        if linker is None:
            cure = "rust-lld of a Rust by rustup, or on Debian `apt install lld`"
            raise Missing(f"there is no linker for WebAssembly: {cure}")
        return str(usr / "bin/cargo"), {
            "RUSTC": str(usr / "bin/rustc"),
            "LD_LIBRARY_PATH": str(usr / "lib/x86_64-linux-gnu"),
            "RUSTC_BOOTSTRAP": "1",
            "CARGO_UNSTABLE_BUILD_STD": "std,panic_abort",
            f"CARGO_TARGET_{TARGET.upper().replace('-', '_')}_LINKER": linker,
            "RUSTFLAGS": " ".join([*flags, f"--remap-path-prefix={usr}=/rust"]),
        }
    if rustup is None:
        raise Missing("there is no Rust: https://rustup.rs")
    if not (rustup / "lib/rustlib" / TARGET).exists():
        raise Missing(
            f"there is no Rust for {TARGET}: `rustup target add {TARGET}`; where rustup cannot fetch it, on Debian, "
            "`.ci/debian-rust target/debian-rust` and CRADLE_DEBIAN_RUST=target/debian-rust"
        )
    return "cargo", {"RUSTFLAGS": " ".join(flags)}


def compile_engine() -> None:
    """Compiles the engine."""
    cargo, environment = toolchain()
    command = [cargo, "build", "--release", "--locked", "--target", TARGET]
    environment = os.environ | environment | {"CARGO_TARGET_DIR": str(FOLDER)}
    if code := subprocess.run(command, cwd=WEB, env=environment).returncode:
        sys.exit(code)


def page() -> str:
    """The finished page."""
    # A script may need those of its room that come before it, and all rooms before its own.
    scripts = [ROOT / "python/newtons_cradle/look/common.js"]
    for room in ("engine", "view", "control"):
        scripts += sorted((WEB / "page" / room).glob("*.js"))
    parts = {
        "presets": json.dumps(presets()),
        "style": text("style.css"),
        "engine": packed(ENGINE.read_bytes()),
        "licences": packed(b"\n\n".join((ROOT / name).read_bytes() for name in LICENCES)),
        "script": "\n".join(map(text, scripts)),
    }
    finished = text("template.html")
    for _ in range(2):  # the scripts have slots, too
        finished = re.sub(r"{{(\w+)}}", lambda slot: parts[slot[1]], finished)
    return finished


def text(name: str | Path) -> str:
    """A file of the page."""
    return (WEB / "page" / name).read_text(encoding="utf-8")


def packed(data: bytes) -> str:
    """Compressed, as text."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()


def presets() -> dict:
    """The producer's ready cradles, by name."""
    files = sorted((ROOT / "packaging/presets").glob("*.toml"))
    return {file.stem: flat(tomllib.loads(file.read_text(encoding="utf-8"))) for file in files}


def flat(table: dict, before: str = "") -> dict:
    """A table of tables as one, its names with dots: `pendulum.length`."""
    names = {}
    for name, value in table.items():
        names |= flat(value, f"{before}{name}.") if isinstance(value, dict) else {before + name: value}
    return names


def main() -> int:
    """Compiles the engine and writes the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=DEFAULT, help="where to write it [default: %(default)s]")
    parser.add_argument("--or-skip", action="store_true", help="no failure if something is missing")
    options = parser.parse_args()
    try:
        compile_engine()
        finished = page()
    except Missing as missing:
        print(f"{'SKIPPED live page' if options.or_skip else 'error'}: {missing}", file=sys.stderr)
        return 0 if options.or_skip else 1
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(finished, encoding="utf-8")
    print(f"{options.out} ({len(finished.encode()) / 1000:.0f} kB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
