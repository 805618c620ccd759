"""What is measured in tables of pulses and in samples, without an FMU: sequences, order, overlaps, momentum."""

import newtons_cradle as nc
import numpy as np
import pytest


def pulses(*rows) -> np.ndarray:
    """A pulse table from (contact, onset, release) in s."""
    return np.array([(c, on, off, 1.0, 1.0) for c, on, off in rows], dtype=nc.PULSE)


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


def test_sample_times_lie_on_the_grid_and_in_the_pulses():
    times = nc.sample_times(pulses((1, 0.25, 0.35), (2, 0.95, 1.05)), stop=1.0, step=0.5, per_pulse=3)
    assert times == pytest.approx([0.0, 0.25, 0.3, 0.35, 0.5, 0.95, 1.0])
