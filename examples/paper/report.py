"""The report: all plots, interactive, and the table of checks as one HTML file that needs no network."""

import json
from html import escape
from pathlib import Path

import numpy as np
from newtons_cradle.files import PAGE
from newtons_cradle.page import filled, packed
from plots import COLOURS, Plot, Trace
from support import Check, nc

ASSETS = Path(__file__).parent / "report"


def save_report(path: Path, plots: list[Plot], checks: list[Check], cradle: Path) -> None:
    """Writes the report; `cradle`: the page beside it, to which it links."""
    places: dict[str, int] = {}
    figures = json.dumps(plots, default=lambda part: told(part, places))
    contents = [f'<li><a href="#{plot.name}">{escape(plot.title)}</a></li>' for plot in plots]
    sources = ASSETS / "report.css", PAGE / "view/common.js", ASSETS / "charts.js"
    style, common, charts = (path.read_text(encoding="utf-8") for path in sources)
    parts = {
        "style": nc.look.STYLE + style,
        "script": common + charts,
        "cradle": escape(cradle.name),
        "holding": str(sum(check.holds for check in checks)),
        "checks": str(len(checks)),
        "contents": "\n".join(contents),
        "figures": "\n".join(map(section, plots)),
        "rows": "\n".join(map(row, checks)),
        "data": f'{{"figures": {figures}, "arrays": [{", ".join(places)}]}}'.replace("<", "\\u003c"),
    }
    path.write_text(filled(ASSETS / "template.html", parts), encoding="utf-8")


def told(part: object, places: dict[str, int]) -> dict:
    """A plot, or a part of it, as the script reads it. `places`: collects the arrays, each once, with their numbers."""

    def place(array: np.ndarray, kind: str) -> int:
        return places.setdefault(json.dumps(packed({"": array}, kind)), len(places))

    if isinstance(part, Plot):
        return {"name": part.name, "height": round(part.height * 80), "columns": part.columns}
    if isinstance(part, Trace):  # x needs all digits, because one can zoom in
        points = {"x": place(part.x, "f8"), "y": place(part.y, "f4")}
        # The name of a colour that differs on dark pages, else the colour.
        series = COLOURS.index(part.colour) + 1 if part.colour in COLOURS else None
        return vars(part) | points | {"colour": f"--series-{series}" if series else part.colour}
    return vars(part)


def section(plot: Plot) -> str:
    """The section for a plot: a place for its charts, its caption, and links to its files."""
    names = ", ".join(f'<a href="{escape(name)}">{escape(name)}</a>' for name in plot.files)
    links = f'\n<p class="files">Numbers: {names}</p>' if names else ""
    return (
        f'<section id="{plot.name}"><h2>{escape(plot.title)}</h2>\n'
        f'<div class="charts"></div>\n<p class="caption">{escape(plot.caption)}</p>{links}</section>'
    )


def row(check: Check) -> str:
    """A line of the table of checks."""
    verdict = '<td class="holds">agrees</td>' if check.holds else '<td class="fails">DIFFERS</td>'
    return (
        f"<tr><td>{escape(check.figure)}</td><td>{escape(check.what)}</td>"
        f'<td class="number" data-name="measured">{escape(check.measured)}</td>'
        f'<td class="number" data-name="required">{escape(check.required)}</td>{verdict}</tr>'
    )
