"""Renews the licence texts in every FMU and with the program, after a change of dependencies.

    python3 -m checkout.licences

These are the licences of all that is linked in, including the packages within the standard library, which
packaging/std/Cargo.toml lists.
"""

import os
import re
import subprocess
from pathlib import Path

from checkout import ROOT

# Arguments of `packages` for the standard library and the packages within it.
STD, OF_STD = ROOT / "packaging/std", ("--depth", "1")
SOURCES = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo")) / "registry/src"
# For each file of packaging/assets: the package whose licences it has, and its first words.
FILES = {
    "third-party.txt": ("newtons-cradle", "The binaries of this FMU hold"),
    "third-party-program.txt": ("cradle-packaging", "The program cradle-fmu holds"),
}
HEADING = """ code of the packages below, and of the Rust standard library
(https://www.rust-lang.org, MIT OR Apache-2.0). The texts of their licences follow.

"""


def packages(folder: Path, *options: str) -> dict[tuple[str, str], dict]:
    """The packages that `cargo tree` with these options lists in a folder with a Cargo.lock, by name and version."""
    command = ["cargo", "tree", "--locked", "--prefix", "none", "--format", "{p}\t{l}\t{r}", *options]
    tree = subprocess.run(command, cwd=folder, capture_output=True, check=True, encoding="utf-8").stdout
    # This project's packages have a path; (*) marks a package listed before.
    pattern = r"(\S+) v(\S+)(?P<path> \(.+\))?\t(?P<license>.+)\t(?P<repository>\S*)( \(\*\))?"
    found = [re.fullmatch(pattern, line) for line in tree.splitlines() if line]
    assert all(found), f"a package without a licence: {tree}"
    return {one.group(1, 2): one.groupdict() for one in found}


def linked_into(package: str) -> dict[tuple[str, str], dict]:
    """The packages linked into one of this project's packages, itself included, on any target: no build scripts, no
    procedural macros."""
    options = ["--package", package, "--edges", "normal,no-proc-macro", "--target", "all"]
    return dict(sorted((packages(ROOT, *options) | packages(STD, *OF_STD)).items()))


def texts(package: str, first: str) -> str:
    """A licence file: the third-party packages linked into `package`, then each text of a licence once, with its
    packages."""
    listed, licences = "", {}
    for (name, version), other in linked_into(package).items():
        if other["path"]:
            continue
        listed += f"{name} {version}, {other['license']}, {other['repository']}\n"
        files = sorted(next(SOURCES.glob(f"*/{name}-{version}")).iterdir())
        begin = ("LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE")
        found = [file for file in files if file.name.upper().startswith(begin) and file.is_file()]
        if not found:
            # Some archives lack the text. The Apache License has the same text for all.
            assert "Apache-2.0" in other["license"], f"{name} has no text of its licence"
            found = [ROOT / "LICENSE-APACHE"]
        for file in found:
            licences.setdefault(file.read_text(encoding="utf-8"), set()).add(f"{name} {version}")
    sections = (f"\n==== {', '.join(sorted(names))}\n\n{text.rstrip()}\n" for text, names in sorted(licences.items()))
    return f"{first}{HEADING}{listed}{''.join(sections)}"


if __name__ == "__main__":
    for name, what in FILES.items():
        (ROOT / "packaging/assets" / name).write_text(texts(*what), encoding="utf-8", newline="\n")
