"""The helpers themselves, without an FMU: log lines, sequences, order, counts of the test command."""

import sys

import newtons_cradle as nc
import numpy as np
import pytest
from suite import EXPECTED_SKIPS, Results, counts


def pulses(*rows) -> np.ndarray:
    """A pulse table from (contact, onset, release) in s."""
    return np.array([(c, on, off, 1.0, 1.0) for c, on, off in rows], dtype=nc.PULSE)


PULSE = "contact=3 onset=0.70248147310409812 release=7.0248200000000001e-01 peak=1.5e7 impulse=2.25"
OTHERS = ["", "contact=3 onset=", "solver: 12 steps", "contact=x onset=1 release=2 peak=3 impulse=4"]


def test_log_lines_of_pulses_become_rows():
    assert nc.parse_pulse(PULSE) == (3, 0.70248147310409812, 0.702482, 1.5e7, 2.25)
    assert [nc.parse_pulse(line) for line in OTHERS] == [None] * len(OTHERS)


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
    time = np.array([0.0, 0.1, 0.2, 0.3])
    dtype = [("time", "f8"), ("p_total", "f8"), ("F_support_mean", "f8")]
    samples = np.array(list(zip(time, [0, -1, -2.5, -3.5], [0, 10, 10, 10], strict=True)), dtype=dtype)
    result = nc.Result(samples, pulses((1, 0.15, 0.151)))
    assert nc.momentum_of_sequences(result) == pytest.approx([-0.5])


def test_overlap_of_neighbouring_pulses():
    """Triangles of height 1 and length 2 that begin one after the other share a quarter of their impulse."""
    time = np.linspace(0.0, 3.0, 301)
    triangle = [np.clip(1 - np.abs(time - middle), 0, None) for middle in (1.0, 2.0)]
    dtype = [("time", "f8"), ("F[1]", "f8"), ("F[2]", "f8"), ("F[3]", "f8")]
    samples = np.array(list(zip(time, *triangle, np.zeros(301), strict=True)), dtype=dtype)
    assert nc.overlaps(nc.Result(samples, pulses())) == pytest.approx([0.25, 0.0])


def test_sample_times_lie_on_the_grid_and_in_the_pulses():
    times = nc.sample_times(pulses((1, 0.25, 0.35), (2, 0.95, 1.05)), stop=1.0, step=0.5, per_pulse=3)
    assert times == pytest.approx([0.0, 0.25, 0.3, 0.35, 0.5, 0.95, 1.0])


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("test result: FAILED. 12 passed; 1 failed; 2 ignored; 0 measured; finished in 0.01s", (12, 1, 2)),
        ("=== 2 failed, 34 passed, 1 skipped, 1 error in 5.01s (0:00:05) ===", (34, 3, 1)),
        ("SKIPPED advisories: their database cannot be reached", (0, 0, 1)),
        ("SKIPPED [3] tests/hosts/test_x.py:50: fmi-sim is missing", None),
        ("tests/hosts/test_x.py ..... [100%]", None),
        ("running 3 tests", None),
    ],
)
def test_counts_of_the_runners(line, wanted):
    assert counts(line) == wanted


def test_results_of_lanes_are_added_up_and_failures_named():
    results = Results()
    skipped = "SKIPPED [3] tests/hosts/test_x.py:50: fmi-sim is missing"
    lines = [skipped, "FAILED tests/hosts/test_x.py::test_y - boom", "=== 1 failed, 3 skipped in 1.0s ==="]
    command = [sys.executable, "-c", f"print(*{lines!r}, sep='\\n'); raise SystemExit(1)"]
    results.beside(
        lane=lambda part: part.step("Hosts", command),
        other=lambda part: part.step("Quiet", [sys.executable, "-c", ""]),
    )
    results.skip("Licences", EXPECTED_SKIPS[0])
    assert (results.passed, results.failed, results.skipped) == (1, 1, 4)
    assert any("test_x.py::test_y - boom" in remark for remark in results.remarks)
    assert results.unexpected_skips() == [skipped]
