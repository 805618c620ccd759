"""An FMU for co-simulation (FMI 2.0) of a program in C and its description, for machines like this one.

docs/coupling.md has the command.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree
from zipfile import ZIP_DEFLATED, ZipFile

import fmpy


def pack(program: Path, description: Path, fmu: Path) -> Path:
    """Compiles the program, with the description's GUID as the macro GUID, and writes the FMU. Raises FileNotFoundError
    without a C compiler, CalledProcessError if it fails."""
    compiler = next(filter(shutil.which, ("cc", "gcc", "clang")), None)
    if not compiler:
        raise FileNotFoundError("a C compiler (cc, gcc or clang) is missing; the plant in Python needs none")
    root = ElementTree.parse(description).getroot()
    library = root.find("CoSimulation").get("modelIdentifier") + fmpy.sharedLibraryExtension
    options = ["-std=c11", "-Wall", "-Werror", "-O2", "-shared", "-fPIC", f'-DGUID="{root.get("guid")}"']
    options += [f"-I{Path(fmpy.__file__).with_name('c-code')}", program, "-lm"]
    with TemporaryDirectory() as folder:
        subprocess.run([compiler, *options, "-o", Path(folder, library)], check=True)
        with ZipFile(fmu, "w", ZIP_DEFLATED) as archive:
            archive.write(description, "modelDescription.xml")
            archive.write(Path(folder, library), f"binaries/{fmpy.platform}/{library}")
    return fmu


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("program", "description", "fmu"):
        parser.add_argument(name, type=Path)
    try:
        pack(**vars(parser.parse_args()))
    except FileNotFoundError as problem:
        sys.exit(f"error: {problem}")
    except subprocess.CalledProcessError:
        sys.exit("error: the program does not compile; the compiler's messages are above")
