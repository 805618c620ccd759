"""What hatchling cannot know about the wheel: its platform, and the links of its page in a registry."""

import os
import platform
import re
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface


class CustomBuildHook(BuildHookInterface):
    """The wheel has what `cradle.py wheel` has put into target/wheel, and is for this machine."""

    def initialize(self, _version: str, build_data: dict[str, Any]) -> None:
        """Called before the files are gathered. Raises FileNotFoundError."""
        built = Path(self.root, "target/wheel/package/NewtonsCradle.fmu")  # made after the program
        if not built.exists():
            raise FileNotFoundError(f"{built} is missing: `python3 cradle.py wheel` makes it and the wheel")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{os.environ.get('CRADLE_WHEEL_PLATFORM') or this_platform()}"


class CustomMetadataHook(MetadataHookInterface):
    """README.md with links that lead to the site of the documents, and for the rest into the repository."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Called when the metadata are gathered."""
        # hatchling runs this file by its path, where nothing of the project can be imported.
        links = SimpleNamespace(**runpy.run_path(str(Path(self.root, "checkout/links.py"))))
        address = links.repository(Path(self.root))
        site = links.site(address)

        def leads(link: str, picture: bool) -> str:
            page = re.fullmatch(r"docs/(.+)\.md(#.*)?", link)
            return f"{site}{page[1]}.html{page[2] or ''}" if page else links.in_repository(address, link, picture)

        text = links.relinked(Path(self.root, "README.md").read_text(encoding="utf-8"), leads)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        metadata["urls"] = {"Documentation": site, "Source": address}


def this_platform() -> str:
    """The platform tag of a program that was compiled on this machine, for it."""
    machine = platform.machine().lower()
    if sys.platform == "win32":
        return {"amd64": "win_amd64", "arm64": "win_arm64"}.get(machine, "win32")
    if sys.platform == "darwin":  # as old as rustc compiles for
        return "macosx_11_0_arm64" if machine == "arm64" else "macosx_10_12_x86_64"
    library, version = platform.libc_ver()
    # What is compiled here needs no newer library than the one that is here.
    return f"manylinux_{version.replace('.', '_')}_{machine}" if library == "glibc" else f"linux_{machine}"
