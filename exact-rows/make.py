"""Computes the exact results of the benchmark for the rows in cases.json: `results` and `order` there, and cases.csv.

    python3 exact-rows/make.py [CASE ...]

A new case is a line there with the other fields (docs/makers/exact-rows.md), and a `stop` behind the last release. All cases
take a quarter of an hour on two idle cores; with names, only these are computed. It needs g++ with libquadmath, and
numpy. Each row is computed twice in quadruple precision, by Taylor series (exact/taylor.cpp) and by extrapolation
(exact/gragg.cpp), rigid ones in fractions and in decimals (rigid.py); then again with each start value changed by 1e-16
of itself, up or down by chance. What arrives of that is a result's sensitivity.
"""

import csv
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from pathlib import Path

import numpy as np
from rigid import in_decimals, in_fractions

HERE = Path(__file__).resolve().parent
BUILT = HERE.parent / "target/exact-rows"
LAWS = ("elastic", "kelvinVoigt", "kelvinVoigtNoPull", "huntCrossley", "viscoelastic", "constantRestitution")
INPUT = ("damping", "g_over_length", "mass", "x", "v", "stiffness", "gap")
UNITS = {"x": "m", "v": "m/s", "peak": "N", "onset": "s", "release": "s", "loss": "J"}
TIE = Decimal("1e-12")  # of the last release: onsets closer to each other come together
UNDETERMINED = 1e-8  # of the scale: a sensitivity with which a result is left out


def computed(row, method, seed=0):
    """What a program from exact/ gives for a row: lists of numbers by name, and pairs of contact and time (s)."""
    # With a changed start, slow balls of one row meet long after its `stop`: it runs until all have parted.
    end = row["stop"] if row["name"] != "equal-50-cubic" else 1e300
    numbers = np.hstack([row["n"], LAWS.index(row["law"]), row["exponent"], end, *(row[name] for name in INPUT)])
    command, text = [BUILT / method, str(seed)], " ".join(map(str, numbers.tolist()))
    found = subprocess.run(command, input=text, stdout=subprocess.PIPE, text=True, check=True).stdout
    lines = [(name, [*map(Decimal, words)]) for name, *words in map(str.split, found.splitlines())]
    return dict(lines) | {kind: [pair for name, pair in lines if name == kind] for kind in ("closed", "opened")}


def order(result, last, left_out):
    """The contacts in the order of their onsets, those at the same time together."""
    groups, before = [], -last
    for contact, t in result["closed"]:
        if contact not in left_out:
            groups += [[]] if t - before > TIE * last or not groups else []
            groups[-1].append(int(contact))
            before = t
    return [sorted(group) for group in groups]


def judged(name, scale, found):
    """Values, sensitivities and agreement of a quantity."""
    first, second, *changed = (np.array(result[name], dtype=object) for result in found)
    moved = abs(np.array(changed) - first).max(axis=0).astype(float)
    known = (moved <= UNDETERMINED * scale) & (first != -1)
    worst = float(max(abs(first - second)[known], default=0)) / scale
    value = [f"{one:.20g}" if k else None for one, k in zip(first, known, strict=True)]
    sensitivity = [float(f"{one:.1e}") if k else None for one, k in zip(moved, known, strict=True)]
    about = {"unit": UNITS[name], "scale": scale, "agreement": float(f"{worst:.1e}")}
    return about | {"value": value, "sensitivity": sensitivity}


def complete(row, pool):
    """Gives a row its results."""
    seeds = range(1, 5 if row["n"] < 50 else 3)
    jobs = [("taylor", 0), ("gragg", 0), *(("taylor", seed) for seed in seeds)]
    if rigid := row["law"] == "restitution":
        found = [in_fractions(row), in_decimals(row), *(in_fractions(row, seed) for seed in seeds)]
    else:
        found = list(pool.map(lambda job: computed(row, *job), jobs))
    m, x, v = (np.array(row[name], dtype=object) for name in ("mass", "x", "v"))
    # The force of compliant balls in touch grows from nothing, long before doubles hold it: they have no onset.
    touch = np.flatnonzero(x[:-1] - x[1:] == row["gap"]) + 1 if not rigid else []
    for result in found:
        first = {j: t for j, t in result["closed"][::-1] if j not in touch}
        for name, times in (("onset", first), ("release", dict(result["opened"]))):
            result[name] = [times.get(j, Decimal(-1)) for j in range(1, row["n"])]
    last, pull = max(found[0]["release"]), row["g_over_length"] ** 0.5
    scales = {"x": max(abs(x))} if pull else {}
    scales["v"] = max(*abs(v), *(pull * abs(x)))
    scales |= {} if rigid else {"peak": float(max(found[0]["peak"]))}
    scales |= dict.fromkeys(("onset", "release"), float(last) or 1.0)
    scales["loss"] = sum(m * (v * v + pull * pull * x * x) / 2)
    results = ((name, judged(name, scale, found)) for name, scale in scales.items())
    row["results"] = {name: one for name, one in results if any(one["value"])}
    orders = [order(result, last, touch) for result in found]
    row["order"] = orders[0] or None if all(one == orders[0] for one in orders) else None


def lines_of(row):
    """A row's lines of the CSV file, from the second column on."""
    row = row | row.get("material", {}) | {"start x": row["x"], "start v": row["v"]}
    for name in ("law", "exponent", "damping", "g_over_length", "stop", *row.get("material", ())):
        yield name, "", row[name]
    for name in ("mass", "stiffness", "gap", "start x", "start v", "radius"):
        yield from ((name, i, value) for i, value in enumerate(row.get(name) or [], start=1))
    for name, result in row["results"].items():
        pairs = enumerate(zip(result["value"], result["sensitivity"], strict=True), start=1)
        more = result["scale"], result["agreement"]
        yield from ((name, i, value, moved, *more) for i, (value, moved) in pairs if value is not None)
    for i, group in enumerate(row["order"] or [], start=1):
        yield from (("order", i, contact) for contact in group)


def main():
    data = json.loads((HERE / "cases.json").read_text(encoding="utf-8"))
    rows = data.pop("cases")
    names = sys.argv[1:] or [row["name"] for row in rows]
    if unknown := set(names) - {row["name"] for row in rows}:
        sys.exit(f"no case has the name {', '.join(sorted(unknown))}")
    BUILT.mkdir(parents=True, exist_ok=True)
    for name in ("taylor", "gragg"):
        command = ["g++", "-std=gnu++17", "-O2", HERE / f"exact/{name}.cpp", "-o", BUILT / name, "-lquadmath"]
        subprocess.run(command, check=True)
    with ThreadPoolExecutor(2) as pool:
        for row in rows:
            if row["name"] in names:
                complete(row, pool)
                print(row["name"], flush=True)
    lines = ",\n".join(map(json.dumps, rows))
    (HERE / "cases.json").write_text(f'{json.dumps(data)[:-1]}, "cases": [\n{lines}\n]}}\n', encoding="utf-8")
    with (HERE / "cases.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["case", "quantity", "index", "value", "sensitivity", "scale", "agreement"])
        table.writerows([row["name"], *line, "", "", ""][:7] for row in rows for line in lines_of(row))


if __name__ == "__main__":
    main()
