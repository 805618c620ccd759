"""Makes target/web/engine.html, the engine for the page, and the page.

The engine is compiled to WebAssembly: by the Rust in the folder CRADLE_DEBIAN_RUST if that is set (.ci/debian-rust
unpacks it), else by rustup's with its target wasm32-unknown-unknown.
"""

import base64
import gzip
import os
import shutil
from pathlib import Path

from checkout import ENGINE, PYTHON, ROOT, SOME, Stop, make_venv, run, rustc, say, stage
from checkout.platforms import with_sources

TARGET = "wasm32-unknown-unknown"
FOLDER = ROOT / "target/web"
COMPILED = FOLDER / TARGET / "release/cradle_web.wasm"
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE", "packaging/assets/third-party.txt")


def toolchain() -> dict:
    """The environment in which the program CARGO compiles for the target. Raises Stop, which says what is missing."""
    # The file must not contain paths of this machine. They may have spaces, which flags in RUSTFLAGS may not.
    home = os.environ.get("CARGO_HOME", str(Path.home() / ".cargo"))
    flags = [f"--remap-path-prefix={ROOT}=.", f"--remap-path-prefix={home}=/cargo"]
    folder = os.environ.get("CRADLE_DEBIAN_RUST")
    rustup = Path(rustc("sysroot")) if shutil.which("rustc") else None
    if folder:
        usr = Path(folder).resolve() / "usr"
        if not (usr / "bin/rustc").exists():
            raise Stop(f"CRADLE_DEBIAN_RUST={folder} holds no Rust: `.ci/debian-rust {folder}` unpacks it")
        # Debian's Rust comes without a linker for WebAssembly.
        others = rustup.glob("lib/rustlib/*/bin/rust-lld") if rustup else ()
        linker = shutil.which("wasm-ld") or shutil.which("rust-lld") or next(map(str, others), None)
        if linker is None:
            raise Stop("there is no linker for WebAssembly: rust-lld of rustup's Rust, or on Debian `apt install lld`")
        return with_sources(usr) | {
            "CARGO_UNSTABLE_BUILD_STD": "std,panic_abort",
            "CARGO_UNSTABLE_BUILD_STD_FEATURES": "",  # no backtraces: a page has no use for them
            f"CARGO_TARGET_{TARGET.upper().replace('-', '_')}_LINKER": linker,
            "CARGO_ENCODED_RUSTFLAGS": "\x1f".join([*flags, f"--remap-path-prefix={usr}=/rust"]),
        }
    if rustup is None:
        raise Stop("there is no Rust: https://rustup.rs")
    if not (rustup / "lib/rustlib" / TARGET).exists():
        raise Stop(
            f"there is no Rust for {TARGET}: `rustup target add {TARGET}`; where rustup cannot fetch it, on Debian, "
            "`.ci/debian-rust target/debian-rust` and CRADLE_DEBIAN_RUST=target/debian-rust"
        )
    return {"CARGO": "cargo", "CARGO_ENCODED_RUSTFLAGS": "\x1f".join(flags)}


def part() -> str:
    """The engine and its licences, compressed, as a part of the page."""
    licences = b"\n\n".join((ROOT / name).read_bytes() for name in LICENCES)
    text = ""
    for id, data in {"engine": COMPILED.read_bytes(), "licences": licences}.items():
        packed = base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()
        text += f'<script type="text/plain" id="{id}">{packed}</script>\n'
    return text


def make_page(out: Path, or_skip: bool = False) -> int:
    """Makes the page without a recording: the cradle live in a browser, one file that needs no network."""
    try:
        environment = toolchain() | {"CARGO_TARGET_DIR": str(FOLDER)}
    except Stop as missing:
        if not or_skip:
            raise
        say(f"SKIPPED live page: {missing}")
        return 0
    command = [environment["CARGO"], "build", "--release", "--locked", "--target", TARGET]
    with stage("The engine for browsers: the first time about a minute, then seconds"):
        run(command, cwd=ROOT / "web", env=environment)
    ENGINE.write_text(part(), encoding="utf-8")
    make_venv(SOME)
    out = out.resolve()
    out.parent.mkdir(parents=True, exist_ok=True)
    run([PYTHON, "-m", "newtons_cradle", "live", "--out", out])
    return 0
