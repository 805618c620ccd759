"""Makes the site of the documents: mkdocs, by checkout/mkdocs.yml and checkout/site_hook.py, from docs, the Python
package's docstrings, the FMU's own page, the rustdoc, and the live page if it has been made."""

import shutil
import zipfile
from pathlib import Path

from checkout import DOCS, FMU, LIVE, PYTHON, ROOT, Stop, fmu_build, make_venv, run, say, stage

SITE = ROOT / "out/site"
# What goes into the site besides docs; site_hook.py takes it from here.
PARTS = ROOT / "target/site"
# Apart from what the tests compile, so that nobody waits for Cargo's lock, nor finds the pages of other packages there.
RUSTDOC = ROOT / "target/rustdoc"


def make_site(out: Path, fmu: Path | None) -> int:
    """Makes the site of the documents, with search, to be read from the disk or from a server."""
    if fmu is not None and not fmu.is_file():
        raise Stop(f"--fmu {fmu} is refused: there is no such file.")
    if out.exists() and any(out.iterdir()) and not (out / "search").is_dir():
        raise Stop(f"--out {out} is refused: it would be emptied, and holds no site; allowed: a new or empty folder.")
    with stage("Python packages"):
        make_venv(DOCS)
    with stage("FMU, whose page lists the variables (the first time, compiling takes a minute)"):
        if fmu is None:
            command, environment = fmu_build("cargo", "pack")
            run(command, env=environment)
    build(out, fmu or FMU)
    say(f"  {out / 'index.html'}")
    return 0


def build(out: Path, fmu: Path) -> None:
    """Makes the site into a folder, which is emptied first, with packages and FMU that are there."""
    shutil.rmtree(PARTS, ignore_errors=True)
    PARTS.mkdir(parents=True)
    with stage("rustdoc"):
        command = ["cargo", "doc", "--quiet", "--package", "newtons-cradle", "--no-deps", "--target-dir", RUSTDOC]
        run(command, env={"RUSTDOCFLAGS": "-Dwarnings"})
        folder = shutil.copytree(RUSTDOC / "doc", PARTS / "rust")
        for path in folder.rglob("*.md"):  # licences of fonts, not pages
            path.rename(path.with_suffix(".txt"))
    with stage("mkdocs"):
        with zipfile.ZipFile(fmu) as archive:
            (PARTS / "fmu.html").write_bytes(archive.read("documentation/index.html"))
        for name in ("iframe-worker.js", "site.css"):
            shutil.copy(ROOT / "checkout" / name, PARTS)
        if LIVE.exists():
            shutil.copy(LIVE, PARTS)
        else:
            say("  !! a picture takes the place of the live page: `python3 cradle.py page` makes it")
        command = [PYTHON, "-m", "mkdocs", "build", "--strict", "--config-file", "checkout/mkdocs.yml"]
        run([*command, "--site-dir", out.resolve()], env={"NO_MKDOCS_2_WARNING": "1"})
