"""What the figure scripts share: the command line, checks and CSV files."""

import argparse
import csv
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from plots import ROOT, Plot, nc, save_picture


@dataclass(frozen=True)
class Check:
    """One claim checked with the FMU: what was measured, what is required, and whether it holds."""

    figure: str
    what: str
    measured: str
    required: str
    holds: bool


@dataclass(frozen=True)
class Outcome:
    """What a figure script found: the checks of its numbers, and its plots."""

    checks: list[Check]
    plots: list[Plot]


@dataclass(frozen=True)
class Fmus:
    """The FMUs that the figures need: one of five balls, one of 13."""

    five: nc.Fmu
    thirteen: nc.Fmu


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


def at_least(figure: str, what: str, value: float, limit: float, unit: str = "") -> Check:
    """An effect that must be there."""
    measured, required = f"{value:.3g} {unit}".strip(), f">= {limit:.3g} {unit}".strip()
    return Check(figure, what, measured, required, bool(value >= limit))


def between(figure: str, what: str, values, low: float, high: float, unit: str = "") -> Check:
    """Several numbers that must all lie in an interval."""
    first, last = min(values), max(values)
    measured, required = f"{first:.5f} to {last:.5f} {unit}", f"{low} to {high} {unit}"
    return Check(figure, what, measured.strip(), required.strip(), bool(low <= first and last <= high))


def conserved(figure: str, result: nc.Result, speed: float) -> list[Check]:
    """Energy over a run, and momentum over each impact sequence relative to that of 1 kg at `speed` (m/s)."""
    defect = np.abs(nc.momentum_of_sequences(result)).max() / speed
    seconds = result["time"][-1]
    return [
        at_most(figure, f"energy error over {seconds:g} s", nc.energy_error(result), 1e-10),
        at_most(figure, "momentum defect per sequence / m v", defect, 1e-12),
    ]


def equal(figure: str, what: str, value, wanted) -> Check:
    """A value that must match exactly."""
    return Check(figure, what, str(value), str(wanted), bool(value == wanted))


def print_checks(checks: list[Check]) -> bool:
    """Prints the table of checks; returns True if all pass."""
    rows = [("figure", "what", "measured", "required", "")]
    rows += [(c.figure, c.what, c.measured, c.required, "agrees" if c.holds else "DIFFERS") for c in checks]
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


def command_line(description: str) -> argparse.Namespace:
    """The options that all figure scripts have: `--fmu`, `--fmu13`, `--out`."""
    built = ROOT / "target/fmu"
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--fmu", type=Path, default=built / "NewtonsCradle.fmu", help="FMU of five balls")
    parser.add_argument("--fmu13", type=Path, default=built / "NewtonsCradle13.fmu", help="FMU of 13 balls")
    parser.add_argument("--out", type=Path, default=ROOT / "out/paper", help="folder for CSV and pictures")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    return options


@contextmanager
def opened(options: argparse.Namespace):
    """The FMUs of the command line, unpacked. Ends the script if one is missing or has the wrong number of balls."""
    try:
        with nc.Fmu(options.fmu) as five, nc.Fmu(options.fmu13) as thirteen:
            for fmu, balls in ((five, 5), (thirteen, 13)):
                fmu.require(balls=balls)
            yield Fmus(five, thirteen)
    except nc.FmuError as problem:
        sys.exit(f"error: {problem}")
    except FileNotFoundError as problem:
        sys.exit(
            f"error: {problem} (13 balls: `cargo pack build --release --balls 13 --out target/fmu/NewtonsCradle13.fmu`)"
        )


def draw(outcome: Outcome, out: Path) -> None:
    """Writes a PNG for each plot."""
    for plot in outcome.plots:
        path = out / f"{plot.name}.png"
        save_picture(plot, path)
        print(f"  wrote {shorter(path)}")


def run_script(run, description: str) -> None:
    """Runs one figure from the command line; the exit code is 1 if a check fails."""
    options = command_line(description)
    with opened(options) as fmus:
        outcome = run(fmus, options.out)
    draw(outcome, options.out)
    sys.exit(0 if print_checks(outcome.checks) else 1)


def shorter(path: Path) -> Path:
    """The path relative to the checkout, if it lies in it."""
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
