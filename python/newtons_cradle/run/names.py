"""Names of variables: elements of arrays, and suggestions for names that do not exist."""

import difflib
import re
from collections.abc import Iterable


def split(name: str) -> tuple[str, int | None]:
    """x[3] as ("x", 3), any other name as (name, None)."""
    match = re.fullmatch(r"(.+)\[(-?\d+)\]", name)
    return (match[1], int(match[2])) if match else (name, None)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`; did you mean a or b?`: up to three known names that are similar, whole or after their dot, the best first."""
    by_form: dict[str, str] = {}
    for other in known:
        by_form.setdefault(other.lower().rpartition(".")[2], other)
        by_form[other.lower()] = other
    close = difflib.get_close_matches(name.lower(), by_form, n=5, cutoff=0.7)
    meant = list(dict.fromkeys(by_form[form] for form in close))[:3]
    return f"; did you mean {' or '.join(meant)}?" if meant else ""
