"""Where the files are that come with the package: beside it in a wheel, with the sources and builds in a checkout."""

import sys
import sysconfig
import tomllib
from importlib import metadata
from pathlib import Path
from typing import Any

from .errors import FileMissing

HERE = Path(__file__).resolve().parent
CHECKOUT = HERE.parents[1]  # if this is one
MODEL = "NewtonsCradle"  # of which the FMUs of this package are
BUILT = CHECKOUT / "target/fmu/NewtonsCradle.fmu"


def in_checkout() -> bool:
    """Whether the package runs from its sources."""
    return (CHECKOUT / "packaging/presets").is_dir()


def own_fmu() -> Path:
    """The FMU that comes with a wheel or, in a checkout, the one that was built last. Raises FileMissing."""
    return newest(BUILT if in_checkout() else HERE / "NewtonsCradle.fmu")


def producer() -> Path:
    """The program cradle-fmu: that of the installation or, in a checkout, the one built last. Raises FileMissing."""
    name = "cradle-fmu.exe" if sys.platform == "win32" else "cradle-fmu"
    scripts = Path(sysconfig.get_path("scripts"), name)
    built = (CHECKOUT / "target" / profile / name for profile in ("release", "debug"))
    return newest(*(built if in_checkout() else [scripts]))


def newest(*paths: Path) -> Path:
    """The file that was made last of those that are there. Raises FileMissing, with what makes one."""
    found = [path for path in paths if path.is_file()]
    if not found:
        cure = "run `cargo pack build --release`" if in_checkout() else "install newtons-cradle again"
        raise FileMissing(f"{paths[0]} is missing: {cure}")
    return max(found, key=lambda path: path.stat().st_mtime)


def presets() -> dict[str, dict[str, Any]]:
    """The parameters in the files of the presets that `cradle-fmu build --preset` knows, in its order."""
    folder = CHECKOUT / "packaging/presets" if in_checkout() else HERE / "presets"
    names = (folder / "order.txt").read_text(encoding="utf-8").split()
    return {
        name: _dotted(tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))) for name in names
    }


def _dotted(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    """A table of tables as one, its names with dots: `pendulum.length`."""
    names: dict[str, Any] = {}
    for name, value in table.items():
        names |= _dotted(value, f"{before}{name}.") if isinstance(value, dict) else {before + name: value}
    return names


def page_folder() -> Path:
    """The page's template, style and scripts."""
    return CHECKOUT / "web/page" if in_checkout() else HERE / "web"


def engine_file() -> Path:
    """The engine for browsers, as a part of a page, if it has been built; see web/build.py."""
    return CHECKOUT / "target/web/engine.html" if in_checkout() else HERE / "engine.html"


def version() -> str:
    """The version of the package: that of the installation or, in a checkout, of the sources."""
    if in_checkout():
        workspace = tomllib.loads((CHECKOUT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]
        return str(workspace["package"]["version"])
    return metadata.version("newtons-cradle")
