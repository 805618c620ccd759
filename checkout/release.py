"""Makes the files of a release in target/dist.

    python3 -m checkout.release fmus       the FMU for all platforms, one for each preset, and the page
    python3 -m checkout.release programs   for this machine, with what `fmus` has left there: wheel, cradle-fmu
    python3 -m checkout.release finish     when all files are in target/dist: bill of materials, SHA256SUMS

.github/workflows/release.yml calls it, and you can, too.
"""

import argparse
import hashlib
import os
import re
import shutil
import sys
import time
import tomllib
import zipfile

from checkout import ALL, ENGINE, FMU, LIVE, PRODUCER, PYTHON, ROOT, Stop, fmu_build, make_venv, run, rustc, say
from checkout.page import make_page
from checkout.platforms import PLATFORMS
from checkout.wheel import FOLDER, SCRIPTS, make_wheel

DIST = ROOT / "target/dist"
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
# Files that are packed with the program.
TEXTS = ("LICENSE-APACHE", "LICENSE-MIT", "packaging/assets/third-party-program.txt", "CHANGELOG.md")


def fmus() -> None:
    """An FMU of the default cradle and one for each preset, all checked; the page without a recording."""
    make_venv(ALL)
    make_page(DIST / LIVE.name)
    run(["cargo", "build", "--package", "cradle-packaging"])
    command, environment = fmu_build(PRODUCER)
    run(command, env=environment)
    run([sys.executable, "-m", "checkout.platforms"], env=environment)
    given = ROOT / "target/fmu/platforms" / FMU.name
    # The binaries that `cradle.py test --all` runs are hardly optimised.
    run([PYTHON, "-m", "pytest", "tests/hosts/test_platforms.py", "--fmu", FMU])
    with zipfile.ZipFile(given) as archive:
        found = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    if missing := {"linux64", *PLATFORMS} - found:
        raise Stop(f"{given} has no binary for {', '.join(sorted(missing))}: a release needs them all.")
    presets = sorted(path.stem for path in (ROOT / "packaging/presets").glob("*.toml"))
    for name, choice in [(FMU.stem, []), *((preset, ["--preset", preset]) for preset in presets)]:
        out = DIST / f"{name}.fmu"
        run([PRODUCER, "build", "--from", given, *choice, "--out", out])
        run([PRODUCER, "check", out])


def programs() -> None:
    """The wheel, and the program cradle-fmu in an archive of its own."""
    make_venv(ALL)
    page = DIST / LIVE.name
    if not page.is_file():
        raise Stop(f"{page} is missing: `python3 -m checkout.release fmus` makes it and the FMU.")
    ENGINE.parent.mkdir(parents=True, exist_ok=True)
    parts = re.findall(r'<script type="text/plain".*?</script>', page.read_text(encoding="utf-8"), re.DOTALL)
    ENGINE.write_text("\n".join(parts), encoding="utf-8")
    make_wheel(DIST / FMU.name)
    (wheel,) = FOLDER.glob("*.whl")
    shutil.copy2(wheel, DIST)
    out = DIST / f"cradle-fmu-{VERSION}-{rustc('host-tuple')}.zip"
    # As in FMUs, the time is `SOURCE_DATE_EPOCH`, or 1980-01-01, the earliest that a zip file can hold.
    date = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", 315532800)))[:6]
    with zipfile.ZipFile(out, "w") as archive:
        for path in (SCRIPTS / PRODUCER.name, *(ROOT / name for name in TEXTS)):
            entry = zipfile.ZipInfo(f"{out.stem}/{path.name}", date)
            entry.external_attr = (0o755 if path.name == PRODUCER.name else 0o644) << 16
            archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    say(f"  {out.relative_to(ROOT)} ({out.stat().st_size / 1e6:.1f} MB)")


def finish() -> None:
    """The bill of materials, and the checksums of all files."""
    tag = os.environ.get("GITHUB_REF_NAME", "")
    if re.match(r"v\d", tag) and tag != f"v{VERSION}":
        raise Stop(f"the tag {tag} does not match the version in Cargo.toml, {VERSION}.")
    make_venv(ALL)
    run([PYTHON, "-m", "checkout.sbom", DIST / f"newtons-cradle-{VERSION}.cdx.json"])
    files = sorted(path for path in DIST.iterdir() if path.name != "SHA256SUMS")
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (DIST / "SHA256SUMS").write_text("".join(lines), newline="\n")
    for path in files:
        say(f"{path.stat().st_size / 1e6:8.2f} MB  {path.name}")


def main() -> int:
    """Parses the command line and makes the files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    steps = {step.__name__: step for step in (fmus, programs, finish)}
    parser.add_argument("step", choices=steps)
    step = steps[parser.parse_args().step]
    DIST.mkdir(parents=True, exist_ok=True)
    try:
        step()
    except Stop as problem:
        say(f"\nThe release stopped: {problem}")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
