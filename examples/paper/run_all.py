"""All experiments of the paper in one go: pictures, CSV, an interactive report, a 3D animation, and a table of checks."""

import sys

import dead_band
import figure3
import figure4
import figure5
import figure6
import hertz
import overlap_order
import stiffness
import ten_minutes
from newtons_cradle.animation import from_fmu, save_page
from report import save_report
from support import command_line, draw, nc, opened, print_checks, save_checks, shorter

FIGURES = [figure3, figure4, figure5, figure6, ten_minutes, overlap_order, dead_band, stiffness, hertz]


def main() -> int:
    """Runs every figure; returns 0 if every check passes, else 1."""
    options = command_line(__doc__)
    outcomes = []
    with opened(options) as fmus:
        for number, figure in enumerate(FIGURES, start=1):
            print(f"[{number}/{len(FIGURES)}] {figure.__doc__}")
            outcomes.append(figure.run(fmus, options.out))
            draw(outcomes[-1], options.out)
        animation = options.out / "animation.html"
        save_page(animation, from_fmu(fmus.five.path, nc.figure5()))
    checks = [check for outcome in outcomes for check in outcome.checks]
    plots = [plot for outcome in outcomes for plot in outcome.plots]
    save_checks(checks, options.out / "checks.csv")
    save_report(options.out / "report.html", plots, checks, animation)
    print("\nMeasured on this machine, through FMPy:\n")
    holds = print_checks(checks)
    print(f"\n{sum(c.holds for c in checks)} of {len(checks)} numbers agree.")
    print(f"Pictures and CSV files: {shorter(options.out)}")
    print(f"Open in a browser: {shorter(options.out / 'report.html')} and {shorter(animation)}")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
