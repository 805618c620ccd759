"""A parameter study of the cradle: order p, dead band, damping and lifted balls, on many processes.

    .venv/bin/python examples/study/study.py

makes 1,156 runs of ten seconds with one process per core, writes out/study/runs.csv with one row per run,
and draws maps of it. `--scheduler ADDRESS` uses the workers of a dask cluster instead. If a run fails, its row
and the terminal give the reason, and the other runs continue. If a worker dies, another one repeats its run. An FMU
of another cradle is refused, and an axis that changes nothing in any run is an error. out/study/about.json says what
the rows come from: FMU, start values and versions.
"""

import argparse
import json
import os
import sys
import textwrap
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import one_run
import pandas as pd

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "paper"))

import support
from plots import plt
from support import nc

AXES = ["order", "dead_band", "damping", "lifted"]
MEASURED = ["overlap", "last_ball", "middle_ball", "energy_left", "pulses"]
COLUMNS = [*AXES, *MEASURED, "energy_error", "error", "seconds"]
QUANTITIES = {  # column: (title, colour map)
    "overlap": ("impulse shared by neighbouring pulses", "viridis"),
    "last_ball": ("energy in the last ball after the first click", "magma"),
    "middle_ball": ("middle ball's swing / amplitude, after 10 s", "cividis"),
}


def main() -> None:
    """Runs the study of the command line. Raises OSError or CradleError."""
    options = command_line()
    axes = {name: getattr(options, name) for name in AXES}
    begin = time.perf_counter()
    about = checked(options.fmu)
    with connected(options.scheduler) as client:
        study = {"workers": options.workers, "client": client, "progress": nc.Progress("Study")}
        found = nc.sweep(axes, one_run.measure, fmu=options.fmu, **study)
    rows = found.to_dataframe().reindex(columns=COLUMNS)
    seconds = time.perf_counter() - begin
    options.out.mkdir(parents=True, exist_ok=True)
    rows.astype({"pulses": "Int64"}).to_csv(options.out / "runs.csv", index=False)
    about |= {"axes": axes}
    (options.out / "about.json").write_text(json.dumps(about, indent=1), encoding="utf-8")
    good = report(rows, seconds)
    if good.empty:
        raise nc.CradleError("no run has succeeded")
    if idle := without_effect(good):
        raise nc.CradleError(f"the axis {', '.join(idle)} has no effect in any run")
    save_maps(options.out / "study.png", good)
    print(f"wrote {options.out}")


def command_line() -> argparse.Namespace:
    """The study's axes, and where it runs."""
    parser = support.command_line(__doc__, "study")
    axis = {"nargs": "+", "metavar": "X"}
    parser.add_argument("--orders", dest="order", type=float, default=np.linspace(1, 5, 17).tolist(), **axis)
    bands = {"dest": "dead_band", "type": float, "default": np.linspace(0, 1.6, 17).round(1).tolist()}
    parser.add_argument("--dead-bands", **bands, help="in units of the largest overlap, 1 µm", **axis)
    damping = {"dest": "damping", "type": float, "default": [0.0, 0.2]}
    parser.add_argument("--dampings", **damping, help="Hunt-Crossley, s/m", **axis)
    parser.add_argument("--lifted", type=int, default=[1, 2], help="balls pulled 0.1 m aside", **axis)
    parser.add_argument("--scheduler", metavar="ADDRESS", help="address of a dask scheduler, tcp://host:8786")
    workers = "number of local processes [default: one per core]"
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help=workers)
    return parser.parse_args()


def checked(path: Path) -> dict:
    """Where the rows come from: FMU, versions and start values. Raises OSError, or FmuError for an FMU that does not
    fit this study."""
    with nc.Fmu(path) as fmu:
        fmu.require()
        if fmu.balls < 3:
            raise nc.FmuError(f"{path} is refused: it has {fmu.balls} balls where 3 or more are needed")
        given = one_run.given(fmu.balls)
        fmu.require(starts=given)
        run = {"stop": one_run.STOP, "step": one_run.STEP, "amplitude": one_run.AMPLITUDE}
        return fmu.provenance() | {"given": given, "run": run | {"largest overlap": one_run.LARGEST}}


def without_effect(rows: pd.DataFrame) -> list[str]:
    """The axes that change nothing: runs that differ only along such an axis agree in all that was measured."""
    idle = []
    for axis in AXES:
        alike = rows.groupby([other for other in AXES if other != axis])[MEASURED]
        same = np.isclose(rows[MEASURED], alike.transform("first"), rtol=1e-9, atol=1e-12).all()
        if alike.ngroups < len(rows) and same:
            idle.append(axis)
    return idle


def connected(scheduler: str | None):
    """A client of the dask scheduler at this address, whose workers get the code of a run; None without an address.
    Raises OSError."""
    if scheduler is None:
        return nullcontext()
    from distributed import Client

    client = Client(scheduler, timeout="10s")
    client.upload_file(one_run.__file__)
    return client


def report(rows: pd.DataFrame, seconds: float) -> pd.DataFrame:
    """Prints what failed and how long it took; returns the rows that succeeded."""
    failed = rows[rows["error"] != ""]
    for *case, error in failed[[*AXES, "error"]].head(20).itertuples(index=False):
        print(f"FAILED  {', '.join(f'{name} {x:g}' for name, x in zip(AXES, case, strict=True))}: {error}")
    if len(failed) > 20:
        print(f"FAILED  {len(failed) - 20} more, see runs.csv")
    print(f"{len(rows) - len(failed)} runs succeeded, {len(failed)} failed")
    print(f"{seconds:.1f} s in total; the runs took {rows['seconds'].sum():.1f} s, added up over all workers")
    return rows[rows["error"] == ""]


def save_maps(path: Path, rows: pd.DataFrame) -> None:
    """Draws the rows of a study; cells without a successful run stay grey."""
    plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 9, "axes.facecolor": "#d0d0d0"})
    cases = list(rows.groupby(["lifted", "damping"]))
    size = (1.4 + 2.3 * len(cases), 0.6 + 2.3 * len(QUANTITIES))
    shape = {"sharex": True, "sharey": True, "squeeze": False, "layout": "constrained", "figsize": size}
    figure, axes = plt.subplots(len(QUANTITIES), len(cases), **shape)
    for (name, (title, colours)), line in zip(QUANTITIES.items(), axes, strict=True):
        for (_, chosen), axis in zip(cases, line, strict=True):
            cells = chosen.pivot(index="dead_band", columns="order", values=name)
            scale = {"cmap": colours, "vmin": 0.0, "vmax": rows[name].max()}
            shown = axis.pcolormesh(_edges(cells.columns), _edges(cells.index), cells, **scale)
        line[0].set_ylabel("dead band / µm")
        figure.colorbar(shown, ax=list(line), label=textwrap.fill(title, 28))
    for ((lifted, damping), _), top, bottom in zip(cases, axes[0], axes[-1], strict=True):
        top.set_title(f"{lifted} lifted, damping {damping:g} s/m", fontsize=9)
        bottom.set_xlabel("order p")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _edges(centres: pd.Index) -> np.ndarray:
    """Edges of cells around rising centres; a single centre gets a cell of width 1."""
    around = np.pad(centres, 1, "reflect", reflect_type="odd") if len(centres) > 1 else centres[0] + [-1, 0, 1]
    return np.convolve(around, [0.5, 0.5], "valid")


if __name__ == "__main__":
    support.ended(main)
