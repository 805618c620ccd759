"""The file of an FMU: reading and unpacking."""

import os
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path, PurePosixPath

from .errors import FmuError, InvalidValue
from .files import regular

PREFIX = "cradle-"  # of temporary folders
_within: Path | None = None  # parent of this process's temporary folders; None: the system's default


class Archive:
    """An FMU's file. Raises FileMissing, InvalidValue, FmuError."""

    def __init__(self, path: Path):
        self.path = regular(path).absolute()  # the current folder may change
        with self._opened() as file:
            self.names = file.namelist()
        for name in self.names:
            parts = PurePosixPath(name)
            if parts.is_absolute() or ".." in parts.parts or "\\" in name or ":" in name:
                raise FmuError(f"{path} is refused: {name!r} in it is no path within an FMU")

    @contextmanager
    def _opened(self) -> Iterator[zipfile.ZipFile]:
        try:
            with zipfile.ZipFile(self.path) as file:
                yield file
        except FmuError:
            raise
        except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, UnicodeError) as problem:
            raise FmuError(f"{self.path} is not an FMU that can be read: {problem}") from problem

    def description(self) -> bytes:
        """The text of modelDescription.xml. Raises FmuError."""
        with self._opened() as file:
            if "modelDescription.xml" not in self.names:
                raise FmuError(f"{self.path} is not an FMU: it has no modelDescription.xml")
            return file.read("modelDescription.xml")

    def machines(self) -> list[str]:
        """The platform folders in `binaries`, sorted."""
        parts = (PurePosixPath(name).parts for name in self.names)
        return sorted({each[1] for each in parts if len(each) > 2 and each[0] == "binaries"})

    def unpack(self, folder: Path, wanted: Callable[[str], bool]) -> None:
        """Unpacks the wanted files that are not there yet. Raises FmuError, which names the folder."""
        with self._opened() as file:
            try:
                for name in self.names:
                    if wanted(name) and not (folder / name).exists():
                        file.extract(name, folder)
            except OSError as problem:
                raise FmuError(f"{self.path} cannot be unpacked: {problem} (in the folder {folder})") from problem


def keep_within(folder: Path) -> None:
    """Makes this process create its temporary folders in `folder`, which somebody else removes."""
    global _within
    _within = folder


def temporary(within: Path | None = None) -> Path:
    """A new temporary folder, in `within` if given. Raises FmuError."""
    within = within or _within
    try:
        return Path(tempfile.mkdtemp(prefix=PREFIX, dir=within)).absolute()
    except OSError as problem:
        place = within or tempfile.tempdir or "any folder for temporary files"
        raise FmuError(f"{place} takes no files: {problem}; set TMPDIR to a folder that does") from problem


def emptied(folder: Path, names: Iterable[str]) -> Callable[[], None]:
    """A function that removes files of these names from a user's folder. Raises InvalidValue unless the folder is new
    or empty, FmuError if it cannot be read."""
    try:
        if folder.is_dir() and any(folder.iterdir()):
            raise InvalidValue(f"folder: {folder} has files in it; allowed: a new folder, or an empty one")
    except OSError as problem:
        raise FmuError(f"folder: {folder} cannot be read: {problem}") from problem
    new = [each for each in (folder, *folder.parents) if not each.exists()]
    return partial(take_out, folder, tuple(names), new, os.getpid())


def remove(folder: Path, owner: int) -> None:
    """Removes a folder, but only in the process that made it, not in a fork of it."""
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)


def take_out(folder: Path, names: Iterable[str], new: Iterable[Path], owner: int) -> None:
    """Removes files of these names, then their folders and those in `new` if they are empty. Files of others stay. See
    `remove`."""
    if os.getpid() != owner:
        return
    for name in names:
        with suppress(OSError):  # a folder, or not there
            (folder / name).unlink()
    inside = {folder / parent for name in names for parent in PurePosixPath(name, "_").parents} - {folder}
    for each in sorted({*inside, *new}, key=lambda path: len(path.parts), reverse=True):
        with suppress(OSError):  # not empty
            each.rmdir()
