"""The errors of this package: one family, `CradleError`. Their messages say what was wrong and what is allowed."""

import math
import operator
import sys
import warnings
from collections.abc import Iterable
from importlib import import_module
from typing import Any

MOST_BALLS = 10_000  # of a cradle
MOST_STEPS = 100_000_000  # of one run: their samples alone are gigabytes


class CradleError(Exception):
    """Something was refused, or is missing."""


class FmuError(CradleError, RuntimeError):
    """The FMU refused something, or is itself refused."""


class InvalidValue(CradleError, ValueError):
    """An argument of a function of this package is refused."""


class UnknownName(CradleError, KeyError):
    """A name that no variable has; the message names similar ones, or those that exist."""

    def __str__(self) -> str:
        return str(self.args[0])


class FileMissing(CradleError, FileNotFoundError):
    """A file is not there."""


class PackageMissing(CradleError, ImportError):
    """A Python package is missing that an extra of this one installs."""


class DoubtfulStart(UserWarning):
    """Start values that the FMU accepts, but that are hardly ever meant: balls pressed into each other by a wrong sign,
    swings too wide for linear pendulums, or parameters that have no effect with the others."""


def warn(text: str) -> None:
    """Warns about doubtful start values, at the line outside this package that gave them."""
    frame, level = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").startswith(f"{__package__}."):
        frame, level = frame.f_back, level + 1
    warnings.warn(text, DoubtfulStart, stacklevel=level)


def plain(value: Any) -> Any:
    """The Python number in a NumPy scalar or an array without dimensions; anything else as it is."""
    return value.item() if getattr(value, "shape", None) == () and hasattr(value, "item") else value


def shown(value: Any) -> str:
    """A value as text for a message, cut after 80 characters."""
    try:
        text = repr(value)
    except ValueError:  # an integer with more digits than Python converts
        text = "an integer of thousands of digits"
    return text if len(text) <= 80 else f"{text[:80]}..."


def number(
    name: str, value: Any, unit: str = "", *, positive: bool = False, least: float = -math.inf, most: float = math.inf
) -> float:
    """The value as a finite number, a positive one if wanted, from `least` to `most`. Raises InvalidValue."""
    given = plain(value)
    try:
        real = not isinstance(given, bool | str | bytes) and math.isfinite(given)
    except (TypeError, ValueError, OverflowError):
        real = False
    if not real or (positive and not given > 0) or not least <= given <= most:
        ends = [f"at least {least:g}"] if least > -math.inf else []
        ends += [f"at most {most:g}"] if most < math.inf else []
        allowed = f"a {'positive' if positive else 'finite'} number{f' ({unit})' if unit else ''}"
        raise InvalidValue(f"{name} = {shown(value)} is refused; allowed: {', '.join([allowed, *ends])}")
    return float(given)


def whole(name: str, value: Any, least: int, most: int) -> int:
    """The value as a whole number from `least` to `most`. Raises InvalidValue."""
    given = plain(value)
    try:
        wrong = isinstance(given, bool) or not least <= operator.index(given) <= most
    except TypeError:
        wrong = True
    if wrong:
        raise InvalidValue(f"{name} = {shown(value)} is refused; allowed: a whole number from {least} to {most}")
    return operator.index(given)


def needed(what: str, value: Any, kind: Any, example: str) -> None:
    """Raises InvalidValue unless the value is of type `kind`."""
    if not isinstance(value, kind):
        raise InvalidValue(f"{what}: {example} is needed, not {shown(value)}")


def optional(package: str, extra: str) -> Any:
    """Imports a package of an extra, or a module of it. Raises PackageMissing, which names both."""
    name = package.partition(".")[0]  # the name for pip
    try:
        return import_module(package)
    except ImportError:
        advice = f"`pip install 'newtons-cradle[{extra}]'`, or `pip install {name}`"
        raise PackageMissing(f"{name} is needed but missing: {advice}", name=name) from None


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`; did you mean a or b?` with up to three similar names, the best first, or ""; the part after a dot may match
    alone."""
    import difflib  # only here, because it takes a while

    by_form: dict[str, str] = {}
    for other in known:
        by_form.setdefault(other.lower().rpartition(".")[2], other)
        by_form[other.lower()] = other
    close = difflib.get_close_matches(name.lower(), by_form, n=5, cutoff=0.7)
    meant = list(dict.fromkeys(by_form[form] for form in close))[:3]
    return f"; did you mean {' or '.join(meant)}?" if meant else ""
