"""The common look of report, plots and the FMU's page: fonts, and colours with their meaning (look.css).

The producer puts look.css into the FMU's page, too.
"""

import re
from importlib.resources import files

import numpy as np

STYLE = (files(__package__) / "look.css").read_text(encoding="utf-8")

#: Colours by name, `COLOURS["series-1"]`, as "#rrggbb", where pages are light.
COLOURS = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", STYLE.partition("@media")[0]))

#: Of balls or contacts, from left to right; told apart by colour-blind eyes as well.
SERIES = [COLOURS[f"series-{i}"] for i in range(1, 7)]


def series(count: int) -> list[str]:
    """Colours of `count` balls or contacts: `SERIES`, or, where they are too few, colours between some of them."""
    if count <= len(SERIES):
        return SERIES[:count]
    stops = np.array([[int(SERIES[i][k : k + 2], 16) for k in (1, 3, 5)] for i in (0, 2, 4, 1)])
    places = np.linspace(0, 3, count)
    channels = [np.interp(places, range(4), column).round().astype(int) for column in stops.T]
    return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in zip(*channels, strict=True)]
