#!/usr/bin/env python3
"""Checks third-party packages against deny.toml with cargo-deny: licences, bans, sources and security advisories.

    python3 packaging/deny.py

It takes cargo-deny from the path or from target/tools. If it is in neither, it installs it in target/tools. Lines that
begin with SKIPPED say what it skips, such as the advisories if their database cannot be reached.
"""

import os
import shutil
import subprocess
import sys

from checkout import ROOT, Stop, run, say

TOOLS = ROOT / "target/tools"
VERSION = "0.20.2"


def main() -> int:
    """Runs all checks; returns 1 if one finds something."""
    deny = shutil.which("cargo-deny", path=f"{TOOLS / 'bin'}{os.pathsep}{os.environ['PATH']}")
    if deny is None:
        # Unoptimised, which halves the time.
        environment = {"CARGO_TARGET_DIR": str(ROOT / "target/hosts"), "CARGO_PROFILE_DEV_DEBUG": "0"}
        install = ["cargo", "install", "--locked", "--debug", "--root", TOOLS, f"cargo-deny@{VERSION}"]
        try:
            run(install, env=environment)
        except Stop as problem:
            say(
                f"SKIPPED licences, bans, sources and advisories: cargo-deny could not be installed: {problem}"
            )
            return 0
        deny = TOOLS / "bin/cargo-deny"
    code = run([deny, "--workspace", "check", "licenses", "bans", "sources"], check=False)
    command = [deny, "--workspace", "check", "advisories"]
    answer = subprocess.run(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    sys.stderr.write(answer.stderr)
    if "failed to fetch advisory database" in answer.stderr:
        say("SKIPPED advisories: their database cannot be reached")
        return min(code, 1)
    return 1 if code or answer.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
