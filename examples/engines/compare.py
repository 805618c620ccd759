"""What other engines make of rows of balls: error over processor time, against the exact results of exact-rows/.

    python examples/engines/compare.py

Makes a virtual environment of its own in target/engines, installs the engines pinned in requirements.txt, runs each in
a process of its own, and writes results.json, table.md and engines.png there. Needs nothing but Python, and a quarter
of an hour. Engines that cannot be installed are skipped with a message. docs/makers/engines.md shows what came out.
"""

import json
import platform
import subprocess
import sys
import time
import venv
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module, metadata
from pathlib import Path

from engines import ENGINES, Row

HERE = Path(__file__).resolve().parent
OUT = HERE.parents[1] / "target/engines"
PYTHON = OUT / "venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
CASES = HERE.parents[1] / "exact-rows/cases.json"
ROWS = [  # cases of the benchmark
    "equal-2-hertz", "equal-5-hertz", "equal-5-linear", "siconos-monodisperse", "tapered-10-hertz", "damped-5-ve-hertz",
    "damped-5-hc-hertz", "damped-5-hc-linear", "damped-5-kv-linear", "damped-5-kv-no-pull-linear", "rigid-5-lossy",
    "rigid-8-random", "cradle-1-steel", "cradle-10-steel",
]  # fmt: skip
NAMES = {engine.__name__: engine for engine in ENGINES}
PATIENCE = 5.0  # s: after a run that took longer, finer steps are not tried


def install() -> None:
    """Makes the environment, and prints which engines cannot be installed."""
    if not PYTHON.exists():
        venv.create(OUT / "venv", with_pip=True)
    for line in (HERE / "requirements.txt").read_text(encoding="utf-8").splitlines()[1:]:
        print(f"installing {line}", flush=True)
        if subprocess.run([PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", line]).returncode:
            print(f"{line} cannot be installed here and is left out", flush=True)


def run(name: str) -> list[dict]:
    """The runs of one engine for all rows whose law it has, perhaps with another exponent; prints each."""
    cases = {case["name"]: case for case in json.loads(CASES.read_text(encoding="utf-8"))["cases"]}
    (module, laws, exponents, settings), found = ENGINES[NAMES[name]], []
    rows = [Row(cases[case]) for case in ROWS if cases[case]["law"] in laws.split()]
    for row in (row for row in rows if exponents or not row.swing):
        for setting in settings:
            step, count, state = NAMES[name](import_module(module), row, *setting)
            begin = time.process_time()
            for _ in range(count):
                step()
            cost, error = time.process_time() - begin, row.error(*state())
            own = row.rigid or row.exponent in exponents
            print(f"{name:9} {row.name:27} {error:8.1e} {cost:8.2g} s  {setting}", flush=True)
            found.append(dict(engine=name, row=row.name, setting=setting, own=own, error=error, seconds=cost))
            if cost > PATIENCE:
                break
    return found


def runs_of(results: dict, row: str) -> list[list[dict]]:
    """The runs for a row, by engine."""
    runs = [run for run in results["runs"] if run["row"] == row]
    return [[run for run in runs if run["engine"] == engine] for engine in NAMES]


def table(results: dict) -> str:
    """The table of docs/makers/engines.md: the error of each engine with its recommended setting and with its best."""

    def cell(runs: list[dict]) -> str:
        chosen = [*runs[:1], *sorted(runs, key=lambda run: run["error"])[:1]]
        texts = [f"{max(run['error'], 1e-16):.0e}" for run in chosen]
        return " → ".join(dict.fromkeys(texts)) + ("" if not runs or runs[0]["own"] else " *")

    rows = [["case", *NAMES], ["---"] * (1 + len(NAMES))]
    rows += [[row, *map(cell, runs_of(results, row))] for row in ROWS]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def plot(results: dict) -> None:
    """One diagram for each row; a ring marks the recommended setting."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 14), layout="constrained")
    *axes, legend = figure.subplots(5, 3, sharey=True).flat
    for axis, row in zip(axes, ROWS, strict=True):
        for engine, mark, runs in zip(NAMES, "osD^vPX", runs_of(results, row), strict=True):
            points = [[run["seconds"] for run in runs], [max(run["error"], 1e-16) for run in runs]]
            (line,) = axis.loglog(*points, f"-{mark}", linewidth=0.8, markersize=4, label=engine)
            axis.plot(*(part[:1] for part in points), "o", markersize=10, mfc="none", color=line.get_color())
        axis.set(title=row, xlabel="processor time, s", ylabel="error / largest velocity")
        axis.grid(alpha=0.3)
    legend.legend(*axes[0].get_legend_handles_labels(), loc="center")
    legend.axis("off")
    figure.savefig(OUT / "engines.png", dpi=90)


def main() -> None:
    """Installs in a first process, runs and draws in a second one, in the new environment."""
    if Path(sys.prefix) != OUT / "venv":
        install()
        sys.exit(subprocess.run([PYTHON, __file__]).returncode)
    installed = {one.name.lower().removesuffix("3d"): one.version for one in metadata.distributions()}
    versions = {engine: installed[engine] for engine in NAMES if engine in installed}
    machine = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    results = {"date": time.strftime("%Y-%m-%d"), "machine": machine, "versions": versions, "runs": []}
    for engine in versions:
        with ProcessPoolExecutor(1) as process:  # a process of its own, because an engine may end it
            try:
                results["runs"] += process.submit(run, engine).result()
            except Exception as problem:
                print(f"{engine} is left out: {problem}", flush=True)
    (OUT / "results.json").write_text(json.dumps(results, indent=0) + "\n", encoding="utf-8")
    (OUT / "table.md").write_text(table(results) + "\n", encoding="utf-8")
    plot(results)
    print(f"wrote results.json, table.md and engines.png to {OUT}")


if __name__ == "__main__":
    main()
