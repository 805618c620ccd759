"""Ctrl-C, alarms and what other threads raise: a run ends as soon as the FMU returns, and loses no pulse."""

import contextlib
import ctypes
import random
import signal
import threading

import newtons_cradle as nc
import numpy as np
import pytest
from newtons_cradle.run import log, parts

LONG = 1e6  # s, of which the engine computes some thousands in a second
PATIENCE = 30.0  # s, after which a run has not ended


class AlarmError(Exception):
    """What the handler of a signal raises."""


def ring(*_):
    raise AlarmError


@pytest.fixture(params=["2, default", "2, buzzing", "3, default", "3, buzzing"], scope="module")
def either(request, cradle, fmu_path):
    """An FMU of either version, the default one and one of twenty balls that press on each other."""
    fmi, kind = request.param.split(", ")
    preset = {} if kind == "default" else {"preset": kind}
    return cradle(fmi=int(fmi), binaries=fmu_path, **preset)


def going_on(run):
    """Steps until something is raised; short and long steps."""
    while True:
        run.step(0.01)
        run.step_to(run.time + LONG)


def complete(fmu, run):
    """Whether the run has all pulses of one that has come as far without being interrupted, and can go on."""
    mine, time = run.pulses, run.time
    assert len(run.log) >= len(mine) > 0
    with fmu.start() as again:
        again.step_to(time)
        wanted = again.pulses
    assert mine.tobytes() == wanted.tobytes()
    run.step(1e-3)
    assert run.time == time + 1e-3
    return True


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers that send signals")
def test_interrupt_at_any_time_ends_a_run(either):
    """Ten of them; each would be swallowed if it came while a function in Python took a message."""
    moments = random.Random(7)
    before = signal.signal(signal.SIGALRM, ring)
    try:
        for _ in range(10):
            with either.start() as run:
                with pytest.raises(AlarmError):
                    signal.setitimer(signal.ITIMER_REAL, moments.uniform(0.02, 0.2))
                    going_on(run)
                assert complete(either, run)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_interrupt_by_ctrl_c_ends_a_run(either):
    with either.start() as run:
        timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            going_on(run)
        timer.join()
        assert complete(either, run)
    with pytest.raises(KeyboardInterrupt):
        either.simulate(stop=1.0, control=lambda run: signal.raise_signal(signal.SIGINT))
    assert len(either.simulate(stop=0.1, record=["x"])["x"]) == 11


def test_interrupt_by_another_thread_ends_a_run(either):
    found = []

    def work():
        with contextlib.suppress(AlarmError), either.start() as run:
            try:
                going_on(run)
            finally:
                found.append(complete(either, run))

    for _ in range(3):
        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        thread.join(0.1)
        raised = ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident), ctypes.py_object(AlarmError))
        thread.join(PATIENCE)
        assert raised == 1 and not thread.is_alive()
    assert found == [True] * 3


def test_interrupt_waits_while_a_message_is_taken():
    """A handler of a signal would run, and could raise, in any function in Python that C calls back."""
    for fmi2 in (True, False):
        sink = log.Sink(fmi2)
        head = [sink.environment.raw[:1], *([b"cradle"] if fmi2 else [])]
        for status, category, text in ((0, b"logEvents", b"contact=1"), (3, b"logStatusError", b"a: %% b\n")):
            sink.callback(*head, bytes([status]), category, text)
        lines = [(line.status, line.category, line.text) for line in log.Log(sink)]
        percent = "%" if fmi2 else "%%"
        assert lines == [(0, "logEvents", "contact=1"), (3, "logStatusError", f"a: {percent} b\n")]


def test_interruptible_step_in_parts_is_one_step(either, monkeypatch):
    """The trajectory, pulses and peaks to the last bit, means as exact as sums are."""
    names = ["x", "v", "impulse", "E_residual", "pulses", "F_peak", "F_mean", "F_support_mean"]
    found = []
    for first in (parts.NONE, 0.003):
        monkeypatch.setattr(parts, "FIRST", first)
        with either.start() as run:
            recorder = run.recorder(names)
            for time in (0.8, 1.1):
                run.step_to(time)
                recorder.sample()
            run.step(1e-4)
            recorder.sample()
            found.append((recorder.result(), run._parts.means, {name: run[name] for name in names}))
    (whole, _, last), (made, means, again) = found
    assert means == {}
    for name in whole:
        if "mean" in name:
            np.testing.assert_allclose(made[name], whole[name], rtol=1e-12, atol=1e-9)
        else:
            assert made[name].tobytes() == whole[name].tobytes(), name
    assert whole.pulses.tobytes() == made.pulses.tobytes()
    assert all(np.array_equal(last[name], again[name]) for name in names)


def test_interruptible_step_is_whole_for_observers(fmu, fmu3, monkeypatch):
    """Methods that start anew at communication points, slopes of inputs, derivatives of the last step, callers of
    FMPy's functions."""
    monkeypatch.setattr(parts, "FIRST", 0.01)
    for either, values in (
        (fmu, {"solver.method": "adams"}),
        (fmu3, {"der(F_ext[1])": 0.1}),
        (fmu3, {"derivatives.of": "lastStep"}),
        (fmu3, {"derivatives.of": np.int64(2)}),
    ):
        with either.start(values) as run:
            assert run._parts.longest == parts.NONE
    with fmu3.start({"derivatives.of": "run"}) as run:
        assert run._parts.longest == 0.01
        run.step_to(1.0)
        made = run.gradient("E_total", ["ball.mass", "x_start"])
    with fmu3.start({"derivatives.of": "run"}) as run:
        run._parts.end()
        run.step_to(1.0)
        whole = run.gradient("E_total", ["ball.mass", "x_start"])
    assert made["x_start"] == pytest.approx(whole["x_start"], rel=1e-12, abs=1e-14)
    with fmu.start() as run:
        assert run._parts.longest == 0.01
        run.step_to(0.5)
        with pytest.raises(nc.FmuError, match="the last step was so long that it was made in parts"):
            run.derivative("x", "F_ext", over="step")
        assert run.slave and run._parts.longest == parts.NONE
