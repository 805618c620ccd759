"""Places of the package's files: beside it in a wheel, among the sources and builds in a checkout."""

import codecs
import sys
from functools import cache
from pathlib import Path
from typing import Any

from .errors import FileMissing, InvalidValue, needed

HERE = Path(__file__).resolve().parent
CHECKOUT = HERE.parents[1]  # if the package runs from one
LARGEST = 512 << 20  # bytes of a text file
MODEL = "NewtonsCradle"  # the modelName of this package's FMUs
IN_CHECKOUT = (CHECKOUT / "packaging/presets").is_dir()  # the package runs from its sources


def own(sources: str, wheel: str) -> Path:
    return CHECKOUT / sources if IN_CHECKOUT else HERE / wheel


FMU = own("target/fmu/NewtonsCradle.fmu", "NewtonsCradle.fmu")
PRESETS = own("packaging/presets", "presets")
PAGE = own("web/page", "web")  # the page's template, style and scripts
CASES = own("exact-rows/cases.json", "cases.json")  # of the benchmark
# The engine for browsers as a part of the page, if built by checkout/page.py.
ENGINE = own("target/web/engine.html", "engine.html")


def producer() -> Path:
    """The program cradle-fmu of the installation or, in a checkout, the one built last. Raises FileMissing."""
    name = "cradle-fmu.exe" if sys.platform == "win32" else "cradle-fmu"
    if not IN_CHECKOUT:
        import sysconfig

        return newest(Path(sysconfig.get_path("scripts"), name))
    return newest(*(CHECKOUT / "target" / profile / name for profile in ("release", "debug")))


def newest(*paths: Path) -> Path:
    """The newest of these files. Raises FileMissing, which names the command that makes one."""
    found = [path for path in paths if path.is_file()]
    if not found:
        cure = "run `cargo pack build --release`" if IN_CHECKOUT else "install newtons-cradle again"
        raise FileMissing(f"{paths[0]} is missing: {cure}")
    return max(found, key=lambda path: path.stat().st_mtime)


def regular(path: Path, what: str = "") -> Path:
    """Returns the path of a regular file, or of a link to one. Devices and pipes are refused: a device may have no end,
    and a pipe waits for its other end. Raises FileMissing, InvalidValue."""
    if not path.exists():
        raise FileMissing(f"{what}{path}: there is no such file")
    if not path.is_file():
        kind = "a folder" if path.is_dir() else "a device, a pipe or a socket"
        raise InvalidValue(f"{what}{path} is {kind}; allowed: a regular file")
    return path


def text(path: Path) -> str:
    """The text of a regular file that somebody else has written, in UTF-8 or UTF-16. Raises FileMissing, InvalidValue,
    OSError."""
    with regular(path).open("rb") as file:
        read = file.read(LARGEST + 1)  # the size that the system reports may be wrong
    if len(read) > LARGEST:
        raise InvalidValue(f"{path} is too large; allowed: at most {LARGEST} bytes")
    marked = read.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    wide = {b"\0": "utf-16-be"}.get(read[:1], "utf-16-le") if b"\0" in read[:2] else "utf-8-sig"
    return read.decode("utf-16" if marked else wide, errors="replace")


def in_folder(path: str | Path, what: str = "path") -> Path:
    """The path of a file to write. Raises FileMissing if there is no such folder, InvalidValue if it is no path, or
    something other than a regular file is there."""
    needed(what, path, str | Path, "the path of a file")
    if not (folder := Path(path).parent).is_dir():
        raise FileMissing(f"{what}: there is no folder {folder}")
    return regular(Path(path), f"{what}: ") if Path(path).exists() else Path(path)


@cache
def presets() -> dict[str, dict[str, Any]]:
    """The parameters of each preset of `cradle-fmu build --preset`, in its order. Do not change the result: it is
    shared."""
    names = (PRESETS / "order.txt").read_text(encoding="utf-8").split()
    return {name: _dotted(_toml(PRESETS / f"{name}.toml")) for name in names}


def _toml(path: Path) -> dict[str, Any]:
    import tomllib  # only here, because it takes a while

    return tomllib.loads(path.read_text(encoding="utf-8"))


def _dotted(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    """Flattens nested tables into dotted names: `pendulum.length`."""
    names: dict[str, Any] = {}
    for name, value in table.items():
        names |= _dotted(value, f"{before}{name}.") if isinstance(value, dict) else {before + name: value}
    return names


def version() -> str:
    """The version of the installed package or, in a checkout, of the sources."""
    if IN_CHECKOUT:
        return str(_toml(CHECKOUT / "Cargo.toml")["workspace"]["package"]["version"])
    from importlib import metadata

    return metadata.version("newtons-cradle")
