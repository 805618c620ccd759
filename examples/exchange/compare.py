"""The paper in a host's own solver: Figures 5 and 6 by model exchange in FMPy's CVODE, resolved and mapped, beside co-simulation.

    python examples/exchange/compare.py [--fmu FILE] [--out FOLDER] [--stop SECONDS]

Prints a table and writes it, with a plot of the energy error over the cost, into the folder (out/exchange). The cost is counted in
evaluations: of the derivatives, which the host asks for, or of the contact forces within the FMU.
"""

import argparse
import csv
import sys
import time
from pathlib import Path

import fmpy
from fmpy.simulation import instantiate_fmu

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

import newtons_cradle as nc  # noqa: E402

RESOLVED, MAPPED = 1, 2  # exchange.contacts
TOLERANCES = {
    "resolved": [10.0**-k for k in range(4, 13)],
    "mapped": [10.0**-k for k in range(4, 14)],
    "co-simulation": [10.0**-k for k in (6, 8, 10, 12)],
}
PULSES = [f"pulses[{i}]" for i in range(1, 5)]
WORK = ["solver.steps", "solver.evaluations"]
COLUMNS = ["figure", "way", "tolerance", "error", "evaluations", "seconds", "pulses"]


class Unpacked:
    """An FMU, unpacked once for all runs."""

    def __init__(self, path: Path) -> None:
        self.folder = fmpy.extract(str(path))
        self.description = fmpy.read_model_description(self.folder)

    def run(self, way: str, values: dict, tolerance: float, stop: float) -> dict:
        """One run: its relative energy error, its cost, and its pulses."""
        kind = "CoSimulation" if way == "co-simulation" else "ModelExchange"
        instance = instantiate_fmu(self.folder, self.description, kind)
        evaluations = 0
        own = getattr(instance, "getDerivatives", None)

        def counted(*arguments):
            nonlocal evaluations
            evaluations += 1
            return own(*arguments)

        chosen = dict(values)
        if own:
            instance.getDerivatives = counted
            chosen["exchange.contacts"] = RESOLVED if way == "resolved" else MAPPED
        else:
            chosen["solver.tolerance"] = tolerance
        begin = time.perf_counter()
        try:
            result = fmpy.simulate_fmu(
                self.folder,
                model_description=self.description,
                fmu_instance=instance,
                fmi_type=kind,
                start_values=chosen,
                stop_time=stop,
                output_interval=0.01,
                relative_tolerance=tolerance if own else None,
                output=["E_total", "E_residual", *PULSES, *WORK],
                record_events=False,
            )
        except RuntimeError:
            # CVODE gave up, as it does after 500 steps within one interval of the output.
            return {"error": float("nan"), "evaluations": evaluations, "seconds": float("nan"), "pulses": ()}
        finally:
            instance.freeInstance()
        return {
            "error": abs(float(result["E_residual"][-1] / result["E_total"][0])),
            "evaluations": evaluations if own else int(result["solver.evaluations"][-1]),
            "seconds": time.perf_counter() - begin,
            "pulses": tuple(int(result[name][-1]) for name in PULSES),
        }


def figures() -> dict[str, dict]:
    """The start values of both figures, as numbers."""
    numbers = {}
    for name, values in (("Figure 5", nc.figure5()), ("Figure 6", nc.figure6())):
        numbers[name] = {key: value for key, value in values.items() if not isinstance(value, str)}
    return numbers


def compare(path: Path, stop: float) -> list[dict]:
    """All runs, as rows of the table."""
    fmu, rows = Unpacked(path), []
    for figure, values in figures().items():
        for way, tolerances in TOLERANCES.items():
            for tolerance in tolerances:
                row = {"figure": figure, "way": way, "tolerance": tolerance}
                rows.append(row | fmu.run(way, values, tolerance, stop))
    return rows


def right(rows: list[dict], row: dict) -> bool:
    """Whether the pulses of a run are those of co-simulation."""
    exact = [other for other in rows if other["figure"] == row["figure"] and other["way"] == "co-simulation"]
    return row["pulses"] == exact[-1]["pulses"]


def save_plot(path: Path, rows: list[dict]) -> None:
    """Energy error over evaluations; hollow where pulses are wrong."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9})
    names = list(figures())
    figure, axes = plt.subplots(1, len(names), figsize=(9, 4), sharey=True, layout="constrained")
    for name, axis in zip(names, axes, strict=True):
        for way, colour in zip(TOLERANCES, ("#c04000", "#0060a0", "#208030"), strict=True):
            chosen = [
                row
                for row in rows
                if row["figure"] == name and row["way"] == way and row["error"] == row["error"]
            ]
            cost, error = [row["evaluations"] for row in chosen], [max(row["error"], 1e-16) for row in chosen]
            axis.loglog(cost, error, "-", color=colour, linewidth=1)
            for filled in (True, False):
                points = [
                    (x, y)
                    for x, y, row in zip(cost, error, chosen, strict=True)
                    if right(rows, row) == filled
                ]
                label = (way if filled else f"{way}, wrong pulses") if points else None
                face = colour if filled else "white"
                axis.plot(
                    *zip(*points, strict=True), "o", color=colour, markerfacecolor=face, label=label
                ) if points else None
        axis.set_title(name)
        axis.set_xlabel("evaluations in 10 s")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("energy error / energy")
    axes[1].legend(fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> int:
    """Runs all of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", type=Path, default=ROOT / "target/fmu/NewtonsCradle.fmu")
    parser.add_argument("--out", type=Path, default=ROOT / "out/exchange")
    parser.add_argument("--stop", type=float, default=10.0, help="s")
    arguments = parser.parse_args()
    if not arguments.fmu.exists():
        print(f"{arguments.fmu} is missing: build it with `cargo pack build --release`", file=sys.stderr)
        return 1
    rows = compare(arguments.fmu, arguments.stop)
    arguments.out.mkdir(parents=True, exist_ok=True)
    with (arguments.out / "exchange.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    print(f"{'':9} {'way':14} {'tolerance':>9} {'error':>8} {'evaluations':>11} {'s':>6}  pulses")
    for row in rows:
        pulses = " ".join(map(str, row["pulses"])) or "gave up"
        mark = "" if right(rows, row) else "  wrong"
        print(
            f"{row['figure']:9} {row['way']:14} {row['tolerance']:9.0e} {row['error']:8.1e} {row['evaluations']:11d} "
            f"{row['seconds']:6.2f}  {pulses}{mark}"
        )
    save_plot(arguments.out / "exchange.png", rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
