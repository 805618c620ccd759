"""What the figure scripts share: the command line, checks, CSV files and one look for all pictures."""

import argparse
import csv
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

import newtons_cradle as nc  # noqa: E402

#: One colour per ball or contact, from left to right; told apart by colour-blind eyes as well.
COLOURS = ["#0b5394", "#d1495b", "#2a9d60", "#8e5ea2", "#c77d0a"]
INK, FAINT = "#222222", "#8a8a8a"


@dataclass(frozen=True)
class Check:
    """One claim held against the FMU: what was measured, what is required, and whether it holds."""

    figure: str
    what: str
    measured: str
    required: str
    holds: bool


def within(figure: str, what: str, value: float, wanted: float, tolerance: float, unit: str = "") -> Check:
    """A number that must lie within an absolute tolerance of a known one."""
    digits = max(4, int(np.ceil(-np.log10(tolerance / max(abs(wanted), tolerance)))) + 3)
    shown = f"{value:.{digits}g} {unit}".strip()
    required = f"{wanted:.{digits}g} ± {tolerance:.0e} {unit}".strip()
    return Check(figure, what, shown, required, bool(abs(value - wanted) <= tolerance))


def at_most(figure: str, what: str, value: float, limit: float, unit: str = "") -> Check:
    """An error that must not exceed a limit."""
    measured, required = f"{value:.1e} {unit}".strip(), f"<= {limit:.0e} {unit}".strip()
    return Check(figure, what, measured, required, bool(value <= limit))


def equal(figure: str, what: str, value, wanted) -> Check:
    """Something that must come out exactly so."""
    return Check(figure, what, str(value), str(wanted), bool(value == wanted))


def print_checks(checks: list[Check]) -> bool:
    """Prints the table of checks; True when all hold."""
    rows = [("figure", "what", "measured", "required", "")]
    rows += [(c.figure, c.what, c.measured, c.required, "holds" if c.holds else "FAILS") for c in checks]
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    for i, row in enumerate(rows):
        print("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
        if i == 0:
            print("  " + "  ".join("-" * width for width in widths))
    return all(c.holds for c in checks)


def save_checks(checks: list[Check], path: Path) -> None:
    """Writes the table of checks as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["figure", "what", "measured", "required", "holds"])
        table.writerows([c.figure, c.what, c.measured, c.required, int(c.holds)] for c in checks)


def save_csv(path: Path, table: np.ndarray) -> None:
    """Writes a structured array as CSV: quoted names, 17 digits, Booleans as 0 and 1, SI units.

    The layout is the one FMPy's `read_csv` and the FMI cross-check use.
    """
    with path.open("w", newline="", encoding="ascii") as file:
        file.write(",".join(f'"{name}"' for name in table.dtype.names) + "\n")
        for row in table:
            cells = (f"{value:.17g}" if isinstance(value, float) else f"{value:d}" for value in row.item())
            file.write(",".join(cells) + "\n")


def command_line(description: str, **extra) -> argparse.Namespace:
    """The options that all figure scripts have: `--fmu`, `--out`. `extra`: name to (default, help)."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--fmu", type=Path, default=ROOT / "target/fmu/NewtonsCradle.fmu")
    parser.add_argument("--out", type=Path, default=ROOT / "out/paper", help="folder for CSV and pictures")
    for name, (default, text) in extra.items():
        text = f"{text} (default {default})"
        parser.add_argument(f"--{name}", type=type(default), default=default, help=text)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    return options


def run_script(run, description: str, **extra) -> None:
    """Runs one figure from the command line and ends with code 1 when a number does not hold."""
    options = command_line(description, **extra)
    more = {name: getattr(options, name) for name in extra}
    with nc.Fmu(options.fmu) as fmu:
        checks = run(fmu, options.out, **more)
    sys.exit(0 if print_checks(checks) else 1)


def stacked(rows: int, title: str, *, height: float = 1.25, columns: int = 1):
    """A figure of narrow strips that share their time axis, with a title; returns (figure, axes)."""
    plt.rcParams.update(
        {
            "font.family": "DejaVu Sans",
            "font.size": 9,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": FAINT,
            "axes.labelcolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "axes.grid": True,
            "grid.color": "#e6e6e6",
            "grid.linewidth": 0.6,
            "lines.linewidth": 1.3,
        }
    )
    figure, axes = plt.subplots(
        rows, columns, figsize=(9.0, 1.6 + height * rows), sharex="col", squeeze=False, layout="constrained"
    )
    figure.suptitle(title, fontsize=12, fontweight="bold", color=INK, x=0.01, ha="left")
    return figure, axes


def finish(figure, path: Path, caption: str) -> None:
    """Puts the caption (one paragraph, wrapped here) below the strips and writes the PNG."""
    figure.supxlabel(
        textwrap.fill(caption, 150), fontsize=8.5, color="#444444", x=0.01, ha="left", linespacing=1.5
    )
    figure.savefig(path, dpi=130)
    plt.close(figure)
    print(f"  wrote {shorter(path)}")


def shorter(path: Path) -> Path:
    """The path as seen from the checkout, where it lies in it."""
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
