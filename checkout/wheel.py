"""Builds the contents of the wheel. pyproject.toml says where they go, packaging/wheel_hook.py the wheel's platform."""

import shutil
from pathlib import Path

from checkout import ENGINE, FMU, LIVE, PRODUCER, PYTHON, ROOT, SOME, Stop, make_venv, old_linux, run, say, stage
from checkout.page import make_page

FOLDER = ROOT / "target/wheel"
# Folders whose files the wheel puts onto the path, and into the package.
SCRIPTS, PACKAGE = FOLDER / "scripts", FOLDER / "package"


def make_wheel(fmu: Path | None) -> int:
    """Makes a wheel for pip: FMU, cradle-fmu and the Python package, in target/wheel."""
    if fmu is not None and not fmu.is_file():
        raise Stop(f"--fmu {fmu} is refused: there is no such file.")
    given = fmu and fmu.read_bytes()  # read first, because it may lie in the folder that is removed
    shutil.rmtree(FOLDER, ignore_errors=True)
    for folder in (SCRIPTS, PACKAGE):
        folder.mkdir(parents=True)
    with stage("1/3 Python packages"):
        make_venv(SOME)
    with stage("2/3 program and FMU (the first time, compiling takes minutes)"):
        # With cargo-zigbuild, the program runs on every Linux.
        target, environment = old_linux()
        build = ["cargo", "zigbuild" if target else "build", "--release", "--package", "cradle-packaging"]
        # Only what takes long at run time is optimised, compression and the FMU: so the rest compiles sooner.
        less = ["--config=profile.release.opt-level=1", "--config=profile.release.package.miniz_oxide.opt-level=3"]
        run([*build, *less, *target], env=environment)
        # In Cargo's folder, the target's name has no version of glibc.
        triple = target[1].split(".")[0] if target else ""
        shutil.copy2(ROOT / "target" / triple / "release" / PRODUCER.name, SCRIPTS)
        if given is None:
            out = ["--out", PACKAGE / FMU.name]
            run([SCRIPTS / PRODUCER.name, "build", "--release", *target, *out], env=environment)
        else:
            (PACKAGE / FMU.name).write_bytes(given)
    with stage("3/3 wheel"):
        if not ENGINE.exists():
            make_page(LIVE, or_skip=True)
        if ENGINE.exists():
            shutil.copyfile(ENGINE, PACKAGE / ENGINE.name)
        # zig links for glibc 2.17, whatever version this machine has.
        platform = {"CRADLE_WHEEL_PLATFORM": f"manylinux_2_17_{triple.split('-')[0]}"} if target else {}
        run([PYTHON, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", FOLDER, "."], env=environment | platform)
        (wheel,) = FOLDER.glob("*.whl")
        say(f"  pip install '{wheel.relative_to(ROOT)}[plot]'   ({wheel.stat().st_size / 1e6:.1f} MB)")
    if not ENGINE.exists():
        say("!! This wheel has no engine for browsers: `cradle-fmu live` will not work. `rustup target add")
        say("!! wasm32-unknown-unknown` and `python3 cradle.py page` make it; then make the wheel again.")
    return 0
