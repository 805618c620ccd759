"""All experiments of the paper that are rebuilt here, in one go: pictures, CSV and a table of checks."""

import sys

import figure4
import figure5
import figure6
from support import command_line, nc, print_checks, save_checks, shorter


def main() -> int:
    """Runs every figure; returns 0 when every number holds, else 1."""
    options = command_line(__doc__)
    checks = []
    with nc.Fmu(options.fmu) as fmu:
        for number, figure in enumerate((figure5, figure4, figure6), start=1):
            print(f"[{number}/3] {figure.__doc__}")
            checks += figure.run(fmu, options.out)
    save_checks(checks, options.out / "checks.csv")
    print("\nMeasured on this machine, through FMPy:\n")
    holds = print_checks(checks)
    print(
        f"\n{sum(c.holds for c in checks)} of {len(checks)} hold. Pictures and CSV files: {shorter(options.out)}"
    )
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
