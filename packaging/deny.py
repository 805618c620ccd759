#!/usr/bin/env python3
"""Checks other people's packages against deny.toml by cargo-deny: licences, bans and sources, and what is known of their security.

    python3 packaging/deny.py

It takes cargo-deny from the path or from target/tools, where it else installs it. It says what it skips, in lines that begin
with SKIPPED: the advisories, where their database cannot be had.
"""

import os
import shutil
import subprocess
import sys

from checkout import ROOT, Stop, run, say

TOOLS = ROOT / "target/tools"
VERSION = "0.20.2"


def program() -> str:
    """cargo-deny. Raises `Stop` where it cannot be installed."""
    path = f"{TOOLS / 'bin'}{os.pathsep}{os.environ['PATH']}"
    if found := shutil.which("cargo-deny", path=path):
        return found
    # Unoptimised, which takes half the time.
    environment = {"CARGO_TARGET_DIR": str(ROOT / "target/hosts"), "CARGO_PROFILE_DEV_DEBUG": "0"}
    command = ["cargo", "install", "--locked", "--debug", "--root", TOOLS, f"cargo-deny@{VERSION}"]
    run(command, env=environment)
    return str(TOOLS / "bin/cargo-deny")


def main() -> int:
    """Runs all checks; 1 where one finds something."""
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
