"""The paper's cradle written by hand in Modelica, in two dozen lines, beside the FMU.

    .venv/bin/python examples/modelica/compare.py

The compiler rumoca (`pip install rumoca`) simulates Paper.mo for ten seconds of the paper's Figures 5 and 6, by its two
solvers and with several tolerances. The table has the time without compilation, the largest difference of a position
from the FMU's, and the relative error of the energy.
"""

import argparse
import time
from pathlib import Path

import newtons_cradle as nc
import numpy as np
import rumoca

PAPER = Path(__file__).with_name("Paper.mo")
SOLVERS = {"rk-like": "Runge-Kutta 4(5)", "bdf": "BDF"}  # of rumoca


def modelica(values: dict, stop: float, solver: str, tolerance: float, step: float = 0.01) -> dict:
    """The positions and velocities of a run by rumoca, shape (samples, balls), and its time, s."""
    model = rumoca.Session().loads(PAPER.read_text(encoding="utf-8"), model="Paper")
    config = rumoca.SimConfig(solver=solver, rtol=tolerance, atol=1e-3 * tolerance)
    parameters = {"k": values["contact.stiffness"], "band": values["contact.deadBand"]}
    begin = time.perf_counter()
    result = model.simulate((0.0, stop), dt=step, config=config, params=parameters)
    taken = time.perf_counter() - begin
    # Events add rows: of several rows at one time the last one counts.
    data, times = result.to_dict()["data"], np.asarray(result.time)
    rows = np.searchsorted(times, np.arange(round(stop / step) + 1) * step + 1e-9) - 1
    columns = {name: np.column_stack([data[f"{name}[{i}]"] for i in range(1, 6)])[rows] for name in "xv"}
    return columns | {"time": taken}


def by_fmu(values: dict, stop: float, step: float = 0.01) -> dict:
    """The positions and velocities of a run by the FMU, and its time, s; see `modelica`."""
    with nc.Fmu() as fmu, fmu.start(values) as run:
        recorder, taken = run.recorder(["x", "v"]), 0.0
        recorder.sample()
        for k in range(round(stop / step)):
            begin = time.perf_counter()
            run.step_to((k + 1) * step)
            taken += time.perf_counter() - begin
            recorder.sample()
        result = recorder.result()
        return {"x": result["x"], "v": result["v"], "time": taken}


def energy_error(run: dict) -> float:
    """The largest relative change of the energy, for balls of 1 kg on pendulums of 1.962 m."""
    energy = np.sum(run["v"] ** 2 + 9.81 / 1.962 * run["x"] ** 2, axis=1)
    return float(np.abs(energy / energy[0] - 1).max())


def main() -> None:
    parser = argparse.ArgumentParser(description="The paper's cradle in Modelica, beside the FMU.")
    parser.add_argument("--stop", type=float, default=10.0, metavar="SECONDS")
    parser.add_argument("--tolerances", type=float, nargs="+", default=[1e-6, 1e-8, 1e-10], metavar="TOLERANCE")
    options = parser.parse_args()
    print("| | tolerance | time | largest difference of a position | error of the energy |\n|---|---:|---:|---:|---:|")
    for figure in ("figure5", "figure6"):
        values = nc.preset(figure)
        right = by_fmu(values, options.stop)
        print(f"| {figure}, the FMU | - | {1e3 * right['time']:.1f} ms | - | {energy_error(right):.0e} |")
        for solver, name in SOLVERS.items():
            for tolerance in options.tolerances:
                try:
                    run = modelica(values, options.stop, solver, tolerance)
                except Exception as problem:  # whatever rumoca's solvers raise
                    print(f"| {figure}, {name} | {tolerance:.0e} | stops: {str(problem)[:60]} | | |")
                    continue
                difference = np.abs(run["x"] - right["x"]).max()
                numbers = f"{1e3 * run['time']:.0f} ms | {difference:.0e} m | {energy_error(run):.0e}"
                print(f"| {figure}, {name} | {tolerance:.0e} | {numbers} |")


if __name__ == "__main__":
    main()
