"""The study as maps: order to the right, dead band upwards, a map for each damping and number of lifted balls."""

import textwrap
from pathlib import Path

import numpy as np
from plots import plt

QUANTITIES = {  # column: (title, colour map)
    "overlap": ("impulse shared by neighbouring pulses", "viridis"),
    "last_ball": ("energy in the last ball after the first click", "magma"),
    "middle_ball": ("middle ball's swing / amplitude, after 10 s", "cividis"),
}


def save_maps(path: Path, rows: list[dict]) -> None:
    """Draws the rows of a study; cells without a successful run stay grey."""
    plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "axes.facecolor": "#d0d0d0"})
    cases = sorted({(row["lifted"], row["damping"]) for row in rows})
    size = (1.4 + 2.3 * len(cases), 0.6 + 2.3 * len(QUANTITIES))
    shape = {"sharex": True, "sharey": True, "squeeze": False, "layout": "constrained", "figsize": size}
    figure, axes = plt.subplots(len(QUANTITIES), len(cases), **shape)
    for (name, (title, colours)), line in zip(QUANTITIES.items(), axes, strict=True):
        largest = max(row[name] for row in rows)
        for (lifted, damping), axis in zip(cases, line, strict=True):
            chosen = [row for row in rows if (row["lifted"], row["damping"]) == (lifted, damping)]
            shown = _draw(axis, chosen, name, cmap=colours, vmin=0.0, vmax=largest)
        line[0].set_ylabel("dead band / µm")
        figure.colorbar(shown, ax=list(line), label=textwrap.fill(title, 28))
    for (lifted, damping), top, bottom in zip(cases, axes[0], axes[-1], strict=True):
        top.set_title(f"{lifted} lifted, damping {damping:g} s/m", fontsize=9)
        bottom.set_xlabel("order p")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw(axis, rows: list[dict], name: str, **colours):
    """One map: the cells of a rectangular grid."""
    orders, bands = (sorted({row[axis_name] for row in rows}) for axis_name in ("order", "dead_band"))
    values = np.full((len(bands), len(orders)), np.nan)
    for row in rows:
        values[bands.index(row["dead_band"]), orders.index(row["order"])] = row[name]
    return axis.pcolormesh(_edges(orders), _edges(bands), values, **colours)


def _edges(centres: list[float]) -> np.ndarray:
    """Edges of cells around rising centres; a single centre gets a cell of width 1."""
    middles = 0.5 * (np.array(centres[1:]) + np.array(centres[:-1]))
    first = 2 * centres[0] - middles[0] if len(middles) else centres[0] - 0.5
    last = 2 * centres[-1] - middles[-1] if len(middles) else centres[-1] + 0.5
    return np.array([first, *middles, last])
