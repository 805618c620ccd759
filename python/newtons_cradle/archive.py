"""The file of an FMU: what is read from it, and where it is unpacked."""

import os
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from .errors import FmuError
from .files import regular

PREFIX = "cradle-"  # of temporary folders


class Archive:
    """An FMU's file. Raises FileMissing, InvalidValue, FmuError."""

    def __init__(self, path: Path):
        self.path = regular(path)
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
        """The text of its description."""
        with self._opened() as file:
            if "modelDescription.xml" not in self.names:
                raise FmuError(f"{self.path} is not an FMU: it has no modelDescription.xml")
            return file.read("modelDescription.xml")

    def machines(self) -> list[str]:
        """The folders that it has binaries in."""
        parts = (PurePosixPath(name).parts for name in self.names)
        return sorted({each[1] for each in parts if len(each) > 2 and each[0] == "binaries"})

    def unpack(self, folder: Path, wanted: Callable[[str], bool]) -> None:
        """Unpacks what is wanted and not there yet. Raises FmuError, which names the folder."""
        with self._opened() as file:
            try:
                for name in self.names:
                    if wanted(name) and not (folder / name).exists():
                        file.extract(name, folder)
            except OSError as problem:
                raise FmuError(f"{self.path} cannot be unpacked: {problem} (in the folder {folder})") from problem


def temporary() -> Path:
    """A new temporary folder. Raises FmuError."""
    try:
        return Path(tempfile.mkdtemp(prefix=PREFIX))
    except OSError as problem:
        place = tempfile.tempdir or "any folder for temporary files"
        raise FmuError(f"{place} takes no files: {problem}; set TMPDIR to a folder that does") from problem


def remove(folder: Path, owner: int) -> None:
    """Removes a folder, if this is the process that made it, and not its child."""
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
