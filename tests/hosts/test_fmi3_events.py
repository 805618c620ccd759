"""Event mode, clocks, early return and intermediate update of FMI 3.0, through FMPy."""

import itertools
import math

import newtons_cradle as nc
import numpy as np
import pytest
from fmi3_host import BOTH


def pulses(lines):
    """The pulses of the log: contact, onset, release, peak, impulse, time of the peak."""
    return [nc.parse_pulse(line.text) for line in lines if line.category == "logEvents"]


@pytest.mark.parametrize("options", [BOTH, {"eventModeUsed": True}])
def test_clocks_tick_once_for_each_pulse_of_ten_minutes(make3, options):
    cradle = make3(nc.preset("figure6"), **options)
    ticks = [*cradle.told, *(tick for i in range(6) for tick in cradle.walk(100.0 * i, 100.0 * (i + 1)))]
    log = pulses(cradle.lines)
    onsets, releases = ([tick[edge] for tick in ticks if edge in tick] for edge in ("onset", "release"))
    ended = [(time, *pulse) for time, which in releases for pulse in which]
    assert len(ended) == len(log) == sum(len(which) for _, which in onsets) == 2562
    # Order, times and values are those of the log.
    told = [(time, contact + 1, *of_peak, impulse) for time, contact, impulse, *of_peak, _ in ended]
    assert told == sorted((off, contact, peak, at, impulse) for contact, _, off, peak, impulse, at in log)
    assert sorted(time for time, which in onsets for _ in which) == sorted(onset for _, onset, *_ in log)
    assert all(later[0] > earlier[0] for earlier, later in itertools.pairwise(onsets))
    for contact, impulse in enumerate(cradle.get("impulse")[:-1]):
        assert math.fsum(pulse[2] for pulse in ended if pulse[1] == contact) == impulse
    assert cradle.get("pulses").tolist() == [sum(i in which for _, which in onsets) for i in range(5)]


@pytest.mark.parametrize("options", [{}, BOTH])
def test_clocks_bytes_of_pulses_are_those_of_the_log(make3, options):
    cradle = make3(nc.preset("figure6"), **options)
    assert cradle.csv() == []
    cradle.walk(0.0, 30.0)
    log = pulses(cradle.lines)
    assert cradle.csv() == log and len(log) > 100
    other = make3(nc.preset("figure6"), **options)
    other.go_to(cradle.to_bytes())
    assert other.csv() == log
    # The last ones, as far as there is room.
    cradle.walk(30.0, 300.0)
    kept = cradle.csv()
    assert 490 <= len(kept) < len(pulses(cradle.lines)) and kept == pulses(cradle.lines)[-len(kept) :]


def test_early_return_is_at_the_onset(make3):
    cradle = make3(**BOTH)
    due = cradle.due
    assert due == cradle.get("t_next")
    needed, early, time = cradle.step(0.0, 1.0)
    assert (needed, early, time) == (True, True, due)
    # Discrete variables change in Event Mode, and clocks are active there only.
    assert cradle.get("pulses").tolist() == [0] * 5 and not cradle.get("onset.clock")
    cradle.enterEventMode()
    assert cradle.get("pulses").tolist() == [0, 1, 0, 0, 0] and cradle.get("inContact")[1]
    assert cradle.get("onset.clock") and not cradle.get("release.clock")
    assert cradle.get("onset.time") == time == cradle.get("t_onset")[1]
    again, due = cradle.update()
    assert not again and due > time and not cradle.get("onset.clock")
    assert cradle.get("onset.time") == time  # That of the last tick.
    cradle.enterStepMode()
    # A step that ends at the event is not early.
    assert cradle.step(time, due - time) == (True, False, due)


def test_event_just_ahead_is_due(make3):
    cradle = make3(**BOTH)
    due = cradle.due
    before = np.nextafter(np.nextafter(due, 0), 0)
    assert cradle.step(0.0, before) == (False, False, before)
    cradle.enterEventMode()
    assert cradle.get("onset.clock") and cradle.get("onset.time") == due
    cradle.events()
    # Earlier, it is announced again.
    cradle = make3(**BOTH)
    due = cradle.due
    cradle.step(0.0, due - 1e-9)
    cradle.enterEventMode()
    assert not cradle.get("onset.clock") and cradle.events() == ([], due)


def test_clocks_tick_first_for_contacts_closed_at_the_start(make3):
    cradle = make3({"x_start": [0.0] * 5, "contact.gap": [-1e-5] * 4}, **BOTH)
    assert cradle.told == [{"onset": (0.0, (0, 1, 2, 3))}] and cradle.get("pulses").tolist() == [1] * 4 + [0]


def test_clocks_tick_once_for_simultaneous_impacts(make3):
    start = {"contact.model": 3, "contact.restitution": 1.0, "contact.deadBand": 0.0}
    cradle = make3(start | {"x_start": [-0.1, 0.0, 0.0, 0.0, 0.1]}, **BOTH)
    ticks = cradle.walk(0.0, 1.0)
    # Contacts 1 and 4 at once, then 2 and 3, each closing and opening in its tick, all at the same time.
    assert len({tick["onset"][0] for tick in ticks}) == 1
    closed, opened = (sum(len(tick[name][1]) for tick in ticks) for name in ("onset", "release"))
    assert ticks[0]["onset"][1][0] == 0 and cradle.get("pulses").sum() == closed == opened


def test_intermediate_update_is_called_at_each_event(make3):
    seen = []

    def record(_environment, time, may_set, may_get, finished, may_end, *_):
        seen.append((time, cradle.get("time")))
        assert (may_set, may_get, finished, may_end) == (True, True, True, False)

    cradle = make3(nc.figure5(), intermediateUpdate=record, requiredIntermediateVariables=[0])
    plain = make3(nc.figure5())
    for instance in (cradle, plain):
        assert instance.step(0.0, 3.0) == (False, False, 3.0)
    assert cradle.get("x").tobytes() == plain.get("x").tobytes()
    assert cradle.get("F_mean").tobytes() == plain.get("F_mean").tobytes()
    times = [time for pulse in pulses(plain.lines) for time in pulse[1:3]]
    assert seen == [(time, time) for time in sorted(set(times))] and len(seen) > 4


def test_intermediate_update_may_set_inputs(make3):
    def act(_environment, time, _set, _get, _finished, may_end, requested, end):
        acted.append(time)
        if len(acted) == 1:
            cradle.set("F_ext", [0.0, 0.0, 0.0, 0.0, 1.0])
        elif may_end:
            requested[0], end[0] = True, time + 1e-3

    acted = []
    cradle = make3(nc.figure5(), intermediateUpdate=act, earlyReturnAllowed=True)
    needed, early, time = cradle.step(0.0, 3.0)
    assert early and not needed and time == acted[1] + 1e-3
    # As if the first step had ended at the first event.
    other = make3(nc.figure5())
    other.step(0.0, acted[0])
    other.set("F_ext", [0.0, 0.0, 0.0, 0.0, 1.0])
    other.step(acted[0], time - acted[0])
    assert cradle.get("x") == pytest.approx(other.get("x"), abs=1e-15)


def test_event_mode_inputs_act_at_once(make3):
    cradle = make3(nc.figure5(), **BOTH)
    before = cradle.get("t_next")
    cradle.step(0.0, 0.125)
    cradle.enterEventMode()
    cradle.set("F_ext", [10.0, 0.0, 0.0, 0.0, 0.0])
    assert cradle.get("a")[0] == pytest.approx(10.0 - 5.0 * cradle.get("x")[0])
    assert cradle.get("t_next") < before
    assert cradle.events()[1] == cradle.get("t_next")
