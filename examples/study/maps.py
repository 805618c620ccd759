"""The study as maps: order to the right, dead band upwards, a map for each damping and number of lifted balls."""

import textwrap
from pathlib import Path

import numpy as np
import pandas as pd
from plots import plt

QUANTITIES = {  # column: (title, colour map)
    "overlap": ("impulse shared by neighbouring pulses", "viridis"),
    "last_ball": ("energy in the last ball after the first click", "magma"),
    "middle_ball": ("middle ball's swing / amplitude, after 10 s", "cividis"),
}


def save_maps(path: Path, rows: pd.DataFrame) -> None:
    """Draws the rows of a study; cells without a successful run stay grey."""
    plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "axes.facecolor": "#d0d0d0"})
    cases = list(rows.groupby(["lifted", "damping"]))
    size = (1.4 + 2.3 * len(cases), 0.6 + 2.3 * len(QUANTITIES))
    shape = {"sharex": True, "sharey": True, "squeeze": False, "layout": "constrained", "figsize": size}
    figure, axes = plt.subplots(len(QUANTITIES), len(cases), **shape)
    for (name, (title, colours)), line in zip(QUANTITIES.items(), axes, strict=True):
        for (_, chosen), axis in zip(cases, line, strict=True):
            cells = chosen.pivot(index="dead_band", columns="order", values=name)
            scale = {"cmap": colours, "vmin": 0.0, "vmax": rows[name].max()}
            shown = axis.pcolormesh(_edges(cells.columns), _edges(cells.index), cells, **scale)
        line[0].set_ylabel("dead band / µm")
        figure.colorbar(shown, ax=list(line), label=textwrap.fill(title, 28))
    for ((lifted, damping), _), top, bottom in zip(cases, axes[0], axes[-1], strict=True):
        top.set_title(f"{lifted} lifted, damping {damping:g} s/m", fontsize=9)
        bottom.set_xlabel("order p")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _edges(centres: pd.Index) -> np.ndarray:
    """Edges of cells around rising centres; a single centre gets a cell of width 1."""
    around = (
        np.pad(centres, 1, "reflect", reflect_type="odd") if len(centres) > 1 else centres[0] + [-1, 0, 1]
    )
    return np.convolve(around, [0.5, 0.5], "valid")
