"""When and in which order the contacts close."""

from itertools import pairwise

import newtons_cradle as nc
import numpy as np
import pytest

TABLE1 = [[2], [1, 3], [2, 4], [3]]
MIRRORED = [[3], [2, 4], [1, 3], [2]]
SPEED = np.sqrt(5.0)  # m/s, amplitude 1 m
PULSE = np.pi / np.sqrt(2 * 1e14)  # s, length of a pulse between two balls at k/m = 1e14 1/s2

ONSETS = {  # start values and first onset in s, from an independent computation
    "no dead band": (nc.figure5(0.0), 0.702481473104),
    "figure 5": (nc.figure5(), 0.702481589380),
    "figure 6": (nc.figure6(), 0.702481538397),
    "default parameters": ({}, 0.702493100658),
}


@pytest.mark.parametrize("case", ONSETS)
def test_first_onset(fmu, case):
    """t_next says it from the start, the pulse log afterwards."""
    values, wanted = ONSETS[case]
    with fmu.start(values) as run:
        assert run.get("t_next") == pytest.approx(wanted, abs=1e-9)
        run.step_to(1.0)
        assert run.pulses["onset"][0] == pytest.approx(wanted, abs=1e-9)


def test_a_step_that_ends_at_t_next_contains_the_onset(fmu):
    with fmu.start(nc.figure5()) as run:
        onset = run.step_to_onset(before=1e-9)
        assert run.get("pulses[2]") == 0
        assert run.get("t_next") == onset
        run.step_to(onset)
        assert run.get("pulses[2]") == 1
        assert run.get("t_next") > onset


@pytest.fixture(scope="module")
def separate(fmu):
    """Two impact sequences with the dead band: pulses and micro views."""
    return sequences_of(fmu, nc.figure5())


def sequences_of(fmu, values) -> list[tuple]:
    """(pulses, nanosecond samples of F and v) of the first two impact sequences."""
    names = [f"F[{i}]" for i in range(1, 5)] + [f"v[{i}]" for i in range(1, 6)]
    found = []
    with fmu.start(values) as run:
        for _ in range(2):
            seen = len(run.pulses)
            _, micro = run.zoom(span=1.4e-6, step=1e-9, record=names, before=2e-8)
            found.append((run.pulses[seen:], micro))
    return found


def test_six_separate_pulses_in_the_order_of_table_1(separate):
    pulses, _ = separate[0]
    assert len(pulses) == 6
    assert nc.overlapping_neighbours(pulses) == 0
    assert nc.pulse_order(pulses) == TABLE1
    assert pulses["impulse"] == pytest.approx(SPEED, rel=1e-6)
    assert pulses["peak"] == pytest.approx(SPEED * np.sqrt(1e14 / 2), rel=1e-6)
    assert pulses["release"] - pulses["onset"] == pytest.approx(PULSE, rel=1e-6)


def test_the_moving_balls_step_through_table_1(separate):
    _, micro = separate[0]
    free = np.all(micro.stack("F") == 0, axis=1)
    moving = np.abs(micro.stack("v")[free]) > 0.5 * SPEED
    states = [moving[0], *(b for a, b in pairwise(moving) if np.any(a != b))]
    assert ["".join("01"[int(m)] for m in s) for s in states] == ["11000", "10100", "01010", "00101", "00011"]


def test_the_log_and_the_micro_view_tell_of_the_same_pulses(separate):
    """Sampled forces are zero outside the logged pulses and reach the logged peaks.

    Onset and release are rounded up to a double: at that very time the force may be one of either side.
    """
    pulses, micro = separate[0]
    for i in range(1, 5):
        mine = pulses[pulses["contact"] == i]
        closed = np.zeros(len(micro.samples), dtype=bool)
        inner = ~np.isin(micro["time"], [mine["onset"], mine["release"]])
        for pulse in mine:
            closed |= (micro["time"] > pulse["onset"]) & (micro["time"] < pulse["release"])
        assert np.array_equal((micro[f"F[{i}]"] > 0)[inner], closed[inner])
        assert micro[f"F[{i}]"].max() == pytest.approx(mine["peak"].max(), rel=1e-4)


def test_the_return_stroke_is_the_mirror_image(separate):
    (there, seen), (back, seen_back) = separate
    assert nc.pulse_order(back) == MIRRORED
    assert nc.overlapping_neighbours(back) == 0
    assert back["impulse"] == pytest.approx(there["impulse"], rel=1e-6)
    ends = seen.stack("v")[-1] / SPEED
    assert seen_back.stack("v")[-1][::-1] / SPEED == pytest.approx(-ends, abs=1e-5)


def test_a_mirrored_start_gives_a_mirrored_run(fmu):
    left = nc.figure5(0.0) | {"x_start[2]": -0.7}
    right = left | {f"x_start[{i}]": -left[f"x_start[{6 - i}]"] for i in range(1, 6)}
    a, b = (fmu.simulate(values, stop=3.0) for values in (left, right))
    assert a.stack("x")[:, ::-1] == pytest.approx(-b.stack("x"), abs=1e-12)
    assert len(a.pulses) == len(b.pulses) > 4
    assert sorted(5 - a.pulses["contact"]) == sorted(b.pulses["contact"])


def test_four_overlapping_pulses_without_a_dead_band(fmu):
    pulses, _ = sequences_of(fmu, nc.figure5(0.0))[0]
    assert sorted(pulses["contact"]) == [1, 2, 3, 4]
    assert nc.overlapping_neighbours(pulses) == 3
    lasts = pulses["release"].max() - pulses["onset"].min()
    assert lasts == pytest.approx(5.830036335e-7, rel=1e-6)


def test_default_parameters_give_42_separate_pulses(fmu):
    pulses = fmu.simulate(stop=10.0).pulses
    assert len(pulses) == 42
    sequences = nc.impact_sequences(pulses)
    assert [nc.pulse_order(s) for s in sequences] == [TABLE1, MIRRORED] * 3 + [TABLE1]
    assert all(nc.overlapping_neighbours(s) == 0 for s in sequences)


def test_a_step_over_several_pulses_keeps_their_sums(fmu):
    """One step over a whole sequence: counters, impulse, peak and mean cover all of it."""
    with fmu.start(nc.figure5()) as run:
        run.step_to(0.70)
        run.step_to(0.71)
        log = run.pulses
        for i in range(1, 5):
            mine = log[log["contact"] == i]
            assert run.get(f"pulses[{i}]") == len(mine) == [1, 2, 2, 1][i - 1]
            assert run.get(f"impulse[{i}]") == pytest.approx(mine["impulse"].sum(), rel=1e-12)
            assert run.get(f"F_mean[{i}]") * 0.01 == pytest.approx(mine["impulse"].sum(), rel=1e-9)
            assert run.get(f"F_peak[{i}]") == pytest.approx(mine["peak"].max(), rel=1e-12)
            assert run.get(f"F[{i}]") == 0.0
            assert run.get(f"t_onset[{i}]") == mine["onset"].max()
            assert run.get(f"t_release[{i}]") == mine["release"].max()
