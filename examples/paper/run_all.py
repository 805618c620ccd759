"""All experiments of the paper in one go: pictures, CSV, an interactive report, a page that plays a run, checks."""

import dead_band
import figure3
import figure4
import figure5
import figure6
import hertz
import stiffness
from newtons_cradle.page import save_page
from newtons_cradle.views import from_fmu
from report import save_report
from support import Found, command_line, ended, nc, opened, parsed, shorter

EXPERIMENTS = [figure3, figure4, figure5, figure6, dead_band, stiffness, hertz]


def main() -> int:
    """Runs the experiments; returns 0 if every check passes, else 1."""
    parser = command_line(__doc__, "paper")
    known = {experiment.__name__: experiment for experiment in EXPERIMENTS}
    parser.add_argument("--only", nargs="+", choices=known, default=list(known), help="some experiments")
    options = parsed(parser)
    found = Found(options.out)
    with opened(options) as fmus:
        for number, name in enumerate(options.only, start=1):
            print(f"[{number}/{len(options.only)}] {known[name].__doc__}")
            known[name].run(fmus, found)
        page = options.out / "cradle.html"
        save_page(page, from_fmu(fmus[5].path, nc.figure5()))
    save_report(options.out / "report.html", found.plots, found.checks, page)
    print("\nMeasured on this machine, through FMPy:\n")
    holds = found.conclude()
    print(f"\n{sum(c.holds for c in found.checks)} of {len(found.checks)} numbers agree.")
    print(f"Pictures and CSV files: {shorter(options.out)}")
    print(f"Open in a browser: {shorter(options.out / 'report.html')} and {shorter(page)}")
    return 0 if holds else 1


if __name__ == "__main__":
    ended(main)
