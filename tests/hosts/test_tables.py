"""Tables of other programs: what `cradle-fmu page` and `judge` take alike, what they refuse in words, and how they end."""

import sys

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ended
from newtons_cradle import tables
from newtons_cradle.recording import RecordingError, from_csv
from newtons_cradle.trial import CASES
from newtons_cradle.trial.judge import columns, own_columns

NAMES = ["time", "x[1]", "x[2]", "v[1]", "v[2]", "F[1]"]
TIMES = np.linspace(0.0, 0.1, 11)
ROWS = np.column_stack([TIMES, 0.1 * TIMES, 1.0 + 0.1 * TIMES, *(np.full(11, v) for v in (0.1, 0.1, 0.0))])


def written(separator: str = ",", point: str = ".", head: str = "", names=NAMES, units: str = "") -> str:
    """The table in one of the forms that tools write."""
    rows = [separator.join(f"{value:.6g}".replace(".", point) for value in row) for row in ROWS]
    return "\n".join([*head.splitlines(), separator.join(names), *([units] if units else []), *rows]) + "\n"


FORMS = {
    "commas": written().encode(),
    "semicolons, decimal commas": written(";", ",").encode(),
    "tabs": written("\t").encode(),
    "quoted decimal commas": "".join(f'"{line}"\n' for line in written('","', ",").splitlines()).encode(),
    "Windows": written().replace("\n", "\r\n").encode(),
    "an old Mac": written().replace("\n", "\r").encode(),
    "byte order mark": written().encode("utf-8-sig"),
    "UTF-16": written().encode("utf-16"),
    "UTF-16, little endian": written(";", ",").encode("utf-16-le"),
    "UTF-16, big endian": written().encode("utf-16-be"),
    "comments": written(head="# a run\n\n% of today\n").encode() + b"# the end\n\n",
    "names in a comment": written(names=["# time", *NAMES[1:]]).encode(),
    "Excel": b"sep=;\r\n" + written(";", ",").encode(),
    "units in a line": written(units="s,m,m,m/s,m/s,N").encode(),
    "units behind names": written(names=[f"{name} [SI]" for name in NAMES]).encode(),
    "names of a component": written(names=["Time", *(f'"cradle.{name}"' for name in NAMES[1:])]).encode(),
    "separators at the end": written().replace("\n", ",\n").encode(),
    "other columns": written(names=["time", *NAMES[1:]]).replace("\n", ",text\n").encode(),
}


@pytest.mark.parametrize("form", FORMS)
def test_tables_in_every_form_are_the_same(form, tmp_path):
    path = tmp_path / "result.csv"
    path.write_bytes(FORMS[form])
    run = from_csv(path)
    judged = columns(path, CASES["pair"])
    for name, column in zip(NAMES, ROWS.T, strict=True):
        array, index = name.removesuffix("]").partition("[")[::2]
        drawn = getattr(run, array)
        assert np.allclose(drawn[:, int(index) - 1] if index else drawn, column, rtol=1e-5), name
        assert name not in judged or np.allclose(judged[name], column, rtol=1e-5), name
    assert judged.keys() == {"time", "x[1]", "x[2]"}


def test_tables_with_arrays_in_one_column(tmp_path):
    """As in FMI 3.0: forces have as many elements as there are balls."""
    path = tmp_path / "result.csv"
    rows = [f"{row[0]},{row[1]} {row[2]},{row[3]} {row[4]},{row[5]} 0.0" for row in ROWS]
    path.write_text("\n".join(["time,x,v,F", *rows]))
    run = from_csv(path)
    assert run.x.shape == (11, 2) and run.F.shape == (11, 1) and np.array_equal(run.v[:, 1], ROWS[:, 4])
    assert columns(path, CASES["pair"])["x[2]"] == ROWS[:, 2].tolist()


def test_tables_keep_their_digits():
    for cells, expected in ((["0.5", "-1.25e-3"], 3), (["12", "7"], 0), (["0.00012345"], 5), ([0.5], 17)):
        assert tables.digits({"x": cells}) == expected, cells


#: What is in a file, what the page says of it, and what the judge says.
HUGE = {name: f"time,{name}\n0,1\n1,2\n" for name in ("x[999999999]", "F_peak[10000]")}
AWKWARD = [
    (HUGE["x[999999999]"], r"has a column x\[999999999\]; allowed: up to 10000 balls", "none of the columns"),
    (HUGE["F_peak[10000]"], r"has a column F_peak\[10000\]; allowed: up to 10000 balls", "none of the columns"),
    ("time,x[1],v[1]\n0,1e308,0\n1,1e308,0\n", r"x\[1\] has numbers that cannot be drawn; allowed: finite", None),
    ("time,x[1],v[1]\n0,-inf,0\n1,1,0\n", r"x\[1\] has numbers that cannot be drawn; allowed: finite", None),
    ("time,x[1],v[1]\n0,1_0,0\n", r"line 2: x\[1\] is '1_0'; a number is needed", None),
    ('time,x[1]\n"0,1\n', "line 3: unexpected end of data", "line 3: unexpected end of data"),
    ("", "the file is empty; needed: a line of names", "the file is empty; needed: a line of names"),
    ("time,x[1]\n", "missing: v", "no rows of numbers"),
    ("time,x[1]\n0,1\nnan,1\n", "time has numbers", "out of order: after 0 s comes nan s"),
    ("time,x[1]\n0,1\nlate,1\n", "line 3: time is 'late'; a number is needed", "time = 'late' is refused"),
    ("\0\1\2\xff" * 100, ".", "."),
]


@pytest.mark.parametrize("row", range(len(AWKWARD)))
def test_tables_that_are_awkward_are_refused_in_words(row, tmp_path):
    text, by_page, by_judge = AWKWARD[row]
    path = tmp_path / "result.csv"
    path.write_text(text, encoding="latin-1")
    with pytest.raises((RecordingError, nc.InvalidValue), match=by_page) as refusal:
        from_csv(path)
    assert len(str(refusal.value)) < 400
    if by_judge:
        with pytest.raises(nc.InvalidValue, match=by_judge):
            columns(path, CASES["pair"])


def test_tables_with_an_endless_line_are_refused(tmp_path):
    """Of 100 MB, in a second: it is not cut into cells."""
    path = tmp_path / "result.csv"
    for line in (b"1" * 100_000_000, b"1," * 50_000_000):
        path.write_bytes(b"time,x[1]\n" + line)
        for read in (from_csv, own_columns):
            with pytest.raises(nc.InvalidValue, match="line 2: 100000000 characters; allowed: 16777216"):
                read(path)


def test_help_is_of_the_command(producer):
    for command, says in (
        (
            "judge",
            [
                "usage: cradle-fmu judge [-h] CASE [RESULT.csv]",
                "Exit codes: 0 right; 1 wrong, or standard output takes no verdict; 2 not judged",
            ],
        ),
        ("page", ["usage: cradle-fmu page [-h]", "--pulses FILE.csv"]),
        ("cases", ["usage: cradle-fmu cases [-h] -o FOLDER", "--from FILE.fmu"]),
        ("live", ["usage: cradle-fmu live [-h]", "--site FOLDER"]),
    ):
        for option in ("--help", "-h"):
            said = " ".join(ended(producer, command, option, "--python", sys.executable).stdout.split())
            assert all(part in said for part in [*says, "--python PROGRAM"]), said
