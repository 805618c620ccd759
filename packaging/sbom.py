#!/usr/bin/env python3
"""Writes the bill of materials of a release in the format CycloneDX.

    .venv/bin/python packaging/sbom.py FILE.json

Three components contain third-party code: the FMU's library, the program cradle-fmu and the pages. `cargo tree`, for all
targets, says what is linked into the first two, and packaging/std/Cargo.toml what the standard library brings along; three.js comes
from the package trimesh. The file is checked against the schema.
"""

import json
import re
import subprocess
import sys
import uuid
from datetime import UTC, datetime
from os import environ
from pathlib import Path

from checkout import ROOT
from cyclonedx.model import HashAlgorithm, HashType
from cyclonedx.model.bom import Bom, BomMetaData
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import DisjunctiveLicense, LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from newtons_cradle.animation.page import THREE_JS_SHA256, three_js
from packageurl import PackageURL

# This project's packages that become binaries, and their types.
PROGRAMS = {"newtons-cradle": ComponentType.LIBRARY, "cradle-packaging": ComponentType.APPLICATION}
STD = ROOT / "packaging/std"


def cargo(*arguments: str, folder: Path = ROOT) -> str:
    """What Cargo says about the packages in a Cargo.lock."""
    command = ["cargo", *arguments, "--locked"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout


def linked(*options: str, folder: Path = ROOT) -> set[tuple[str, str]]:
    """Names and versions of the packages that `cargo tree` with these options shows."""
    lines = cargo("tree", "--prefix", "none", "--format", "{p}", *options, folder=folder).splitlines()
    return {tuple(re.match(r"(\S+) v(\S+)", line).groups()) for line in lines if line}


def linked_into(package: str) -> set[tuple[str, str]]:
    """What is linked into one of our packages on any target: no build scripts, no macros."""
    options = ["--package", package, "--edges", "normal,no-proc-macro", "--target", "all"]
    return linked(*options) | linked("--depth", "1", folder=STD)


def metadata(folder: Path) -> dict[tuple[str, str], dict]:
    """All packages in a Cargo.lock by name and version."""
    found = json.loads(cargo("metadata", "--format-version=1", folder=folder))["packages"]
    return {(package["name"], package["version"]): package for package in found}


def checksums() -> dict[tuple[str, str], str]:
    """SHA-256 of each package's archive."""
    text = "".join((folder / "Cargo.lock").read_text() for folder in (ROOT, STD))
    entries = re.findall(r'name = "(.+)"\nversion = "(.+)"\nsource = ".+"\nchecksum = "(.+)"', text)
    return {(name, version): checksum for name, version, checksum in entries}


def bill() -> Bom:
    """The bill of this version. The same sources give the same bytes; the time is `SOURCE_DATE_EPOCH`, or 1980-01-01 as in FMUs."""
    packages = metadata(STD) | metadata(ROOT)
    version = next(v for name, v in packages if name == "newtons-cradle")
    archives = checksums()
    components = {}
    for key, package in packages.items():
        name, number = key
        kind = PROGRAMS.get(name, ComponentType.LIBRARY)
        url = PackageURL("cargo", name=name, version=number)
        if name == "std":
            url = PackageURL("github", namespace="rust-lang", name="rust", version=number)
        own = package["source"] is None
        components[key] = Component(
            name=name,
            version=number,
            type=kind,
            purl=url,
            bom_ref=str(url),
            # Older manifests separate alternatives by slashes.
            licenses=[LicenseExpression(package["license"].replace("/", " OR "))],
            hashes=[] if own else [HashType(alg=HashAlgorithm.SHA_256, content=archives[key])],
        )
    revision = re.search(r'REVISION="?(\d+)|const \w="(1\d\d)"', three_js())
    number = f"0.{next(filter(None, revision.groups()))}.0"
    url = PackageURL("npm", name="three", version=number)
    three = Component(
        name="three",
        version=number,
        purl=url,
        bom_ref=str(url),
        licenses=[DisjunctiveLicense(id="MIT")],
        hashes=[HashType(alg=HashAlgorithm.SHA_256, content=THREE_JS_SHA256)],
    )
    whole = Component(
        name="newtons-cradle release",
        version=version,
        type=ComponentType.APPLICATION,
        bom_ref="release",
        licenses=[LicenseExpression("MIT OR Apache-2.0")],
    )
    epoch = int(environ.get("SOURCE_DATE_EPOCH", 315532800))
    about = BomMetaData(component=whole, timestamp=datetime.fromtimestamp(epoch, UTC))
    used = {name: linked_into(name) for name in PROGRAMS}
    in_use = [components[key] for key in sorted(set().union(*used.values()))]
    serial = uuid.uuid5(uuid.NAMESPACE_URL, "\n".join(sorted(str(part.purl) for part in [*in_use, three])))
    bom = Bom(components=[*in_use, three], metadata=about, serial_number=serial)
    for name, keys in used.items():
        bom.register_dependency(components[name, version], [components[k] for k in keys if k[0] != name])
    bom.register_dependency(whole, [*(components[name, version] for name in PROGRAMS), three])
    return bom


def main() -> int:
    """Writes the bill; returns 1 if it does not follow its schema."""
    text = JsonV1Dot6(bill()).output_as_string(indent=1)
    if problem := JsonStrictValidator(SchemaVersion.V1_6).validate_str(text):
        print(f"the bill of materials does not follow the CycloneDX 1.6 schema: {problem}", file=sys.stderr)
        return 1
    Path(sys.argv[1]).write_text(text + "\n")
    print(f"{sys.argv[1]}: {len(json.loads(text)['components'])} components")
    return 0


if __name__ == "__main__":
    sys.exit(main())
