"""Plots as data: strips of traces above a common axis, drawn as PNG here and by the report's script in a browser."""

import textwrap
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import newtons_cradle as nc
import numpy as np
from matplotlib.ticker import EngFormatter

ROOT = Path(__file__).resolve().parents[2]
#: One colour per ball or contact, from left to right; told apart by colour-blind eyes as well.
COLOURS = nc.look.SERIES
INK, SOFT, FAINT, GRID = (nc.look.COLOURS[name] for name in ("ink", "soft", "edge", "line"))


@dataclass(frozen=True)
class Trace:
    """A curve. `style`: line, area (filled down to 0), dashed or points."""

    x: np.ndarray
    y: np.ndarray
    colour: str = COLOURS[0]
    style: str = "line"
    label: str = ""


@dataclass(frozen=True)
class Strip:
    """One diagram: quantity, curves, its unit ("" for pure numbers), range of the axis (None: fitted)."""

    label: str
    traces: list[Trace]
    unit: str = ""
    limits: tuple[float, float] | None = None


@dataclass(frozen=True)
class Column:
    """Strips above each other that share a horizontal axis. `views`: ranges of this axis by the name of their button,
    the one shown at first in front. In the report, columns side by side have views of the same names."""

    strips: list[Strip]
    views: dict[str, tuple[float, float]]
    title: str = ""
    xlabel: str = "time"
    xunit: str = "s"


@dataclass(frozen=True)
class Plot:
    """A figure: columns side by side, all with as many strips, and a caption that says what to see. `height`: of a
    strip, in inches; `files`: CSV files with its numbers, in the folder of the report."""

    name: str
    title: str
    caption: str
    columns: list[Column]
    height: float = 1.25
    files: tuple[str, ...] = ()


def family(result, name: str, *, origin=0.0, limits=None, colours=COLOURS) -> list[Strip]:
    """A strip for each element of an array of a run, forces as areas; time counted from `origin` (s)."""
    time, style = result["time"] - origin, "area" if name == "F" else "line"
    elements = [f"{name}[{i}]" for i in range(1, result[name].shape[1] + 1)]
    return [
        Strip(element, [Trace(time, result[element], colour, style)], result.units[element], limits)
        for element, colour in zip(elements, colours, strict=False)
    ]


STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.5,
    "grid.color": GRID,
    "axes.edgecolor": FAINT,
} | dict.fromkeys(["axes.labelcolor", "axes.titlecolor", "xtick.color", "ytick.color"], INK)


def save_picture(plot: Plot, path: Path, **options) -> None:
    """Draws a plot with its title and caption and writes it, as PNG or what the path's suffix says."""
    plt.rcParams.update(STYLE)
    rows = len(plot.columns[0].strips)
    shape = {"sharex": "col", "squeeze": False, "layout": "constrained", "figsize": (9.0, 1.7 + plot.height * rows)}
    figure, axes = plt.subplots(rows, len(plot.columns), **shape)
    if plot.title:
        figure.suptitle(plot.title, fontsize=12, fontweight="bold", color=INK, x=0.01, ha="left")
    for column, strips in zip(plot.columns, axes.T, strict=True):
        _draw_column(column, strips)
    if plot.caption:
        look = {"fontsize": 8.5, "color": SOFT, "x": 0.01, "ha": "left", "linespacing": 1.5}
        figure.supxlabel(textwrap.fill(plot.caption, 150), **look)
    figure.savefig(path, dpi=130, **options)
    plt.close(figure)


@contextmanager
def diagrams(path: Path, height: float, **options):
    """Two diagrams side by side, for what a `Plot` cannot show, such as a logarithmic axis: yields their axes, and then
    writes the picture as PNG. `height`: in inches; `options`: those of `subplots`."""
    plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    figure, axes = plt.subplots(1, 2, figsize=(9, height), layout="constrained", **options)
    yield axes
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_column(column: Column, axes) -> None:
    view = next(iter(column.views.values()))
    for strip, axis in zip(column.strips, axes, strict=True):
        for trace in strip.traces:
            kind = {"points": "o", "dashed": "--"}.get(trace.style, "-")
            width = 0.9 if trace.style == "dashed" else None
            axis.plot(trace.x, trace.y, kind, color=trace.colour, label=trace.label or None, linewidth=width)
            if trace.style == "area":
                axis.fill_between(trace.x, trace.y, color=trace.colour, alpha=0.25, linewidth=0)
        axis.set(ylabel=strip.label, xlim=view, ylim=strip.limits)
        axis.yaxis.set_major_formatter(EngFormatter(strip.unit) if strip.unit else "{x:g}")
        axis.xaxis.set_major_formatter(EngFormatter(column.xunit) if column.xunit else "{x:g}")
        axis.yaxis.set_major_locator(plt.MaxNLocator(4))
        if any(trace.label for trace in strip.traces):
            axis.legend(frameon=False, fontsize=8)
    axes[0].set_title(column.title, fontsize=10, loc="left")
    axes[-1].set_xlabel(column.xlabel)
