"""The report: all plots, interactive, and the table of checks as one HTML file that needs no network."""

import json
from html import escape
from pathlib import Path

import numpy as np
from newtons_cradle.files import PAGE
from newtons_cradle.page import filled, packed
from plots import COLOURS, Plot
from support import Check, nc

ASSETS = Path(__file__).parent / "report"


def save_report(path: Path, plots: list[Plot], checks: list[Check], cradle: Path) -> None:
    """Writes the report; `cradle`: the page beside it that it links."""
    places: dict[str, int] = {}  # of packed arrays: each is kept once
    figures = [figure(plot, places) for plot in plots]
    data = {"figures": figures, "arrays": [json.loads(array) for array in places]}
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
        "data": json.dumps(data).replace("<", "\\u003c"),
    }
    path.write_text(filled(ASSETS / "template.html", parts), encoding="utf-8")


def place(array: np.ndarray, kind: str, places: dict) -> int:
    """The number of an array among those kept; `kind`: f4, or f8 for times that are zoomed into."""
    return places.setdefault(json.dumps(packed({"": array}, kind)), len(places))


def figure(plot: Plot, places: dict) -> dict:
    """A plot as the script reads it."""

    def trace(trace) -> dict:
        points = {"x": place(trace.x, "f8", places), "y": place(trace.y, "f4", places)}
        # The name of a colour that dark pages have another one for, else the colour.
        series = COLOURS.index(trace.colour) + 1 if trace.colour in COLOURS else None
        return vars(trace) | points | {"colour": f"--series-{series}" if series else trace.colour}

    def strip(strip) -> dict:
        return vars(strip) | {"traces": list(map(trace, strip.traces))}

    def column(column) -> dict:
        views = [
            {"label": label, "left": left, "right": right} for label, (left, right) in column.views.items()
        ]
        return vars(column) | {"views": views, "strips": list(map(strip, column.strips))}

    return {"name": plot.name, "height": round(plot.height * 80), "columns": list(map(column, plot.columns))}


def section(plot: Plot) -> str:
    """Where the script puts a plot's charts, with its caption and the files with its numbers."""
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
