"""What other engines make of rows of balls: error over processor time, against the exact results of benchmark/.

    python examples/engines/compare.py

Makes a virtual environment of its own in target/engines, installs the engines pinned in requirements.txt, runs each in
a process of its own, and writes results.json, table.md and engines.png there. Needs nothing but Python, and a quarter
of an hour. An engine that cannot be installed here is named and left out. docs/engines.md shows what came out.
"""

import datetime
import json
import platform
import subprocess
import sys
import venv
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).resolve().parent
OUT = HERE.parents[1] / "target/engines"
PYTHON = OUT / "venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
ENGINES = ["mujoco", "drake", "lammps", "exudyn", "pybullet", "rapier", "pymunk"]
ROWS = {  # cases of the benchmark, and titles
    "equal-2-hertz": "2 equal, Hertz",
    "equal-5-hertz": "5 equal, Hertz",
    "equal-5-linear": "5 equal, linear springs",
    "siconos-monodisperse": "10 equal, Hertz",
    "tapered-10-hertz": "10 tapered, Hertz",
    "damped-5-ve-hertz": "5 viscoelastic, Hertz",
    "damped-5-hc-hertz": "5 Hunt-Crossley, Hertz",
    "damped-5-hc-linear": "5 Hunt-Crossley, linear",
    "damped-5-kv-linear": "5 Kelvin-Voigt",
    "damped-5-kv-no-pull-linear": "5 Kelvin-Voigt, no pull",
    "rigid-5-lossy": "5 rigid in touch, e = 0.9",
    "rigid-8-random": "8 rigid apart, e = 0.9375",
    "cradle-1-steel": "cradle, 1 click",
    "cradle-10-steel": "cradle, 10 clicks",
}


def install() -> None:
    """Makes the environment, and names what cannot be installed."""
    if not PYTHON.exists():
        venv.create(OUT / "venv", with_pip=True)
    for line in (HERE / "requirements.txt").read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            print(f"installing {line}", flush=True)
            command = [PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", line]
            if subprocess.run(command).returncode:
                print(f"{line} cannot be installed here and is left out", flush=True)


def run(engines: list[str]) -> list[dict]:
    """The lines of these engines, shown as they come."""
    found = []
    for engine in engines:
        command = [PYTHON, HERE / "engines.py", engine, *ROWS]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            for line in process.stdout:
                if line.startswith("{"):
                    found.append(json.loads(line))
                    texts = f"{found[-1]['error']:8.1e} {found[-1]['seconds']:8.2g} s  {found[-1]['setting']}"
                    print(f"{engine:9} {found[-1]['row']:27} {texts}", flush=True)
        if process.returncode:
            print(f"{engine} ended with code {process.returncode}; the rest of it is left out", flush=True)
    return found


def of(results: dict, row: str, engine: str) -> list[dict]:
    """The runs of an engine for a row."""
    return [run for run in results["runs"] if (run["row"], run["engine"]) == (row, engine)]


def table(results: dict) -> str:
    """The table of docs/engines.md: error and time of each engine as recommended, and at its best."""

    def rounded(value: float) -> float:
        return float(f"{value:.1g}")

    def cell(runs: list[dict]) -> str:
        if not runs:
            return ""
        chosen = runs[0], min(runs, key=lambda run: run["error"])
        texts = [f"{max(run['error'], 1e-16):.0e} ({rounded(1e3 * run['seconds']):g} ms)" for run in chosen]
        return " → ".join(dict.fromkeys(texts)) + ("" if runs[0]["own"] else " *")

    lines = [f"| | {' | '.join(ENGINES)} |", "|---" * (1 + len(ENGINES)) + "|"]
    for row, title in ROWS.items():
        lines.append(f"| {title} | {' | '.join(cell(of(results, row, engine)) for engine in ENGINES)} |")
    return "\n".join(lines)


def plot(results: dict) -> None:
    """One diagram for each row; a ring marks the recommended setting."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(5, 3, figsize=(11, 14), sharey=True, layout="constrained")
    *axes, legend = axes.flat
    for axis, (name, title) in zip(axes, ROWS.items(), strict=True):
        for engine, mark in zip(ENGINES, "osD^vPX", strict=True):
            runs = of(results, name, engine)
            points = [[run["seconds"] for run in runs], [max(run["error"], 1e-16) for run in runs]]
            (line,) = axis.loglog(*points, f"-{mark}", linewidth=0.8, markersize=4, label=engine)
            axis.plot(*(part[:1] for part in points), "o", markersize=10, mfc="none", color=line.get_color())
        axis.set(title=title, xlabel="processor time, s", ylabel="error / largest velocity")
        axis.grid(alpha=0.3)
    legend.legend(*axes[0].get_legend_handles_labels(), loc="center")
    legend.axis("off")
    figure.savefig(OUT / "engines.png", dpi=90)


def main() -> int:
    """Installs in a first process, runs and draws in a second one, in the new environment."""
    if Path(sys.prefix) != OUT / "venv":
        install()
        return subprocess.run([PYTHON, __file__]).returncode
    installed = {package.name.lower(): package.version for package in metadata.distributions()}
    names = {engine: {"rapier": "rapier3d"}.get(engine, engine) for engine in ENGINES}
    versions = {engine: installed[name] for engine, name in names.items() if name in installed}
    results = {
        "date": datetime.date.today().isoformat(),
        "machine": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "versions": versions,
        "runs": run(list(versions)),
    }
    (OUT / "results.json").write_text(json.dumps(results, indent=0) + "\n", encoding="utf-8")
    (OUT / "table.md").write_text(table(results) + "\n", encoding="utf-8")
    plot(results)
    print(f"wrote results.json, table.md and engines.png to {OUT}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
