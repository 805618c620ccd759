"""Make FMUs of other cradles, as the program `cradle-fmu` does."""

import os
import re
import shutil
import subprocess
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import archive, files
from .archive import Archive
from .errors import MOST_BALLS, CradleError, FmuError, InvalidValue, needed, warn, whole
from .fmu import Fmu, described
from .run import Model
from .run.model import concerns, given, split
from .setups import preset as of_preset


def build(
    *,
    balls: int | None = None,
    preset: str | None = None,
    set: Mapping[str, Any] | None = None,
    fmi: int = 2,
    out: str | Path | None = None,
    binaries: str | Path | None = None,
) -> Fmu:
    """Builds and opens an FMU, as `cradle-fmu build` does: with this many `balls`, from a `preset`, with start values
    changed by `set`.

    `nc.build(balls=13, set={"x_start": [-0.1] + 12 * [0], "contact.model": "hertz"})`. `fmi`: the version of the
    standard, 2 or 3. `out`: where to write the file; if None, into a temporary folder, removed with the FMU. Nothing is
    compiled: the binaries are those of the FMU `binaries`; if None, of the one that comes with the package. A preset
    has its own number of balls; for another, `balls=7, set=nc.preset("desk") | {"x_start": [-0.03] + 6 * [0]}`. Raises
    FmuError with what `cradle-fmu` says, InvalidValue, and FileMissing where that program is missing.
    """
    if balls is not None:
        whole("balls", balls, 1, MOST_BALLS)
    needed("preset", preset, str | None, "a name such as 'desk'")
    needed("set", set, Mapping | None, 'a dict such as {"ball.mass": 0.5}')
    whole("fmi", fmi, 2, 3)
    if preset is not None:
        of_preset(preset)
    source = files.newest(files.FMU) if binaries is None else files.regular(Path(binaries), "binaries: ")
    if out is not None:
        files.in_folder(out, "out")
    command: list[str | Path] = [files.producer(), "build", "--from", source, "--fmi", str(fmi)]
    command += ["--balls", str(balls)] if balls is not None else []
    command += ["--preset", preset] if preset is not None else []
    if set:
        model = Model(source, described(Archive(source)))
        for name, value in set.items():
            command += ["--set", f"{name}={written(model, name, value)}"]
    folder = archive.temporary()
    path = Path(out or folder / "NewtonsCradle.fmu").absolute()
    try:
        whole_command = [*command, "--out", path]
        done = subprocess.run(whole_command, capture_output=True, encoding="utf-8", errors="surrogateescape")
        if done.returncode:
            raise refused(done.stderr)
        said = [line.removeprefix("warning: ") for line in done.stderr.splitlines() if line.startswith("warning: ")]
        for line in said:
            if concerns(line, given(set or {})):
                warn(line)
        fmu = Fmu(path)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(fmu, archive.remove, folder, os.getpid())
    return fmu


def written(model: Model, name: str, value: Any) -> str:
    """A start value as text for `cradle-fmu`. Raises UnknownName, InvalidValue."""
    needed("set", name, str, "the name of a variable")
    array, _ = split(name)
    known = model.arrays.get(array)
    one = known[0] if known else name
    model.variable(one)
    model.check_settable(one, name)
    if name in model.arrays:
        return ",".join(exact(model, one, each) for each in model.listed(name, value))
    return exact(model, one, value, name)


def exact(model: Model, like: str, value: Any, name: str = "") -> str:
    """A value of the variable `like` as text that reads back as the same double or item; `name`: what messages call
    it."""
    try:
        number = model.number(like, value)
    except InvalidValue as problem:
        raise InvalidValue(str(problem).replace(like, name or like, 1)) from None
    items = {integer: item for item, integer in model.variable(like).items.items()}
    return str(items.get(int(number), number)) if items else repr(number)


def refused(said: str) -> CradleError:
    """The error for what `cradle-fmu` has said: InvalidValue if it refused a setting, else FmuError."""
    text = said.strip().splitlines()[-1].removeprefix("error: ") if said.strip() else "`cradle-fmu` has failed"
    bare = re.sub(r"^--set [^=]*=.*?: (?=\S+ |\S+:)", "", text).removeprefix("--")
    values = bare != text or bare.startswith(("balls =", "preset "))
    return (InvalidValue if values else FmuError)(bare)
