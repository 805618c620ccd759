"""What the examples share: the command line, and results: checks, plots and CSV files."""

import argparse
import csv
import sys
import warnings
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from plots import ROOT, Column, Plot, nc, save_picture

warnings.simplefilter("ignore", nc.DoubtfulStart)  # the paper lifts linear pendulums by half of their length


@dataclass(frozen=True)
class Check:
    """One claim checked with the FMU: what was measured, what is required, and whether it holds."""

    figure: str
    what: str
    measured: str
    required: str
    holds: bool


class Found:
    """The results of experiments: checks of numbers, plots, and CSV files in the folder `out`."""

    def __init__(self, out: Path):
        out.mkdir(parents=True, exist_ok=True)
        self.out, self.checks, self.plots = out, [], []
        self._files: list[str] = []  # that the next plot links

    def _check(self, figure: str, what: str, measured: str, required: str, holds: bool) -> None:
        self.checks.append(Check(figure, what, measured.strip(), required.strip(), bool(holds)))

    def within(self, figure: str, what: str, value: float, wanted: float, tolerance: float, unit="") -> None:
        """A number that must lie within an absolute tolerance of a known one."""
        digits = max(4, int(np.ceil(-np.log10(tolerance / max(abs(wanted), tolerance)))) + 3)
        required = f"{wanted:.{digits}g} ± {tolerance:.0e} {unit}"
        self._check(figure, what, f"{value:.{digits}g} {unit}", required, abs(value - wanted) <= tolerance)

    def at_most(self, figure: str, what: str, value: float, limit: float, unit="") -> None:
        """An error that must not exceed a limit."""
        self._check(figure, what, f"{value:.1e} {unit}", f"<= {limit:.0e} {unit}", value <= limit)

    def at_least(self, figure: str, what: str, value: float, limit: float, unit="") -> None:
        """An effect that must be there."""
        self._check(figure, what, f"{value:.3g} {unit}", f">= {limit:.3g} {unit}", value >= limit)

    def between(self, figure: str, what: str, values, low: float, high: float, unit="") -> None:
        """Several numbers that must all lie in an interval."""
        first, last = min(values), max(values)
        measured, required = f"{first:.5f} to {last:.5f} {unit}", f"{low} to {high} {unit}"
        self._check(figure, what, measured, required, low <= first and last <= high)

    def equal(self, figure: str, what: str, value, wanted) -> None:
        """A value that must match exactly."""
        self._check(figure, what, str(value), str(wanted), value == wanted)

    def conserved(self, figure: str, result: nc.Result, speed: float) -> None:
        """Checks that energy is conserved over a run, and momentum over each impact sequence, relative to the momentum
        of 1 kg at `speed` (m/s)."""
        error, defect = nc.energy_error(result), np.abs(nc.momentum_of_sequences(result)).max()
        self.at_most(figure, f"energy error over {result['time'][-1]:g} s", error, 1e-10)
        self.at_most(figure, "momentum defect per sequence / m v", defect / speed, 1e-12)

    def save(self, name: str, table: np.ndarray) -> None:
        """Writes a structured array as CSV: quoted names, 17 digits, Booleans as 0 and 1, SI units. The next plot
        links it.

        The layout is the one FMPy's `read_csv` and the FMI cross-check use.
        """
        forms = ["%.17g" if table.dtype[column].kind == "f" else "%d" for column in table.dtype.names]
        head = ",".join(f'"{column}"' for column in table.dtype.names)
        np.savetxt(self.out / name, table, forms, ",", header=head, comments="", encoding="ascii")
        self._files.append(name)

    def save_rows(self, name: str, rows: list[dict]) -> None:
        """Writes rows of texts and numbers as CSV. The next plot links it."""
        write_rows(self.out / name, rows)
        self._files.append(name)

    def plot(self, name: str, title: str, caption: str, columns: list[Column], height: float = 1.25) -> None:
        """Draws a plot as PNG, and links it to the files saved since the last plot."""
        self.plots.append(Plot(name, title, caption, columns, height, tuple(self._files)))
        self._files.clear()
        path = self.out / f"{name}.png"
        save_picture(self.plots[-1], path)
        print(f"  wrote {shorter(path)}")

    def conclude(self) -> bool:
        """Prints the table of checks, and writes it as checks.csv; returns True if all pass."""
        rows = [asdict(check) for check in self.checks]
        print_rows([row | {"holds": "agrees" if row["holds"] else "DIFFERS"} for row in rows])
        self.save_rows("checks.csv", [row | {"holds": int(row["holds"])} for row in rows])
        return all(check.holds for check in self.checks)


def write_rows(path: Path, rows: list[dict]) -> None:
    """Writes rows of texts and numbers as CSV, with all digits; None stays empty."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)


def print_rows(rows: list[dict], digits: int = 3) -> None:
    """Prints rows of texts and numbers as a table."""
    table = [[f"{cell:.{digits}g}" if isinstance(cell, float) else str(cell) for cell in row.values()] for row in rows]
    widths = [max(map(len, column)) for column in zip(rows[0], *table, strict=True)]
    for row in (rows[0], ["-" * width for width in widths], *table):
        line = "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print(f"  {line}".rstrip())


def tracked(label: str, items, count: int | None = None):
    """Yields the items; a bar shows how many of them, or of `count`, are done."""
    progress = nc.Progress(label)
    for number, item in enumerate(items, start=1):
        yield item
        progress(number / (count or len(items)))


def command_line(description: str, out: str, fmu: str = "NewtonsCradle.fmu") -> argparse.ArgumentParser:
    """A parser with the options that all examples have: `--fmu`, by default this FMU in target/fmu, and `--out`, by
    default this folder in out/."""
    form, place = argparse.RawDescriptionHelpFormatter, f"target/fmu/{fmu}"
    parser = argparse.ArgumentParser(description=description, formatter_class=form)
    parser.add_argument("--fmu", type=Path, default=ROOT / place, help=f"FMU [default: {place}]")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / out, help="folder for CSV and pictures")
    return parser


def ended(main: Callable[[], int | None]) -> None:
    """Runs a script's main function and ends the script; if an FMU or a file is refused, it prints one sentence."""
    try:
        sys.exit(main())
    except (OSError, nc.CradleError) as problem:
        sys.exit(f"error: {problem}")


def parsed(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """The options of the command line, with the folder made. Ends the script if there is no such FMU."""
    options = parser.parse_args()
    if not options.fmu.exists():
        fmi = " --fmi 3" if ".fmi3." in parser.get_default("fmu").name else ""
        sys.exit(f"{options.fmu} is missing: build it with `cargo pack build --release{fmi}`")
    options.out.mkdir(parents=True, exist_ok=True)
    return options


@contextmanager
def opened(options: argparse.Namespace):
    """The FMU of the command line, and one of 13 balls with its binaries, by the number of balls."""
    with nc.Fmu(options.fmu) as five:
        five.require(balls=5)
        with nc.build(balls=13, binaries=options.fmu) as thirteen:
            yield {5: five, 13: thirteen}


def shorter(path: Path) -> Path:
    """The path relative to the checkout, if it lies in it."""
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
