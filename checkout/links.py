"""Where relative links of a document lead once it is shown elsewhere than in the repository.

packaging/wheel_hook.py runs this file by its path: it imports nothing of this project."""

import re
from collections.abc import Callable
from pathlib import Path

LINK = re.compile(r"(!?\[[^]]*]\()(?!https?:|#)([^)\s]+)")


def repository(root: Path) -> str:
    """The repository's address, that of the README's line `git clone`."""
    address = re.search(r"git clone (\S+)", (root / "README.md").read_text(encoding="utf-8"))[1]
    return address.rstrip("/").removesuffix(".git")


def site(address: str) -> str:
    """The address at which the repository with this address publishes its site."""
    owner, name = address.split("/")[-2:]
    return f"https://{owner}.github.io/{name}/"


def in_repository(address: str, path: str, picture: bool = False) -> str:
    """The address of a file of the repository: as it is shown there, or of a picture itself."""
    return f"{address}/{'raw' if picture else 'blob'}/HEAD/{path}"


def relinked(text: str, leads: Callable[[str, bool], str]) -> str:
    """A document in Markdown whose relative links are what `leads` makes of each, and of whether it is a picture's."""
    return LINK.sub(lambda found: found[1] + leads(found[2], found[1].startswith("!")), text)
