"""Recordings: what the command and `Result.page` take, and what they refuse in words."""

import base64
import hashlib
import os
import pickle
import sys
import threading
from dataclasses import replace
from functools import partial
from zipfile import ZipFile

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ended
from fmpy import simulate_fmu
from fmpy.util import write_csv
from newtons_cradle import __main__, files
from newtons_cradle.page import filled, save_page
from newtons_cradle.recording import RecordingError, from_csv, known_of
from newtons_cradle.trial.cases import CASES
from newtons_cradle.trial.judge import columns

pytestmark = pytest.mark.all


@pytest.fixture
def page(monkeypatch, capsys):
    """The command that makes a page; asserts that it does, or what it is refused for."""

    def make(*arguments, refused="") -> None:
        monkeypatch.setattr(sys, "argv", ["newtons_cradle", "page", *map(str, arguments)])
        assert bool(__main__.main()) == bool(refused)
        said = capsys.readouterr().err
        assert said.startswith("error: " if refused else "") and refused in said

    return make


def test_recording_by_the_producer_is_the_same_page(producer, fmu_path, tmp_path):
    """`cradle-fmu page` is the same command."""
    one, two = tmp_path / "one.html", tmp_path / "two.html"
    options = [fmu_path, "--stop", "1", "--set"]
    ended(sys.executable, "-m", "newtons_cradle", "page", *options, "contact.model=hertz", "--out", one)
    command = [producer, "page", "--python", sys.executable]
    ended(*command, *options, "contact.model=2", "--out", two)  # an enumeration by the number of its item
    assert one.read_bytes() == two.read_bytes()
    failed = ended(*command, "missing.fmu", code=2)
    assert failed.stderr.startswith("error: ") and "import" not in failed.stderr


ONE, TWO = "time,x[1],v[1]\n", "time,x[1],x[2],v[1],v[2],F[1]\n"
NO_TABLE = "this is not a table of a run: its first line must name time, x[1], ..., separated by commas"


#: What is in a file, what a command says of it, and what the page says where it has words of its own.
REFUSED = [
    ("", "the file is empty; needed: a line of names, and rows of numbers", NO_TABLE),
    ("time;x[1]\n0;1\n", "is incomplete; missing: v[1]", NO_TABLE),
    ("time,y\n0,1\n1,2\n", "missing: x[1], v[1]"),
    (ONE + "0,1,0\n1,1,0\n", "has only one ball. If the cradle has one, say `--balls 1`"),
    ("time,x[1],x[3],v[1],v[2],v[3],F[1],F[2]\n0,1,1,0,0,0,0,0\n", "of 3 balls is incomplete; missing: x[2]"),
    (
        "time,x[1],F_peak[4]\n0,1,1\n",
        "of 5 balls is incomplete; missing: x[2], x[3], x[4], x[5], v[1], v[2], ...",
    ),
    (TWO.replace(",F[1]", "") + "0,1,2,3,4\n", "the result of 2 balls is incomplete; missing: F[1]"),
    (TWO.replace("F[1]", "F[1],F[2]") + "0,1,2,3,4,0,0\n", "of 3 balls is incomplete; missing: x[3], v[3]"),
    (TWO + "0,1,2,3,4,0\n", "at least two rows are needed, with times that rise"),
    (TWO + "0,1,2,3,4,0\n0,1,2,3,4,0\n", "at least two rows are needed, with times that rise"),
    (
        "time,x[1]\n0,1\n1,red\n",
        "line 3: x[1] is 'red'; a number is needed",
        "in line 3, “red” is not a number",
    ),
    ("time,x[1]\n0,1\n1,2,3\n", "line 3: 3 numbers for 2 names", "line 3 has 3 numbers for 2 names"),
    (
        "time,x[1]\n0,1\n1,nan\n",
        "x[1] has numbers that cannot be drawn; allowed: finite ones up to 1e+30",
        "in line 3, “nan” is not a number",
    ),
]


@pytest.mark.parametrize(("text", "complaint"), [row[:2] for row in REFUSED])
def test_recording_refuses_bad_results_in_words(page, tmp_path, text, complaint):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    page(path, refused=complaint)
    assert not path.with_suffix(".html").exists()


def saved(folder, result, names=None):
    """A result, or some of its columns, as FMPy writes it."""
    path = folder / "result.csv"
    write_csv(path, result if names is None else result[["time", *names]])
    return path


@pytest.fixture(scope="module")
def fine(fmu_path):
    """Three seconds of the default experiment as FMPy runs it, in steps of 10 ms."""
    return simulate_fmu(fmu_path, stop_time=3.0, output_interval=0.01)


def test_recording_refuses_coarse_results(fmu_path, fine, tmp_path):
    """The needed step that the refusal names is fine enough."""
    coarse = saved(tmp_path, simulate_fmu(fmu_path, stop_time=6.0, output_interval=0.25))
    wanted = r"too coarse. The samples at t = [\d.]+ s are 0.25 s apart, and ball \d cannot be followed"
    with pytest.raises(RecordingError, match=wanted) as refusal:
        from_csv(coarse)
    needed = float(str(refusal.value).split("at most about ")[1].removesuffix(" s apart"))
    assert 0.02 <= needed < 0.25
    again = saved(tmp_path, simulate_fmu(fmu_path, stop_time=6.0, output_interval=needed))
    assert len(from_csv(again).pulses) > 0
    assert len(from_csv(saved(tmp_path, fine)).pulses) == 8


def test_recording_refuses_forces_that_miss_the_clicks(fmu, fine, tmp_path):
    """Without F_peak or a table of pulses, steps of 10 ms show none; samples in every pulse do."""
    names = [f"{name}[{i}]" for name in "xv" for i in range(1, 6)] + [f"F[{i}]" for i in range(1, 5)]
    wanted = "for the clicks. Ball 1 is struck between t = 0.7 s and 0.71 s, and F is 0 at both. Needed: F_peak"
    with pytest.raises(RecordingError, match=wanted):
        from_csv(saved(tmp_path, fine, names))
    pulses = tmp_path / "pulses.csv"
    run = fmu.simulate(stop=3.0)
    np.savetxt(pulses, run.pulses, delimiter=",", header=",".join(run.pulses.dtype.names), comments="")
    assert (
        from_csv(saved(tmp_path, fine, names), pulses).pulses["peak_time"].tolist() == run.pulses["peak_time"].tolist()
    )
    assert len(run.pulses) == 12
    named = pulses.read_text().replace("peak_time", "peakTime")
    pulses.write_text(named)
    assert (
        from_csv(saved(tmp_path, fine, names), pulses).pulses["peak_time"].tolist() == run.pulses["peak_time"].tolist()
    )
    np.savetxt(
        pulses,
        run.pulses[list(nc.PULSE.names[:5])].tolist(),
        delimiter=",",
        header=",".join(nc.PULSE.names[:5]),
        comments="",
    )
    assert np.isnan(from_csv(saved(tmp_path, fine, names), pulses).pulses["peak_time"]).all()
    resolved = nc.resolved(fmu, stop=3.0, record=names)
    assert len(from_csv(saved(tmp_path, resolved.samples)).pulses) == 12


def test_recording_refuses_pulses_of_another_cradle(fine, tmp_path):
    pulses = tmp_path / "pulses.csv"
    pulses.write_text("contact,onset,release,peak,impulse\n7,0.1,0.2,1,1\n")
    with pytest.raises(RecordingError, match="pulses of contacts 7 to 7; 5 balls have contacts 1 to 4"):
        from_csv(saved(tmp_path, fine), pulses)
    pulses.write_text("contact,onset,release\n1,0.1,0.2\n")
    with pytest.raises(RecordingError, match=r"a table of pulses has the columns .*; missing: peak, impulse"):
        from_csv(saved(tmp_path, fine), pulses)


def test_recording_of_one_ball(page, tmp_path):
    time = np.linspace(0.0, 3.0, 301)
    path = tmp_path / "one.csv"
    table = np.column_stack([time, np.cos(2 * time), -2 * np.sin(2 * time)])
    np.savetxt(path, table, delimiter=",", header="time,x[1],v[1]", comments="")
    page(path, "--balls", 2, refused="missing: x[2], v[2], F[1]")
    page(path, "--balls", 1)
    assert from_csv(path, balls=1).F.shape == (301, 0)
    page(path, "--balls", 0, refused="balls = 0 is refused; allowed: a whole number from 1 to 10000")
    page(path, "--balls", 1, "--radius", 0, refused="radius = 0.0 is refused; allowed: a positive number (m)")


def test_recording_escapes_names(fine, tmp_path):
    """Neither as text nor in the data, where `<!--<script` would hide the end of the script."""
    page = tmp_path / "page.html"
    save_page(page, replace(from_csv(saved(tmp_path, fine)), title="<!--<script>alert(1)</script>"))
    text = page.read_text(encoding="utf-8")
    assert "alert(1)" in text and "<script>alert" not in text and "alert(1)<" not in text


def test_security_policy_runs_no_script_among_the_parts(tmp_path):
    """The policy knows the scripts and styles of the template only, with what fills them."""
    template = tmp_path / "template.html"
    template.write_text('<meta content="{{scripts}} {{styles}}"><style>a</style><script>{{own}}</script>{{text}}')
    page = filled(template, {"own": "good()", "text": "<style>b</style><script>bad()</script>{{own}}"})
    good, style = (base64.b64encode(hashlib.sha256(part).digest()).decode() for part in (b"good()", b"a"))
    head = f"<meta content=\"'sha256-{good}' 'sha256-{style}'\">"
    assert page == f"{head}<style>a</style><script>good()</script><style>b</style><script>bad()</script>{{{{own}}}}"


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["missing.csv"], "missing.csv: there is no such file\n"),
        (["missing.fmu"], "missing.fmu: there is no such file\n"),
        (["README.md"], "only .fmu and .csv files can be shown"),
        (["FMU", "--stop", "100000"], "--stop 100000 is refused; allowed: up to 3600 s, more with --force"),
        (["FMU", "--out", "nowhere/x.html"], "--out: there is no folder nowhere"),
        (["FMU", "--out", "."], "--out: . is a folder; allowed: a regular file"),
        (["FMU", "--set", "foo=1"], "has no variable 'foo'"),
        (["FMU", "--set", "ball.mass=-1"], "ball.mass = -1 kg is refused"),
        (["FMU", "--set", "ball.mass=heavy"], "ball.mass = heavy is not a number"),
        (["FMU", "--set", "contact.model=glue"], "contact.model = glue is refused; allowed: powerLaw, hertz"),
    ],
)
def test_recording_command_refuses_in_words(page, fmu_path, arguments, complaint):
    page(*(fmu_path if argument == "FMU" else argument for argument in arguments), refused=complaint)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes with names")
def test_recording_reads_and_replaces_only_regular_files(tmp_path, monkeypatch):
    """A device may have no end, and a pipe waits for its other end."""
    link, pipe = tmp_path / "link.csv", tmp_path / "pipe.csv"
    link.symlink_to(os.devnull)
    os.mkfifo(pipe)
    for use in (nc.Fmu, from_csv, partial(columns, case=CASES["pair"]), files.in_folder):
        # Were the pipe opened, this would be what is read.
        writer = threading.Thread(target=pipe.write_text, args=["text"], daemon=True)
        writer.start()
        for path in (link, pipe):
            with pytest.raises(nc.InvalidValue, match=f"{path.name} is a device, a pipe or a socket; allowed: a reg"):
                use(path)
        assert pipe.read_text() == "text"
        writer.join()
    large = tmp_path / "large.csv"
    large.write_text("time,x[1]\n")
    monkeypatch.setattr(files, "LARGEST", 9)
    with pytest.raises(nc.InvalidValue, match=r"large\.csv is too large; allowed: at most 9 bytes"):
        from_csv(large)


def test_live_site_is_a_folder(monkeypatch, live_path, capsys):
    for folder, code, said in (
        (live_path, 2, f"error: --site: {live_path} is a file; name a folder"),
        (live_path.parent / "site", 0, "MB): put this folder on a web server"),
    ):
        monkeypatch.setattr(sys, "argv", ["newtons_cradle", "live", "--site", str(folder)])
        assert __main__.main() == code
        assert said in "".join(capsys.readouterr())


def test_recording_refuses_other_fmus(page, fmu_path, fmu3, tmp_path):
    path = tmp_path / "other.fmu"
    another = "the model Other; allowed: FMI 2.0 for co-simulation, or NewtonsCradle of FMI 3.0"
    for fmu, old, new, complaint in (
        (fmu_path, 'name="x[', 'name="z[', "other.fmu: the FMU is no cradle; missing: x[1]\n"),
        (fmu_path, "binaries/", "binaries/mars-", f"only; this machine needs {fmpy.platform}\n"),
        (fmu3.path, 'modelName="NewtonsCradle"', 'modelName="Other"', f"an FMU of FMI 3.0, {another}\n"),
    ):
        with ZipFile(fmu) as source, ZipFile(path, "w") as target:
            for name in source.namelist():
                text = source.read(name).replace(old.encode(), new.encode())
                target.writestr(name.replace(old, new), text)
        page(path, refused=complaint)


def test_results_have_a_page(fmu, tmp_path):
    """What is missing or too coarse is said."""
    path = tmp_path / "result.html"
    for options, complaint in (
        ({"record": ["x"]}, r"the result of 5 balls is incomplete; missing: v\[1\], v\[2\]"),
        ({"step": 0.5}, "too coarse. The samples at t = 0.5 s are 0.5 s apart"),
    ):
        with pytest.raises(RecordingError, match=f"the result: {complaint}"):
            fmu.simulate(stop=1.0, **options).page(path)
    assert not path.exists()
    start = nc.lifted(1, amplitude=0.05)
    result = fmu.simulate(start | {"contact.model": "hertz", "ball.massRatio[2]": 2.0}, stop=1.0)
    assert result.page(path) == path.stat().st_size > 100_000
    known = known_of(result.model, result.given)
    assert known["start"]["contact.model"] == "hertz" and known["start"]["ball.massRatio"] == [1, 2, 1, 1, 1]
    assert ("ball.massRatio[i]", "1, 2, 1, 1, 1", "", "") in known["parameters"]
    assert known_of(result.model, result.given | {"F_ext[1]": 1.0})["start"] is None
    assert pickle.loads(pickle.dumps(result)).page(path) > 100_000  # without what only this process knows
