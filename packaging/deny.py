#!/usr/bin/env python3
"""Checks third-party packages against deny.toml with cargo-deny: licences, bans, sources and security advisories.

    python3 packaging/deny.py

It takes cargo-deny from the path or from target/tools. If it is in neither, it installs it in target/tools. Lines that begin
with SKIPPED say what it skips, such as the advisories if their database cannot be reached.
"""

import os
import shutil
import subprocess
import sys

from checkout import ROOT, Stop, run, say

TOOLS = ROOT / "target/tools"
VERSION = "0.20.2"


def program() -> str:
    """The program cargo-deny. Raises `Stop` if it cannot be installed."""
    path = f"{TOOLS / 'bin'}{os.pathsep}{os.environ['PATH']}"
    if found := shutil.which("cargo-deny", path=path):
        return found
    # Unoptimised, which halves the time.
    environment = {"CARGO_TARGET_DIR": str(ROOT / "target/hosts"), "CARGO_PROFILE_DEV_DEBUG": "0"}
    command = ["cargo", "install", "--locked", "--debug", "--root", TOOLS, f"cargo-deny@{VERSION}"]
    run(command, env=environment)
    return str(TOOLS / "bin/cargo-deny")


def main() -> int:
    """Runs all checks; returns 1 if one finds something."""
    try:
        deny = program()
    except Stop as problem:
        say(f"SKIPPED licences, bans, sources and advisories: cargo-deny could not be installed: {problem}")
        return 0
    code = run([deny, "--workspace", "check", "licenses", "bans", "sources"], check=False)
    answer = subprocess.run(
        [deny, "--workspace", "check", "advisories"], cwd=ROOT, capture_output=True, text=True
    )
    sys.stderr.write(answer.stderr)
    if "failed to fetch advisory database" in answer.stderr:
        say("SKIPPED advisories: their database cannot be reached")
    else:
        code |= answer.returncode
    return 1 if code else 0


if __name__ == "__main__":
    sys.exit(main())
