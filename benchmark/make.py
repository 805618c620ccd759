"""Computes the exact results of the benchmark: cases.json and cases.csv, beside this file.

    python3 benchmark/make.py [CASE ...]

This takes about a quarter of an hour on two idle cores; with names, only these cases are computed, and the others kept.
It needs g++ with libquadmath, and numpy. Each row is computed twice in quadruple precision, by Taylor series
(exact/taylor.cpp) and by extrapolation (exact/gragg.cpp), rigid ones in fractions and in decimals (rigid.py); then
again with each start value changed by 1e-16 of itself, up or down by chance. What arrives of that is a result's
sensitivity.
"""

import csv
import json
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from pathlib import Path

import numpy as np
from families import everything
from rigid import in_decimals, in_fractions

HERE = Path(__file__).resolve().parent
BUILT = HERE.parent / "target/benchmark"
VERSION = "1.0.0"
LAWS = ("elastic", "kelvinVoigt", "kelvinVoigtNoPull", "huntCrossley", "viscoelastic")
INPUT = ("exponent", "damping", "g_over_length", "stop", "mass", "x", "v", "stiffness", "gap")
UNITS = {"x": "m", "v": "m/s", "peak": "N", "onset": "s", "release": "s", "loss": "J"}
TIE = Decimal("1e-12")  # of the last release: onsets closer to each other come together
UNDETERMINED = 1e-8  # of the scale: a sensitivity with which a result is left out


def computed(row, method, seed=0):
    """What a program from exact/ gives for a row: lists of numbers by name."""
    numbers = np.hstack([row["n"], LAWS.index(row["law"]), *(row[name] for name in INPUT)])
    command, text = [BUILT / method, str(seed)], " ".join(number.hex() for number in numbers)
    found = subprocess.run(command, input=text, stdout=subprocess.PIPE, text=True, check=True).stdout
    return {name: [*map(Decimal, words)] for name, *words in map(str.split, found.splitlines())}


def order(result, last, left_out):
    """The contacts in the order of their onsets, those at the same time together."""
    groups, before = [], -last
    for t, contact in sorted(zip(result["times"], map(int, result["contacts"]), strict=True)):
        if contact not in left_out:
            groups += [[]] if t - before > TIE * last or not groups else []
            groups[-1].append(contact)
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
    """A row with its results."""
    seeds = range(1, 5 if row["n"] < 50 else 3)
    jobs = [("taylor", 0), ("gragg", 0), *(("taylor", seed) for seed in seeds)]
    if rigid := row["law"] == "restitution":
        found = [in_fractions(row), in_decimals(row), *(in_fractions(row, seed) for seed in seeds)]
    else:
        found = list(pool.map(lambda job: computed(row, *job), jobs))
    last, pull = max(found[0]["release"]), row["g_over_length"] ** 0.5
    m, x, v = (np.array(row[name], dtype=object) for name in ("mass", "x", "v"))
    scales = {"x": max(abs(x))} if pull else {}
    scales["v"] = max(*abs(v), *(pull * abs(x)))
    scales |= {} if rigid else {"peak": float(max(found[0]["peak"]))}
    scales |= dict.fromkeys(("onset", "release"), float(last) or 1.0)
    scales["loss"] = sum(m * (v * v + pull * pull * x * x) / 2)
    # The force of compliant balls in touch grows from nothing, long before doubles hold it: they have no onset.
    touch = np.flatnonzero(x[:-1] - x[1:] == row["gap"]) + 1 if not rigid else []
    for result in found:
        result["onset"] = [Decimal(-1) if j in touch else t for j, t in enumerate(result["onset"], start=1)]
    row["stop"] = row["stop"] or float(f"{1.5 * float(last) or 1.0:.1e}")
    results = ((name, judged(name, scale, found)) for name, scale in scales.items())
    row["results"] = {name: one for name, one in results if any(one["value"])}
    orders = [order(result, last, touch) for result in found]
    return row | {"order": orders[0] or None if all(one == orders[0] for one in orders) else None}


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


def write(rows):
    """Both files."""
    head = {"title": "Rows of balls: exact results", "version": VERSION, "license": "CC0-1.0"}
    lines = ",\n".join(json.dumps(row) for row in rows)
    (HERE / "cases.json").write_text(f'{json.dumps(head)[:-1]}, "cases": [\n{lines}\n]}}\n', encoding="utf-8")
    with (HERE / "cases.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["case", "quantity", "index", "value", "sensitivity", "scale", "agreement"])
        table.writerows([row["name"], *line, "", "", ""][:7] for row in rows for line in lines_of(row))


def main():
    names, rows = sys.argv[1:], list(everything())
    if unknown := set(names) - {row["name"] for row in rows}:
        sys.exit(f"no case has the name {', '.join(sorted(unknown))}")
    before = json.loads((HERE / "cases.json").read_text(encoding="utf-8"))["cases"] if names else []
    kept = {row["name"]: row for row in before}
    BUILT.mkdir(parents=True, exist_ok=True)
    for name in ("taylor", "gragg"):
        command = ["g++", "-std=gnu++17", "-O2", HERE / f"exact/{name}.cpp", "-o", BUILT / name, "-lquadmath"]
        subprocess.run(command, check=True)
    with ThreadPoolExecutor(2) as pool:
        for row in rows:
            if not names or row["name"] in names:
                begin = time.perf_counter()
                kept[row["name"]] = complete(row, pool)
                worst = max(result["agreement"] for result in row["results"].values())
                print(f"{row['name']:28} {time.perf_counter() - begin:7.1f} s  {worst}", flush=True)
    write([kept[row["name"]] for row in rows if row["name"] in kept])


if __name__ == "__main__":
    main()
