"""Ordinary runs: FMPy's own simulate_fmu, several instances, threads, communication steps."""

from concurrent.futures import ThreadPoolExecutor

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest

SETUPS = [nc.figure5(0.0), nc.figure5(), nc.figure6(), {}]


def same(a: nc.Result, b: nc.Result) -> bool:
    """Bit for bit the same samples and pulses."""
    return a.samples.tobytes() == b.samples.tobytes() and a.pulses.tobytes() == b.pulses.tobytes()


@pytest.fixture(scope="module")
def alone(fmu):
    """Each set-up simulated by itself."""
    return [fmu.simulate(values, stop=3.0) for values in SETUPS]


def test_simulate_fmu_with_no_arguments(fmu, fmu_path, capfd):
    result = fmpy.simulate_fmu(str(fmu_path))
    assert list(result.dtype.names) == ["time", *fmu.outputs]
    assert len(result) == 1001
    assert (result["time"][0], result["time"][-1]) == (0.0, 10.0)
    assert sum(result[f"pulses[{i}]"][-1] for i in range(1, 5)) == 42
    assert result["x[1]"][0] == -0.1
    assert abs(result["x[5]"]).max() == pytest.approx(0.1, rel=1e-3)
    assert capfd.readouterr() == ("", "")


def test_the_helper_and_simulate_fmu_read_the_same_numbers(fmu, fmu_path):
    values = nc.figure5()
    options = {"stop_time": 3.0, "output_interval": 0.01}
    theirs = fmpy.simulate_fmu(str(fmu_path), **options, start_values=fmu.settings(values))
    ours = fmu.simulate(values, stop=3.0)
    for name in ("x[1]", "v[3]", "E_total", "impulse[2]", "F_peak[4]"):
        assert ours[name] == pytest.approx(theirs[name], rel=1e-10, abs=1e-10)


def test_two_runs_of_the_same_set_up_agree_bit_for_bit(fmu, alone):
    assert all(same(fmu.simulate(v, stop=3.0), a) for v, a in zip(SETUPS, alone, strict=True))


def test_two_instances_side_by_side(fmu, alone):
    """Stepped in turn, each goes its own way and logs its own pulses."""
    names = [*fmu.outputs, "E_residual"]
    with fmu.start(SETUPS[0]) as a, fmu.start(SETUPS[2]) as b:
        pair = [(a, a.recorder(names)), (b, b.recorder(names))]
        for i in range(301):
            for run, recorder in pair:
                if i > 0:
                    run.step_to(3.0 * i / 300)
                recorder.sample()
        assert same(pair[0][1].result(), alone[0])
        assert same(pair[1][1].result(), alone[2])


def test_instances_in_threads(fmu, alone):
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(lambda values: fmu.simulate(values, stop=3.0), SETUPS * 3))
    assert all(same(result, alone[i % 4]) for i, result in enumerate(results))


def test_freeing_one_instance_leaves_the_other_alone(fmu, alone):
    with fmu.start(SETUPS[1]) as stays:
        with fmu.start(SETUPS[0]) as goes:
            goes.step_to(0.75)
        stays.step_to(3.0)
        assert stays.pulses.tobytes() == alone[1].pulses.tobytes()


@pytest.mark.parametrize("values", SETUPS)
def test_the_trajectory_does_not_depend_on_the_communication_step(fmu, values):
    """Coarse, fine, uneven and impact-sized steps end in the same bits."""
    names = ["x", "v", "impulse"]
    wanted = None
    for steps in ([5.0], np.linspace(0.005, 5.0, 1000), np.cumsum(np.full(36, 0.1377)), "onsets"):
        with fmu.start(values) as run:
            if isinstance(steps, str):
                while run.get("t_next") < 5.0:
                    run.step_to_onset()
                    run.step_to(run.time + 3e-8)
            else:
                for t in steps:
                    run.step_to(float(t))
            run.step_to(5.0) if run.time < 5.0 else None
            found = [run.get(v) for v in fmu.outputs if v.split("[")[0] in names], run.pulses.tobytes()
        wanted = wanted or found
        assert found == wanted


def test_the_same_experiment_started_later(fmu):
    with fmu.start(nc.figure5(), initialize=False) as run:
        run.initialize(start_time=100.0)
        assert run.get("t_next") - 100.0 == pytest.approx(0.702481589380, abs=1e-9)
        run.step_to(101.0)
        assert nc.pulse_order(run.pulses) == [[2], [1, 3], [2, 4], [3]]


def test_an_input_acts_from_the_next_step_on(fmu):
    """F_ext held constant for one step of a free ball: exactly F h / m more velocity."""
    with fmu.start({"gravity": 0.0} | {f"x_start[{i}]": float(i) for i in range(1, 6)}) as run:
        run.step_to(1.0)
        run.set({"F_ext[5]": 2.0})
        assert run.get("v[5]") == 0.0
        run.step_to(1.5)
        assert run.get("v[5]") == pytest.approx(1.0, rel=1e-12)
        assert run.get("W_external") == pytest.approx(0.5, rel=1e-12)


def test_an_fmu_is_unpacked_where_told(fmu_path, tmp_path):
    folder = tmp_path / "unpacked"
    with nc.Fmu(fmu_path, folder) as opened:
        assert (folder / "binaries").is_dir()
        assert opened.simulate(stop=0.1, step=0.1)["x[1]"][-1] > -0.1
    assert not folder.exists()
