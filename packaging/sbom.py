#!/usr/bin/env python3
"""Writes the bill of materials of a release in the format CycloneDX.

    .venv/bin/python packaging/sbom.py FILE.json

Two components contain third-party code: the FMU's library, which the page's engine is as well, and the program
cradle-fmu. Cargo says what is linked into them. The file is checked against the schema.
"""

import json
import re
import sys
import uuid
from datetime import UTC, datetime
from os import environ
from pathlib import Path
from urllib.parse import quote

from checkout import ROOT
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from licences import STD, linked_into

# This project's packages that become binaries, and their types.
PROGRAMS = {"newtons-cradle": "library", "cradle-packaging": "application"}


def bill() -> dict:
    """The bill of this version. The same sources give the same bytes; the time is `SOURCE_DATE_EPOCH`, or
    1980-01-01."""
    locks = "".join((folder / "Cargo.lock").read_text() for folder in (ROOT, STD))
    archives = re.findall(r'name = "(.+)"\nversion = "(.+)"\nsource = ".+"\nchecksum = "(.+)"', locks)
    checksums = {(name, version): checksum for name, version, checksum in archives}
    used = {program: linked_into(program) for program in PROGRAMS}
    parts, depends = {}, {}
    for (name, version), package in sorted((used["newtons-cradle"] | used["cradle-packaging"]).items()):
        place = "github/rust-lang/rust" if name == "std" else f"cargo/{name}"
        url, kind = f"pkg:{place}@{quote(version)}", PROGRAMS.get(name, "library")
        # Older manifests separate alternatives by slashes.
        licences = [{"expression": package["license"].replace("/", " OR ")}]
        named = {"type": kind, "name": name, "version": version, "licenses": licences}
        parts[name, version] = named | {"bom-ref": url, "purl": url}
        if checksum := checksums.get((name, version)):
            parts[name, version]["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    for program, packages in used.items():
        own = next(key for key in packages if key[0] == program)
        depends[parts[own]["bom-ref"]] = [parts[key]["bom-ref"] for key in packages if key != own]
    components = list(parts.values())
    whole = {
        "type": "application",
        "name": "newtons-cradle release",
        "version": own[1],
        "licenses": [{"expression": "MIT OR Apache-2.0"}],
        "bom-ref": "release",
    }
    epoch = datetime.fromtimestamp(int(environ.get("SOURCE_DATE_EPOCH", 315532800)), UTC)
    serial = uuid.uuid5(uuid.NAMESPACE_URL, "\n".join(sorted(part["purl"] for part in components)))
    depends["release"] = list(depends)
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "serialNumber": serial.urn,
        "metadata": {"component": whole, "timestamp": epoch.isoformat()},
        "components": components,
        "dependencies": [{"ref": one, "dependsOn": others} for one, others in depends.items()],
    }


def main() -> int:
    """Writes the bill; returns 1 if it does not follow its schema."""
    text = json.dumps(bill(), indent=1)
    if problem := JsonStrictValidator(SchemaVersion.V1_6).validate_str(text):
        print(f"the bill of materials does not follow the CycloneDX 1.6 schema: {problem}", file=sys.stderr)
        return 1
    Path(sys.argv[1]).write_text(text + "\n")
    print(f"{sys.argv[1]}: {len(json.loads(text)['components'])} components")
    return 0


if __name__ == "__main__":
    sys.exit(main())
