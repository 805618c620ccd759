"""The common look of report, plots and the FMU's page: fonts, and colours with their meaning (look.css).

The producer puts look.css into the FMU's page, too.
"""

import re
from importlib.resources import files

STYLE = (files(__package__) / "look.css").read_text(encoding="utf-8")

#: Colours by name, `COLOURS["series-1"]`, as "#rrggbb", where pages are light.
COLOURS = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", STYLE.partition("@media")[0]))

#: Of balls or contacts, from left to right; told apart by colour-blind eyes as well.
SERIES = [COLOURS[f"series-{i}"] for i in range(1, 7)]
