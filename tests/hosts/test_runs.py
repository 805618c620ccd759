"""Runs through FMPy: its own simulate_fmu, instances in threads, communication steps, saved states, and what a
click looks like; what is measured in tables of pulses and in samples, without an FMU.

The laws themselves are checked in tests/rust, without a host.
"""

import gc
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from functools import partial

import fmpy
import newtons_cradle as nc
import numpy as np
import pytest
from newtons_cradle.pulses import pulse_table
from newtons_cradle.run import calls, log

HERTZ = nc.figure5(0.0) | {"contact.model": "hertz", "contact.dampingLaw": "huntCrossley"}
SETUPS = {
    "separate pulses": nc.figure5(),
    "overlapping pulses": nc.figure5(0.0),
    "Hertz, damped": HERTZ | {"contact.huntCrossley": 0.3, "pendulum.drag": 0.1},
    "rigid, lasting contacts": nc.figure5(0.0)
    | {"contact.model": "rigid", "contact.restitution": 0.5, "pendulum.lengthRatio[3]": 1.1, "F_ext[5]": -3},
    "adams": nc.power_law(1e8) | {"solver.method": "adams"},
}
TABLE1 = [[2], [1, 3], [2, 4], [3]]
MIRRORED = [[3], [2, 4], [1, 3], [2]]


def test_fmpy_simulates_without_arguments(fmu, fmu_path, capfd):
    result = fmpy.simulate_fmu(str(fmu_path))
    kinds = ["Real", "Integer", "Boolean"]
    by_kind = sorted(fmu.outputs, key=lambda name: kinds.index(fmu.variables[name].type))
    assert list(result.dtype.names) == ["time", *by_kind]
    assert len(result) == 1001
    assert (result["time"][0], result["time"][-1]) == (0.0, 10.0)
    assert sum(result[f"pulses[{i}]"][-1] for i in range(1, 5)) == 42
    assert result["x[1]"][0] == -0.1
    assert abs(result["x[5]"]).max() == pytest.approx(0.1, rel=1e-3)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("setup", SETUPS.values(), ids=SETUPS)
def test_fmpy_and_the_package_read_the_same_numbers(fmu, fmu_path, setup):
    theirs = fmpy.simulate_fmu(str(fmu_path), stop_time=3.0, output_interval=0.01, start_values=fmu.settings(setup))
    ours = fmu.simulate(setup, stop=3.0)
    for name in ("x[1]", "v[3]", "E_total", "impulse[2]", "F_peak[4]"):
        assert ours[name] == pytest.approx(theirs[name], rel=1e-10, abs=1e-10)
    assert nc.energy_error(ours) <= (1e-6 if "solver.method" in setup else 1e-10)


def test_saved_state_can_be_loaded_again_and_again(fmu):
    with fmu.start(nc.figure5()) as run, fmu.start() as other:
        run.step_to(0.6)
        saved = run.save()
        run.step_to(1.0)
        wanted = run.get("E_residual")
        for target in (run, other, other):
            target.load(saved)
            assert target.time == 0.6
            target.step_to(1.0)
            assert target.get("E_residual") == wanted


def test_saved_state_has_what_belongs_to_the_last_step(fmu, fmu3):
    """Also where it was so long that it was made in parts: means and peaks are of all of it."""
    names = ["F_mean", "F_peak", "F_support_mean"]
    for either in (fmu, fmu3):
        for end in (0.72, 3.0):
            with either.start() as run, either.start() as other:
                run.step_to(end)
                saved, wanted = run.save(), [run[name] for name in names]
                run.step_to(end + 0.5)
                for target in (run, other):
                    target.load(saved)
                    assert all(np.array_equal(target[name], value) for name, value in zip(names, wanted, strict=True))


@pytest.mark.parametrize("driven", [{"der(F_ext[1])": 0.1}, {"solver.method": "adams"}])
def test_saved_state_continues_in_another_run_to_the_bit(fmu3, driven):
    """Also where its steps must not be made in parts."""
    with fmu3.start(driven) as run, fmu3.start() as other:
        run.step(0.5)
        other.load(run.save())
        for each in (run, other):
            each.step(5.0)
        assert run["x"].tolist() == other["x"].tolist()


def test_run_until_takes_numbers_of_any_kind(fmu):
    for t, step in ((Decimal(1), Decimal("0.25")), (np.float32(1.0), np.float32(0.25)), (1, 0.25)):
        with fmu.start() as run:
            assert [*run.until(t, step), run.time] == [0.0, 0.25, 0.5, 0.75, 1.0] and type(run.time) is float
    with fmu.start() as run:
        step = np.float32(0.01)
        assert [*run.until(1.0, step)] == [k * float(step) for k in range(101)]


def test_log_that_was_cleared_tells_errors(fmu, fmu3):
    for either in (fmu, fmu3):
        with either.start() as run:
            for damping in (-1.0, -2.0):
                run.step(2.0)
                with pytest.raises(nc.InvalidValue, match=rf"contact.damping = {damping:g} N\.s/m is refused"):
                    run.set({"contact.damping": damping})
                assert len(run.log) > 0 and len(run.pulses) > 0
                run.log.clear()
                assert len(run.log) == len(run.pulses) == 0


def test_log_is_parsed_once(fmu, fmu3, monkeypatch):
    parsed = []
    monkeypatch.setattr(log, "pulse_table", lambda text: parsed.append(len(text)) or pulse_table(text))
    for either in (fmu, fmu3):
        with either.start(nc.figure5(0.0)) as run:
            for _ in run.until(5.0, 0.1):
                pulses, lines = run.pulses, list(run.log)
                pulses["peak"] = 0.0  # a copy
            assert run.pulses.tobytes() == pulse_table(run.log.text()).tobytes() and len(run.pulses) > len(pulses) > 0
            assert sum(parsed) == len(run.log.text()) and len(parsed) < 10
            assert list(run.log)[: len(lines)] == lines and str(run.pulses).startswith("contact")
        parsed.clear()


def test_run_that_is_dropped_frees_its_instance(fmu, fmu3):
    """Unless somebody has FMPy's object."""
    freed = []

    def end(free, lent):
        freed.append(lent)
        free()

    for either in (fmu, fmu3):
        freed.clear()
        for lent in (False, True):
            run = either.start()
            slave = run.slave if lent else None
            own = run._instance
            own.freeInstance = partial(end, own.freeInstance, lent)
            run = None
            gc.collect()
            assert freed == [False] and (slave is None or slave.get("x[1]") == -0.1)


def test_samples_do_not_ask_an_fmu_for_its_time(fmu, monkeypatch):
    """Not all tell it; and rows are added in between."""
    wanted = fmu.simulate(stop=6.0, record=["x"])
    monkeypatch.setattr(calls.Calls, "time", lambda *_: 1 / 0)
    with fmu.start() as run:
        recorder = run.recorder(["x"])
        recorder.sample()
        recorder.steps(wanted.time[1:].tolist())
        assert recorder.result() == wanted


def test_threads_keep_their_own_pulses(fmu):
    few = [nc.figure5(0.0), nc.figure5(), nc.preset("figure6"), {}]
    alone = [fmu.simulate(values, stop=3.0).pulses.tobytes() for values in few]
    with ThreadPoolExecutor(4) as pool:
        found = pool.map(lambda values: fmu.simulate(values, stop=3.0).pulses.tobytes(), 3 * few)
        assert list(found) == 3 * alone


@pytest.mark.parametrize(
    ("values", "onset"),  # s, from an independent computation
    [
        (nc.figure5(0.0), 0.702481473104),
        (nc.figure5(), 0.702481589380),
        (nc.preset("figure6"), 0.702481538397),
        ({}, 0.702493100658),
    ],
)
def test_onset_of_the_first_contact(fmu, values, onset):
    """t_next says it from the start, the pulse log afterwards; a step that ends there contains it; a later start
    shifts it."""
    with fmu.start(values) as run:
        ahead = run.step_to_onset(before=1e-9)
        assert run.get("t_next") == ahead == pytest.approx(onset, abs=1e-9)
        assert run.get("pulses[2]") == 0
        run.step_to(ahead)
        assert run.get("pulses[2]") == 1 and run.get("t_next") > ahead
        run.step_to(1.0)
        assert run.pulses["onset"][0] == ahead
    with fmu.start(values, initialize=False) as run:
        run.initialize(start_time=100.0)
        assert run.get("t_next") - 100.0 == pytest.approx(onset, abs=1e-9)


def test_pulses_of_the_log_are_those_of_the_micro_view(fmu):
    """Six pulses in the order of Table 1, and mirrored on the way back. Sampled forces are zero outside them and
    reach their peaks; at onset and release, which are rounded up to a double, the force may be one of either side."""
    names = [f"F[{i}]" for i in range(1, 5)]
    with fmu.start(nc.figure5()) as run:
        _, micro = run.zoom(span=1.4e-6, step=1e-9, record=names, before=2e-8)
        pulses = run.pulses
        run.step_to(2.5)
        clicks = nc.impact_sequences(run.pulses)
    assert [nc.pulse_order(click) for click in clicks] == [TABLE1, MIRRORED]
    assert all(nc.overlapping_neighbours(click) == 0 for click in clicks)
    assert pulses["impulse"] == pytest.approx(np.sqrt(5.0), rel=1e-6)
    for i in range(1, 5):
        mine = pulses[pulses["contact"] == i]
        inner = ~np.isin(micro["time"], [mine["onset"], mine["release"]])
        spans = [(micro["time"] > pulse["onset"]) & (micro["time"] < pulse["release"]) for pulse in mine]
        assert np.array_equal((micro[f"F[{i}]"] > 0)[inner], np.any(spans, axis=0)[inner])
        assert micro[f"F[{i}]"].max() == pytest.approx(mine["peak"].max(), rel=1e-4)


def test_pulses_have_their_peak_in_both_versions(fmu, fmu3):
    """In an elastic impact of two, half way."""
    start = nc.lifted(1) | {"contact.deadBand": 1e-4}
    two, three = (opened.simulate(start, stop=1.5, record=[]).pulses for opened in (fmu, fmu3))
    assert two.tobytes() == three.tobytes() and len(two) == 4
    middle, length = 0.5 * (two["onset"] + two["release"]), two["release"] - two["onset"]
    assert np.abs(two["peak_time"] - middle).max() < 1e-15 and length.min() > 1e-7
    for line in (
        "contact=1 onset=1 release=2 peak=3 impulse=4",
        "contact=1 onset=1 release=2 peak=3 impulse=4 peakTime=5",
    ):
        read = nc.parse_pulse(line)
        assert read[:5] == (1, 1.0, 2.0, 3.0, 4.0) and (read[5] == 5.0) == ("peakTime" in line)


def pulses(*rows) -> np.ndarray:
    """A pulse table from (contact, onset, release) in s."""
    return np.array([(c, on, off, 1.0, 1.0, on) for c, on, off in rows], dtype=nc.PULSE)


def test_sequences_are_cut_at_pauses_and_not_within_a_long_pulse():
    table = pulses((1, 0.0, 0.5), (2, 0.1, 0.2), (2, 0.505, 0.6), (1, 1.0, 1.1))
    assert [list(s["onset"]) for s in nc.impact_sequences(table)] == [[0.0, 0.1, 0.505], [1.0]]
    assert nc.impact_sequences(pulses()) == []


def test_order_groups_simultaneous_onsets():
    table = pulses((3, 1.0001, 2.0), (1, 1.0, 2.0), (2, 0.0, 0.9), (2, 2.5, 3.0))
    assert nc.pulse_order(table) == [[2], [1, 3], [2]]


def test_only_pulses_that_share_a_ball_can_overlap():
    assert nc.overlapping_neighbours(pulses((1, 0.0, 1.0), (3, 0.0, 1.0))) == 0
    assert nc.overlapping_neighbours(pulses((1, 0.0, 1.0), (2, 0.9, 2.0), (3, 1.9, 3.0))) == 2
    assert nc.overlapping_neighbours(pulses((1, 0.0, 1.0), (2, 1.0, 2.0))) == 0


def test_the_momentum_of_a_sequence_shows_a_missing_impulse():
    """Two balls' worth of momentum against the support's: a defect is found where it was put."""
    columns = [0.0, 0.1, 0.2, 0.3], [0, -1, -2.5, -3.5], [0, 10, 10, 10]
    samples = np.rec.fromarrays(columns, names="time, p_total, F_support_mean")
    result = nc.Result(samples, pulses((1, 0.15, 0.151)))
    assert nc.momentum_of_sequences(result) == pytest.approx([-0.5])


def test_overlap_of_neighbouring_pulses():
    """Triangles of height 1 and length 2 that begin one after the other share a quarter of their impulse."""
    time = np.linspace(0.0, 3.0, 301)
    triangle = [np.clip(1 - np.abs(time - middle), 0, None) for middle in (1.0, 2.0)]
    samples = np.rec.fromarrays([time, *triangle, np.zeros(301)], names="time, F[1], F[2], F[3]")
    assert nc.overlaps(nc.Result(samples, pulses())) == pytest.approx([0.25, 0.0])


def test_samples_lie_on_the_grid_and_in_the_pulses():
    times = nc.sample_times(pulses((1, 0.25, 0.35), (2, 0.95, 1.05)), stop=1.0, step=0.5, per_pulse=3)
    assert times == pytest.approx([0.0, 0.25, 0.3, 0.35, 0.5, 0.95, 1.0])
