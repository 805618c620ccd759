"""Writes the bill of materials of a release in the format CycloneDX.

    .venv/bin/python -m checkout.sbom FILE.json

Two components contain third-party code: the FMU's library, which is also the page's engine, and the program cradle-fmu.
Cargo says which packages are linked into them.
"""

import re
import sys
from datetime import UTC, datetime
from os import environ
from uuid import NAMESPACE_URL, uuid5

from cyclonedx.model import HashAlgorithm, HashType
from cyclonedx.model.bom import Bom, BomMetaData
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

from checkout import ROOT
from checkout.licences import STD, linked_into

# This project's packages that become binaries, and their types.
PROGRAMS = {"newtons-cradle": ComponentType.LIBRARY, "cradle-packaging": ComponentType.APPLICATION}


def bill() -> Bom:
    """The bill of this version. The same sources give the same bytes; the time is `SOURCE_DATE_EPOCH`, or
    1980-01-01."""
    locks = "".join((folder / "Cargo.lock").read_text() for folder in (ROOT, STD))
    archives = re.findall(r'name = "(.+)"\nversion = "(.+)"\nsource = ".+"\nchecksum = "(.+)"', locks)
    checksums = {(name, version): checksum for name, version, checksum in archives}

    def component(name: str, version: str, licence: str, **more) -> Component:
        # Older manifests separate alternatives by slashes.
        licences = [LicenseExpression(licence.replace("/", " OR "))]
        return Component(name=name, version=version, licenses=licences, **more)

    used, parts = {program: linked_into(program) for program in PROGRAMS}, {}
    for (name, version), package in (used["newtons-cradle"] | used["cradle-packaging"]).items():
        place = ("github", "rust-lang", "rust") if name == "std" else ("cargo", None, name)
        url, checksum = PackageURL(*place, version), checksums.get((name, version))
        more = {"purl": url, "bom_ref": str(url), "type": PROGRAMS.get(name, ComponentType.LIBRARY)}
        more["hashes"] = [HashType(alg=HashAlgorithm.SHA_256, content=checksum)] if checksum else []
        parts[name, version] = component(name, version, package["license"], **more)
    programs = {name: part for (name, _), part in parts.items() if name in PROGRAMS}
    version = programs["newtons-cradle"].version
    of_release = {"type": ComponentType.APPLICATION, "bom_ref": "release"}
    whole = component("newtons-cradle release", version, "MIT OR Apache-2.0", **of_release)
    epoch = datetime.fromtimestamp(int(environ.get("SOURCE_DATE_EPOCH", 315532800)), UTC)
    serial = uuid5(NAMESPACE_URL, "\n".join(sorted(str(part.purl) for part in parts.values())))
    bom = Bom(components=parts.values(), serial_number=serial, metadata=BomMetaData(component=whole, timestamp=epoch))
    bom.register_dependency(whole, programs.values())
    for program, own in programs.items():
        bom.register_dependency(own, [parts[key] for key in used[program] if parts[key] is not own])
    return bom


if __name__ == "__main__":
    JsonV1Dot6(bill()).output_to_file(sys.argv[1], allow_overwrite=True, indent=1)
