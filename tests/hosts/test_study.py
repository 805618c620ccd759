"""The parameter study, small: on local processes, with runs that fail, and on a cluster whose worker is killed."""

import json
import os
import signal
import subprocess
import sys

import newtons_cradle as nc
import pandas as pd
import pytest
from conftest import ROOT, ended
from distributed import LocalCluster

pytestmark = pytest.mark.all

FOLDER = ROOT / "examples/study"
sys.path.insert(0, str(FOLDER))


def study(fmu_path, out, *arguments, code: int = 0) -> subprocess.CompletedProcess:
    """The study as typed, with these axes."""
    command = [sys.executable, FOLDER / "study.py", "--fmu", fmu_path, "--out", out]
    return ended(*command, *arguments, code=code)


def test_study_with_failures(fmu_path, tmp_path):
    """The FMU refuses order 20, and five balls lifted together never touch: the other runs are there."""
    axes = ["--orders", "1", "3", "20", "--dead-bands", "0", "1.6", "--dampings", "0", "--lifted", "1", "5"]
    done = study(fmu_path, tmp_path, "--workers", "2", *axes)
    assert "4 runs succeeded, 8 failed" in done.stdout
    assert "order 20, dead_band 0, damping 0, lifted 1: InvalidValue: " in done.stdout
    assert "contact.exponent = 20" in done.stdout
    assert (tmp_path / "study.png").read_bytes().startswith(b"\x89PNG")
    table = pd.read_csv(tmp_path / "runs.csv")
    assert len(table) == 12
    good = table[table["error"].isna()].set_index(["order", "dead_band"])
    # The overlaps of the paper's experiments, from an independent computation in quadruple precision.
    assert good.loc[(1.0, 0.0), "overlap"] == pytest.approx(0.536, abs=5e-4)
    assert good.loc[(3.0, 0.0), "overlap"] == pytest.approx(0.108, abs=5e-4)
    assert good.loc[(1.0, 1.6), "overlap"] == 0.0
    assert good.loc[(1.0, 1.6), "last_ball"] == pytest.approx(1.0, abs=1e-3)
    assert (good["energy_error"] < 1e-10).all()
    five = table[(table["lifted"] == 5) & (table["order"] == 1.0)]
    assert set(five["error"]) == {"FmuError: no contact ever closes"}


def test_study_that_cannot_start_says_why(fmu_path, tmp_path):
    done = study(fmu_path, tmp_path, "--scheduler", "tcp://127.0.0.1:9", code=1)
    assert done.stderr.splitlines()[-1].startswith("error: ") and "tcp://127.0.0.1:9" in done.stderr


def test_study_refuses_an_axis_without_effect(fmu, fmu_path, tmp_path):
    """A damping that is too small to change a bit of a linear contact; the other axes have their effect, the rows are
    kept, and it is said what they are of."""
    axes = ["--orders", "1", "--dead-bands", "0", "1", "--dampings", "0", "1e-300", "--lifted", "1", "2"]
    done = study(fmu_path, tmp_path, "--workers", "1", *axes, code=1)
    about = json.loads((tmp_path / "about.json").read_text(encoding="utf-8"))
    assert about["guid"] == fmu.description.guid
    assert about["given"]["contact.model"] == "powerLaw" and about["axes"]["order"] == [1.0]
    assert {"fmpy", "numpy", "newtons-cradle", "python"} <= set(about)
    assert done.stderr.splitlines()[-1] == "error: the axis damping has no effect in any run"
    assert len(pd.read_csv(tmp_path / "runs.csv")) == 8 and not (tmp_path / "study.png").exists()


def test_study_loses_nothing_with_a_worker(fmu, fmu_path):
    """On a cluster that was there before. All rows come, each once, with the numbers that a run on its own gives."""
    import one_run
    import study

    axes = dict(zip(study.AXES, ([1.0, 1.5, 2.0, 3.0], [0.0, 0.4, 0.8, 1.2, 1.6], [0.0, 0.2], [1, 2]), strict=True))
    told = []
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        study.connected(cluster.scheduler_address) as client,
    ):
        worker, _ = client.run(os.getpid).values()

        def progress(fraction):
            if told and told[-1] <= 0.25 < fraction:
                os.kill(worker, signal.SIGKILL)
            told.append(fraction)

        found = nc.sweep(axes, one_run.measure, fmu=fmu_path, client=client, progress=progress)
        assert worker not in client.run(os.getpid).values()
    assert not found.errors and len(found.cases) == len(found.results) == 80 and told[-1] == 1.0
    for case, row in list(zip(found.cases, found.results, strict=True))[::20]:
        assert one_run.measure(fmu, case) == row


def test_study_tells_fmus_of_one_name_apart(fmu_path, tmp_path):
    """On workers that have run the first one."""
    with (
        LocalCluster(n_workers=2, threads_per_worker=2, dashboard_address=None) as cluster,
        cluster.get_client() as client,
    ):
        for mass in (0.5, 2.0):
            path = nc.build(set={"ball.mass": mass}, out=tmp_path / "same.fmu", binaries=fmu_path).path
            cases = {"gravity": [9.81, 1.62], "contact.exponent": [1.0, 1.5, 2.0]}
            found = nc.sweep(cases, fmu=path, client=client, stop=0.1, record=["ball.mass"])
            assert found["ball.mass"][:, 0].tolist() == [mass] * 6
        odd = nc.sweep({"a": [1, 2]}, lambda fmu, case: {"b": case["a"]}, fmu=fmu_path, client=client)
        assert odd["b"].tolist() == [1, 2]
