"""What mkdocs does for the site besides: pages that are made of something else than docs, and links that leave docs."""

import posixpath
import re
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Link, Navigation
from mkdocs.structure.pages import Page
from newtons_cradle import NAMES

from checkout import ROOT, links
from checkout.site import PARTS

ADDRESS = links.repository(ROOT)
LIVE = PARTS / "cradle.html"
# Pages that are files of the repository outside docs.
ALSO = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
# Modules of which more than their names in `newtons_cradle` is for users.
MODULES = ("testing",)
STAGE = """<iframe class="stage" src="cradle.html" title="The cradle, live"></iframe>

Pull a ball aside and let it go, here or [in a window of its own](cradle.html). [The page](page.md) says what else it can do.

"""


def on_config(config: MkDocsConfig) -> None:
    """The site's address follows from the repository's."""
    config.site_url = links.site(ADDRESS)


def on_files(files: Files, *, config: MkDocsConfig) -> None:
    """Adds the pages made here, and what lies ready in PARTS."""
    pages = {name: (ROOT / path).read_text(encoding="utf-8") for path, name in ALSO.items()}
    for name, text in {**pages, "variables.md": variables(), "reference.md": reference()}.items():
        files.append(File.generated(config, name, content=text))
    for path in PARTS.rglob("*"):
        if path.is_file():
            files.append(File(path.relative_to(PARTS).as_posix(), PARTS, config.site_dir, False))


def on_nav(nav: Navigation, **_: Any) -> None:
    """The last part ends with the repository."""
    nav.items[-1].children.append(Link("Sources", ADDRESS))


def variables() -> str:
    """The tables of the FMU's own page."""
    page = (PARTS / "fmu.html").read_text(encoding="utf-8")
    tables = page[page.index('<h2 id="parameters">') : page.index('<h2 id="log">')]
    headed = re.sub(r'<h2 id="(\w+)">(.*?)</h2>\n', r"## \2 { #\1 }\n\n", tables)
    return f"""# Variables

What can you set in the cradle, and what does it tell? The variables of the FMU of FMI 2.0 with five balls, with unit,
start value, allowed range and meaning. `[i]` stands for a ball, or for the contact of balls i and i + 1, counted from
1 on the left. [The FMU's page](fmu.html) has the equations as well.

{headed}"""


def reference() -> str:
    """The public names of the Python package by the modules that they come from, and MODULES, by their docstrings."""
    text = """# Python reference

What `import newtons_cradle as nc` brings: `build` is `nc.build`. [Python](python.md) tells how to begin.
"""
    for module, names in NAMES.items():
        text += f"\n## {module.capitalize()}\n\n" + "".join(f"::: newtons_cradle.{name}\n\n" for name in names)
    return text + "".join(f"\n## {module.capitalize()}\n\n::: newtons_cradle.{module}\n" for module in MODULES)


def on_page_markdown(text: str, *, page: Page, **_: Any) -> str:
    """Links lead to other pages of the site or into the repository; the live page takes the place of its picture."""
    here = page.file.src_uri
    home = next((path for path, name in ALSO.items() if name == here), f"docs/{here}")

    def leads(link: str, picture: bool) -> str:
        path, mark, anchor = link.partition("#")
        target = posixpath.normpath(posixpath.join(posixpath.dirname(home), path))
        if target not in ALSO and not target.startswith("docs/"):
            return links.in_repository(ADDRESS, target, picture) + mark + anchor
        place = ALSO.get(target, target.removeprefix("docs/"))
        if place == LIVE.name and not LIVE.exists():
            place, mark, anchor = "page.md", "", ""  # how to get it
        return posixpath.relpath(place, posixpath.dirname(here) or ".") + mark + anchor

    if here == "changelog.md":  # what it tells stands elsewhere as well
        page.meta["search"] = {"exclude": True}
    if here == "index.md" and LIVE.exists():
        page.meta["hide"] = ["toc"]
        text = re.sub(r"(?ms)^!\[.*?\n\n", STAGE, text, count=1)
    return indented(links.relinked(text, leads))


def indented(text: str) -> str:
    """A document in which what belongs to an item of a list is indented by four spaces, as Python's Markdown wants it,
    not as far as the item's text; an empty line ends an item that has one within."""
    lines, begin, more, fenced = [], 0, "", False
    for line in text.split("\n"):
        fenced ^= line.startswith("```")
        if line and not line.startswith(" "):
            item = re.match(r"(-|\d+\.) +", line)
            if item and more and "" in lines[begin:]:
                lines.append("")
            more, begin = " " * (4 - len(item[0])) if item and not fenced else "", len(lines)
        lines.append(more + line if line.startswith(" ") else line)
    return "\n".join(lines)
