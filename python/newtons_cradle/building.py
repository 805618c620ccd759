"""Make FMUs of other cradles, as `cradle-fmu build` does."""

import shutil
import subprocess
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import files
from .errors import FmuError, needed, whole
from .fmu import Fmu


def build(
    *,
    balls: int | None = None,
    preset: str | None = None,
    set: Mapping[str, Any] | None = None,
    fmi: int = 2,
    out: str | Path | None = None,
    binaries: str | Path | None = None,
) -> Fmu:
    """An FMU of a cradle of so many `balls`, from a `preset`, with other start values by `set`; opened.

    `nc.build(balls=13, set={"x_start": [-0.1] + 12 * [0], "contact.model": "hertz"})`. `fmi`: the version of the
    standard, 2 or 3. `out`: where to write the file; if None, into a temporary folder, removed with the FMU. Nothing is
    compiled: `binaries` is the FMU whose binaries it gets; if None, the one that comes with the package. Raises
    FmuError with what `cradle-fmu` says, and FileMissing where that program is missing.
    """
    needed("set", set, Mapping | None, 'a dict such as {"ball.mass": 0.5}')
    whole("fmi", fmi, 2, 3)
    folder = Path(tempfile.mkdtemp(prefix="cradle-"))
    path = Path(out or folder / "NewtonsCradle.fmu").absolute()
    command: list[str | Path] = [files.producer(), "build", "--from", binaries or files.own_fmu()]
    command += ["--out", path, "--fmi", str(fmi)]
    command += ["--balls", str(balls)] if balls is not None else []
    command += ["--preset", preset] if preset is not None else []
    for name, value in (set or {}).items():
        several = isinstance(value, (list, tuple)) or hasattr(value, "tolist")
        command += ["--set", f"{name}={','.join(map(repr, map(float, value))) if several else value}"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        shutil.rmtree(folder, ignore_errors=True)
        raise FmuError(done.stderr.strip().removeprefix("error: "))
    fmu = Fmu(path)
    weakref.finalize(fmu, shutil.rmtree, folder, ignore_errors=True)
    return fmu
