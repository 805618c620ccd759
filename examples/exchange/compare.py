"""The paper in a host's own solver: Figures 5 and 6 in FMPy's CVODE, resolved and mapped, beside co-simulation.

    python examples/exchange/compare.py [--fmu FILE] [--out FOLDER]

Prints a table and writes it, with a plot of the energy error over the cost, into the folder (out/exchange). The cost
is counted in evaluations: of the derivatives, which the host asks for, or of the contact forces within the FMU.
"""

import math
import sys
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.simulation import instantiate_fmu

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

from plots import diagrams
from support import command_line, ended, nc, parsed, print_rows, write_rows

TOLERANCES = {  # model exchange by its exchange.contacts, and co-simulation
    "resolved": [10.0**-k for k in range(4, 13)],
    "mapped": [10.0**-k for k in range(4, 14)],
    "co-simulation": [10.0**-k for k in (6, 8, 10, 12)],
}
PULSES = [f"pulses[{i}]" for i in range(1, 5)]
FIGURES = {"Figure 5": nc.figure5(), "Figure 6": nc.preset("figure6")}


def run(fmu: nc.Fmu, way: str, values: dict, tolerance: float) -> dict:
    """One run: its relative energy error, its cost, and its pulses."""
    exchange = way != "co-simulation"
    kind = "ModelExchange" if exchange else "CoSimulation"
    instance = instantiate_fmu(fmu.folder, fmu.description, kind)
    evaluations = 0
    if exchange:
        derivatives = instance.getDerivatives

        def counted(*arguments):
            nonlocal evaluations
            evaluations += 1
            return derivatives(*arguments)

        instance.getDerivatives = counted
    own = {"exchange.contacts": way} if exchange else {"solver.tolerance": tolerance}
    begin = time.perf_counter()
    try:
        result = fmpy.simulate_fmu(
            fmu.folder,
            model_description=fmu.description,
            fmu_instance=instance,
            fmi_type=kind,
            start_values=fmu.settings(values | own),
            stop_time=10.0,
            output_interval=0.01,
            relative_tolerance=tolerance if exchange else None,
            output=["E_total", "E_residual", *PULSES, "solver.evaluations"],
            record_events=False,
        )
    except RuntimeError:
        # CVODE gives up after 500 steps within one interval of the output.
        return {"error": math.nan, "evaluations": evaluations, "seconds": math.nan, "pulses": ()}
    finally:
        instance.freeInstance()
    return {
        "error": abs(float(result["E_residual"][-1] / result["E_total"][0])),
        "evaluations": evaluations or int(result["solver.evaluations"][-1]),
        "seconds": time.perf_counter() - begin,
        "pulses": tuple(int(result[name][-1]) for name in PULSES),
    }


def compare(path: Path) -> list[dict]:
    """All runs, as rows of the table. `verdict`: `right` if the pulses are those of co-simulation with the smallest
    tolerance, else `wrong`, or `gave up`."""
    fmu, rows = nc.Fmu(path), []
    ways = [(way, tolerance) for way, tolerances in TOLERANCES.items() for tolerance in tolerances]
    for figure, values in FIGURES.items():
        of_figure = []
        for way, tolerance in ways:
            row = {"figure": figure, "way": way, "tolerance": tolerance}
            of_figure.append(row | run(fmu, way, values, tolerance))
        for row in of_figure:
            verdict = "wrong" if row["pulses"] else "gave up"
            if row["pulses"] == of_figure[-1]["pulses"]:
                verdict = "right"
            rows.append(row | {"verdict": verdict})
    return rows


def save_plot(path: Path, rows: list[dict]) -> None:
    """Energy error over evaluations; hollow where pulses are wrong."""
    with diagrams(path, 4, sharey=True) as axes:
        for name, axis in zip(FIGURES, axes, strict=True):
            for way, colour in zip(TOLERANCES, ("#c04000", "#0060a0", "#208030"), strict=True):
                shown = [row for row in rows if (row["figure"], row["way"]) == (name, way) and row["pulses"]]
                cost, error = (np.array([row[of] for row in shown]) for of in ("evaluations", "error"))
                right = np.array([row["verdict"] == "right" for row in shown], dtype=bool)
                error = np.maximum(error, 1e-16)
                axis.loglog(cost, error, "-", color=colour, linewidth=1)
                axis.loglog(cost[right], error[right], "o", color=colour, label=way)
                if not right.all():
                    wrong = {"markerfacecolor": "white", "label": f"{way}, wrong pulses"}
                    axis.loglog(cost[~right], error[~right], "o", color=colour, **wrong)
            axis.set(title=name, xlabel="evaluations in 10 s")
        axes[0].set_ylabel("energy error / energy")
        axes[1].legend(fontsize=8)


def main() -> None:
    """Runs all comparisons, and writes table and plot."""
    options = parsed(command_line(__doc__.splitlines()[0], "exchange"))
    rows = compare(options.fmu)
    write_rows(options.out / "exchange.csv", rows)
    print_rows(rows)
    save_plot(options.out / "exchange.png", rows)


if __name__ == "__main__":
    ended(main)
