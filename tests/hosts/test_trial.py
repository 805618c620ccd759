"""The cases: the right result is found right, each known mistake is named, and other results are described. What the
program says, and how it ends."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from conftest import ended, table
from importer import Importer
from newtons_cradle import Fmu, FmuError, InvalidValue
from newtons_cradle.trial import CASES, judge
from newtons_cradle.trial.master import run
from trial import HOSTS, short, verdict

MISTAKES = [(name, wrong) for name, case in CASES.items() for wrong in (*case.other, *case.wrong)]


@pytest.fixture(scope="module")
def folders(producer, fmu_path, tmp_path_factory):
    """The folders of all cases by name, as the program writes them."""
    out = tmp_path_factory.mktemp("cases")
    done = ended(producer, "cases", "--python", sys.executable, "--", "--from", fmu_path, "--out", out)
    assert f"{out / 'grid'}: the communication grid" in done.stdout
    return {name: out / name for name in CASES}


@pytest.mark.parametrize("name", CASES)
def test_judge_accepts_the_right_result(folders, name):
    folder = folders[name]
    assert judge(folder, folder / "expected.csv")[0].startswith("right to the last bit")
    text = (folder / "case.txt").read_text(encoding="utf-8")
    assert CASES[name].instructions() in text and all(words in text for words in CASES[name].wrong.values())


@pytest.mark.all
@pytest.mark.parametrize(("name", "wrong"), MISTAKES, ids=["-".join(mistake) for mistake in MISTAKES])
def test_judge_names_each_mistake(folders, name, wrong, tmp_path):
    """By a master with that mistake, whose solver takes other steps, in a file as other tools write it."""
    case = CASES[name]
    with Fmu(folders[name] / "cradle.fmu") as fmu:
        table = run(fmu, replace(case, parts=1.37 * case.parts), wrong)
    digits = 17 if wrong in case.other else 9
    lines = ["Time [s];StepCount;" + ";".join(f'"cradle.{column} [12 real out]"' for column in case.record)]
    for row, (time, *values) in enumerate(zip(*table.values(), strict=True)):
        cells = [value if isinstance(value, str) else f"{value:.{digits}g}".replace(".", ",") for value in values]
        lines.append(";".join([f"{time:.17g}".replace(".", ","), str(row), *cells]))
    path = tmp_path / "result.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (line,) = judge(folders[name], path)
    words = (case.other | case.wrong)[wrong]
    assert line.startswith(f"right, but {words}" if wrong in case.other else f"wrong: {words}"), line


def test_judge_describes_other_wrong_results(folders, tmp_path):
    folder = folders["pair"]
    table = np.genfromtxt(folder / "expected.csv", delimiter=",", names=True, deletechars="")
    table["x[3]"][20] += 0.5
    path = tmp_path / "result.csv"
    np.savetxt(path, table, delimiter="\t", header="\t".join(table.dtype.names), comments="")
    (line,) = judge(folder, path)
    assert line.startswith("wrong, and by no known mistake: x[3] differs first, at 0.3125 s: 2.8"), line
    random = {name: np.random.default_rng(1).normal(size=len(table)) for name in table.dtype.names}
    (line,) = judge(folder, random | {"time": table["time"]})
    assert line.startswith("wrong, and by no known mistake: x[1] differs first, at 0 s: "), line
    # A part of the columns; and of the rows, where nothing else is said.
    lines = judge(folder, {name: table[name] for name in ("time", "x[1]")})
    assert lines[0] == "not judged: no column x[2]" and lines[-1] == "right to the last bit: x[1]"
    lines = judge(folder, {name: table[name][:10] for name in ("time", "x[1]")})
    assert lines == ["wrong: the result ends at 0.140625 s, where it is to end at 1 s"]


PLANTED = {  # in the importer, by case: what the judge says of it
    ("element", "inputs"): "wrong: the input went to the second ball, not to the first",
    ("sign", "nothing"): "wrong: the input had the wrong sign",
    (
        "kept",
        "states",
    ): "wrong: an event was not handled, or the states after it were not read: the solver kept the old",
    ("microsecond", "located"): "wrong: the search for an event ended within a microsecond of it",
    ("queued", "clocks"): "wrong: what belongs to a clock was read at the point after that of its tick",
    # Not among its known mistakes.
    ("weights", "touch"): "wrong: less exact than the case asks for: ",
    ("single", "states"): "wrong: less exact than the case asks for: ",
    ("overrun", "located"): "wrong, and by no known mistake: v[1] differs first, at 0.5 s: 1 where ",
    ("kilonewtons", "inputs"): "wrong, and by no known mistake: x[1] differs first, at 0.2 s: ",
    ("reversed", "arrays"): "wrong, and by no known mistake: x[1] differs first, at 0 s: 0.05 where -0.12 is right",
}


class ThreeEighths(Importer):
    """With Kutta's other method of order 4."""

    def moved(self, time, x, h):
        k1 = self.slopes(time, x)
        k2 = self.slopes(time + h / 3, x + h / 3 * k1)
        k3 = self.slopes(time + 2 * h / 3, x + h * (k2 - k1 / 3))
        return x + h / 8 * (k1 + 3 * k2 + 3 * k3 + self.slopes(time + h, x + h * (k1 - k2 + k3)))


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.exchange and case.fmi == 2])
def test_judge_accepts_other_right_solvers(folders, name, tmp_path):
    (line,) = judge(
        folders[name], ThreeEighths(CASES[name], folders[name] / "cradle.fmu", tmp_path / "unpacked").table()
    )
    assert line.startswith("right "), line


@pytest.mark.parametrize(("mistake", "name"), PLANTED, ids=[mistake for mistake, _ in PLANTED])
def test_judge_finds_planted_mistakes(folders, mistake, name, tmp_path):
    """In an importer that has nothing in common with the judge. Without the mistake its result is right."""
    verdicts = []
    for planted in ("", mistake):
        folder = tmp_path / f"unpacked{planted}"
        verdicts += judge(folders[name], Importer(CASES[name], folders[name] / "cradle.fmu", folder, planted).table())
    right, wrong = verdicts
    assert right.startswith("right "), right
    assert wrong.startswith(PLANTED[mistake, name]), wrong


@pytest.mark.parametrize("name", ["grid", "inputs", "early"])
def test_judge_accepts_six_digits_and_rows_past_the_stop(folders, name):
    table = np.genfromtxt(folders[name] / "expected.csv", delimiter=",", names=True, deletechars="")
    columns = {key: [f"{value:.6g}" for value in table[key]] for key in table.dtype.names}
    columns = {key: [*values, "10.5" if key == "time" else "0"] for key, values in columns.items()}
    (line,) = judge(folders[name], columns)
    assert line.startswith("right within the method: "), line
    few = {key: [*values[:2], *values[-2:]] for key, values in columns.items()}
    (line,) = judge(folders[name], few)
    assert re.fullmatch(r"not judged: no rows at (298 of 301|18 of 21) points, the first at .*", line), line
    columns["x[1]"][2] = ""
    (line,) = judge(folders[name], columns)
    assert line.startswith("wrong, and by no known mistake: x[1] differs first, at "), line
    assert ": '' where -0.0" in line


def test_judge_refuses_what_cannot_be_judged(folders, tmp_path):
    with pytest.raises(InvalidValue, match=r"is not the folder of a case; allowed: .*did you mean grid"):
        judge(tmp_path / "gird", {})
    with pytest.raises(InvalidValue, match=r"none of the columns x\[1\], .*; its columns: time, y"):
        judge(folders["grid"], {"time": [0.0], "y": [1.0]})
    with pytest.raises(InvalidValue, match=r"out of order: after 2 s comes 1\.9 s"):
        judge(folders["grid"], {"time": [0.0, 2.0, 1.9], "x[1]": [1.0, 1.0, 1.0]})
    (tmp_path / "empty.csv").write_text("\n\n")
    with pytest.raises(InvalidValue, match="the file is empty; needed: a line of names, and rows of numbers"):
        judge(folders["grid"], tmp_path / "empty.csv")
    for name in ("inputs", next(name for name, case in CASES.items() if case.start)):
        other = tmp_path / name
        other.mkdir()
        shutil.copy(folders["grid"] / "cradle.fmu", other)
        with pytest.raises(FmuError, match=r"cradle\.fmu is another FMU than that of the case; write the cases anew"):
            judge(other, folders[name] / "expected.csv")


def test_judge_is_called_by_the_program(producer, folders, tmp_path):
    options = ["--python", sys.executable, "--"]
    done = ended(producer, "judge", *options, folders["grid"], folders["grid"] / "expected.csv")
    assert done.stdout.startswith("right to the last bit: x[1]")
    done = ended(producer, "judge", *options, folders["grid"], "nothing.csv", code=2)
    assert "nothing.csv: there is no such file" in done.stderr
    # What cannot be judged is not wrong, which would be code 1.
    case = tmp_path / "grid"
    case.mkdir()
    (case / "cradle.fmu").write_text("damaged")
    done = ended(producer, "judge", *options, case, folders["grid"] / "expected.csv", code=2)
    assert "is not an FMU that can be read" in done.stderr
    done = ended(producer, "judge", "--", "--python", "nothing", code=2)
    assert "cannot run nothing" not in done.stderr


@pytest.fixture(scope="module")
def results(folders, tmp_path_factory):
    """The folder of the cases, and one with a right, a wrong, an incomplete and a short result."""
    cases, results = folders["grid"].parent, tmp_path_factory.mktemp("results")
    for name in ("start", "whole", "inputs", "getters"):
        lines = (cases / name / "expected.csv").read_text().splitlines()
        if name == "inputs":
            lines = [line.rpartition(",")[0] for line in lines]
        if name == "whole":
            lines[2] = lines[2].replace(lines[2].split(",")[1], "7.0")
        (results / f"{name}.csv").write_text("\n".join(lines[: 9 if name == "getters" else None]))
    return cases, results


def test_judge_exit_code_is_the_verdict(producer, results):
    cases, results = results
    judge = [producer, "judge", "--python", sys.executable]
    for name, code, said in (
        ("start", 0, "right to the last bit: x[1], x[2], v[1], v[2]\n"),
        ("whole", 1, "wrong, and by no known mistake: x[1] differs first, at 0.1 s: 7 where "),
        ("inputs", 2, "not judged: no column v[2]\nright to the last bit: x[1], v[1], x[2]\n"),
        ("getters", 1, "wrong: the result ends at 0.7 s, where it is to end at 2 s\n"),
    ):
        done = ended(*judge, cases / name, results / f"{name}.csv", code=code)
        assert done.stdout.startswith(said) and done.stderr == ""
    everything = ended(*judge, cases, results, code=1).stdout.splitlines()
    assert [line.split(":")[0] for line in everything if "there is no such file" not in line] == [
        "inputs", "inputs", "getters", "start", "whole",
    ]  # fmt: skip
    assert f"pair: not judged: {results / 'pair.csv'}: there is no such file" in everything
    (cases / "start/result.csv").write_bytes((results / "start.csv").read_bytes())
    assert "start: right to the last bit" in ended(*judge, cases, code=2).stdout
    assert ended(*judge, cases / "start").stdout.startswith("right")
    (cases / "start/result.csv").unlink()
    refused = ended(*judge, results, results, code=2)
    assert "is not the folder of a case; allowed: folders named grid, " in refused.stderr


def test_judge_escapes_names_beyond_the_locale(producer, results):
    """As Python's standard error does."""
    cases, folder = results
    (other := folder.parent / "Kür\u7b2c").mkdir()
    (other / "start.csv").write_bytes((folder / "start.csv").read_bytes())
    judge = [producer, "judge", cases, other, "--python", sys.executable]
    said = ended(*judge, code=2, env=os.environ | {"PYTHONIOENCODING": "ascii"}).stdout
    assert "start: right to the last bit" in said and r"K\xfcr\u7b2c/grid.csv: there is no such file" in said


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no device that is always full")
def test_judge_output_that_nobody_takes(producer, results):
    """A closed pipe ends it quietly, a full disk with one line."""
    judge = [producer, "judge", results[0] / "start", results[1] / "start.csv", "--python", sys.executable]
    for command in (judge, [producer, "judge", "--help", "--python", sys.executable]):
        with open("/dev/full", "w") as full:
            done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
        assert done.returncode == 1
        assert done.stderr == "error: cannot write to standard output: No space left on device\n"
        read, write = os.pipe()
        os.close(read)
        with open(write, "w") as closed:
            done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True)
        assert (done.returncode, done.stderr) == (0, "")


def expected(host: str) -> dict[str, str]:
    """The verdicts on a host in the document's table, by case, without digits."""
    rows = table("docs/makers/hosts.md", "## The hosts")
    column = rows["case"].index(host)
    return {case.strip("`"): numberless(verdicts[column]) for case, verdicts in rows.items()}


def numberless(text: str) -> str:
    """Rounding is that of a machine and its libraries."""
    return "right" if re.match("same bits|right, ", text) else re.sub(r"[\d.e-]*\d", "#", text)


FMPY, *OTHERS = HOSTS


@pytest.mark.parametrize("host", [FMPY, *(pytest.param(host, marks=pytest.mark.all) for host in OTHERS)])
def test_judge_verdicts_on_hosts_are_those_of_the_document(folders, host):
    """In one case of each kind; trial.py has them all."""
    for name in ("grid", "inputs", "pair", "states", "early", "clocks", "arrays"):
        found = short(verdict(host, folders[name]))
        if "No such file" in found or "cannot be imported" in found:
            pytest.skip(f"{host} is missing")
        assert numberless(found) == expected(host)[name], name
