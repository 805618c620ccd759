"""Computes the exact results of the benchmark: cases.json and cases.csv, beside this file.

    python3 benchmark/make.py [CASE ...]

This takes some ten minutes on two idle cores; with names, only these cases are computed, and the others kept. It needs
g++ with libquadmath. Each row is computed twice in quadruple precision, by Taylor series (exact/taylor.cpp) and by
collocation (exact/gauss.cpp), rigid ones in fractions and in decimals (rigid.py); then again with each start value
changed by 1e-16 of itself, up or down by chance. What arrives of that is a result's sensitivity.
"""

import csv
import itertools
import json
import random
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

from families import everything
from rigid import in_decimals, in_fractions

HERE = Path(__file__).resolve().parent
BUILT = HERE.parent / "target/benchmark"
VERSION = "1.0.0"
LAWS = ("elastic", "kelvinVoigt", "kelvinVoigtNoPull", "huntCrossley", "viscoelastic")
SETUP = ("mass", "stiffness", "gap", "x", "v")
UNITS = {"x": "m", "v": "m/s", "peak": "N", "onset": "s", "release": "s", "loss": "J"}
TIE = Decimal("1e-12")  # of the last release: onsets closer to each other come together
UNDETERMINED = 1e-8  # of the scale: a sensitivity with which a result is left out


def compiled(name):
    """A program from exact/."""
    BUILT.mkdir(parents=True, exist_ok=True)
    source = HERE / f"exact/{name}.cpp"
    subprocess.run(["g++", "-std=gnu++17", "-O2", source, "-o", BUILT / name, "-lquadmath"], check=True)
    return BUILT / name


def by_program(program, row, seed):
    """What a program gives for a row: lists of numbers by name."""
    first = [row["n"], LAWS.index(row["law"]), row["exponent"], row["damping"], row["g_over_length"]]
    lists = [row[name] for name in ("mass", "x", "v", "stiffness", "gap")]
    numbers = [*first, row["stop"], *itertools.chain.from_iterable(lists)]
    text = " ".join(float(number).hex() for number in numbers)
    done = subprocess.run([program, str(seed)], input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{row['name']}: {program.name}: {done.stderr.strip()}")
    lines = (line.split() for line in done.stdout.splitlines())
    return {name: [Decimal(word) for word in words] for name, *words in lines}


def by_fractions(row, seed=0, method=in_fractions):
    """What rigid.py gives for a row, in the form of the programs."""
    rng = random.Random(seed)
    change = Fraction(1, 10**16) if seed else 0
    row = row if not seed else row | {"number": lambda x: Fraction(x) * (1 + rng.choice((-1, 1)) * change)}
    v, impacts, loss = method(row)

    def decimal(value):
        return Decimal(value.numerator) / Decimal(value.denominator) if isinstance(value, Fraction) else value

    times, contacts = [decimal(t) for t, _ in impacts], [j for _, j in impacts]
    of = [
        [t for t, k in zip(times, contacts, strict=True) if k == j] or [Decimal(-1)]
        for j in range(1, row["n"])
    ]
    result = {"v": [decimal(value) for value in v], "loss": [decimal(loss)], "times": times}
    return result | {"onset": [t[0] for t in of], "release": [t[-1] for t in of], "contacts": contacts}


def in_touch(row):
    """The contacts (from 1) of compliant balls that touch at the start. Their force grows from nothing, long before
    doubles hold it: they have no onset."""
    starts = zip(row["x"], row["x"][1:], row["gap"], strict=False)
    touch = [j for j, (left, right, gap) in enumerate(starts, start=1) if left - right - gap == 0.0]
    return [] if row["law"] == "restitution" else touch


def order(result, last, left_out):
    """The contacts in the order of their onsets, those at the same time together."""
    groups, before = [], None
    for t, contact in sorted(zip(result["times"], map(int, result["contacts"]), strict=True)):
        if contact in left_out:
            continue
        if before is None or t - before > TIE * last:
            groups.append([])
        groups[-1].append(contact)
        before = t
    return [sorted(group) for group in groups]


def results(first, second, changed, scales):
    """Values, sensitivities and agreement of each quantity."""
    found = {}
    for name, scale in scales.items():
        moved = [max(abs(c[name][i] - value) for c in changed) for i, value in enumerate(first[name])]
        known = [m <= UNDETERMINED * scale and first[name][i] != -1 for i, m in enumerate(map(float, moved))]
        off = [abs(a - b) for a, b in zip(first[name], second[name], strict=True)]
        if not any(known):
            continue
        worst = float(max(o for o, k in zip(off, known, strict=True) if k)) / scale
        found[name] = {
            "unit": UNITS[name],
            "scale": scale,
            "agreement": float(f"{worst:.1e}"),
            "value": [f"{value:.20g}" if k else None for value, k in zip(first[name], known, strict=True)],
            "sensitivity": [float(f"{m:.1e}") if k else None for m, k in zip(moved, known, strict=True)],
        }
    return found


def complete(row, programs, pool):
    """A row with its results."""
    seeds = range(1, 5 if row["n"] < 50 else 3)
    if row["law"] == "restitution":
        first, second = by_fractions(row), by_fractions(row, 0, in_decimals)
        changed = [by_fractions(row, seed) for seed in seeds]
    else:
        jobs = [(programs[0], row, 0), (programs[1], row, 0), *((programs[0], row, seed) for seed in seeds)]
        first, second, *changed = pool.map(lambda job: by_program(*job), jobs)
    last = max(first["release"])
    pull, speeds = row["g_over_length"] ** 0.5, list(map(abs, row["v"]))
    speed = max(*speeds, *(pull * abs(x) for x in row["x"]))
    moves = zip(row["mass"], row["x"], row["v"], strict=True)
    energy = sum(m * (v * v + pull * pull * x * x) / 2 for m, x, v in moves)
    scales = {"x": max(map(abs, row["x"]))} if pull else {}
    scales |= {"v": speed} | ({"peak": float(max(first["peak"]))} if "peak" in first else {})
    scales |= {"onset": float(last) or 1.0, "release": float(last) or 1.0, "loss": energy}
    touch = in_touch(row)
    for result in (first, second, *changed):
        result["onset"] = [Decimal(-1) if j in touch else t for j, t in enumerate(result["onset"], start=1)]
    orders = [order(result, last, touch) for result in (first, second, *changed)]
    row["stop"] = row["stop"] or float(f"{1.5 * float(last) or 1.0:.1e}")
    row["results"] = results(first, second, changed, scales)
    return row | {"order": orders[0] or None if all(other == orders[0] for other in orders) else None}


def lines_of(row):
    """A row's lines of the CSV file, from the second column on."""
    for name in ("law", "exponent", "damping", "g_over_length", "stop", *row.get("material", ())):
        yield name, "", (row | row.get("material", {}))[name]
    for name in (*SETUP, "radius"):
        called = f"start {name}" if name in "xv" else name
        yield from ((called, i, value) for i, value in enumerate(row.get(name) or [], start=1))
    for name, result in row["results"].items():
        pairs = enumerate(zip(result["value"], result["sensitivity"], strict=True), start=1)
        more = result["scale"], result["agreement"]
        yield from ((name, i, value, moved, *more) for i, (value, moved) in pairs if value is not None)
    for i, group in enumerate(row["order"] or [], start=1):
        yield from (("order", i, contact) for contact in group)


def write(rows):
    """Both files."""
    head = {"title": "Rows of balls: exact results", "version": VERSION, "license": "CC0-1.0"}
    lines = [json.dumps(row) for row in rows]
    text = json.dumps(head)[:-1] + ', "cases": [\n' + ",\n".join(lines) + "\n]}\n"
    (HERE / "cases.json").write_text(text, encoding="utf-8")
    with (HERE / "cases.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["case", "quantity", "index", "value", "sensitivity", "scale", "agreement"])
        table.writerows([row["name"], *line, "", "", ""][:7] for row in rows for line in lines_of(row))


def main():
    names, rows = sys.argv[1:], everything()
    if unknown := set(names) - {row["name"] for row in rows}:
        sys.exit(f"no case has the name {', '.join(sorted(unknown))}")
    file = HERE / "cases.json"
    before = json.loads(file.read_text(encoding="utf-8"))["cases"] if names else []
    kept = {row["name"]: row for row in before}
    programs = compiled("taylor"), compiled("gauss")
    with ThreadPoolExecutor(2) as pool:
        for row in rows:
            if names and row["name"] not in names:
                continue
            begin = time.perf_counter()
            kept[row["name"]] = complete(row, programs, pool)
            agreed = {name: result["agreement"] for name, result in kept[row["name"]]["results"].items()}
            print(f"{row['name']:28} {time.perf_counter() - begin:7.1f} s  {agreed}", flush=True)
    write([kept[row["name"]] for row in rows if row["name"] in kept])


if __name__ == "__main__":
    main()
