"""Saved states: a run goes on with the same bits, also in another process."""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import newtons_cradle as nc
import pytest
from continue_run import steps_of

SETUPS = {
    "separate pulses": nc.figure5(),
    "overlapping pulses": nc.figure5(0.0),
    "Hertz, damped": nc.figure5(0.0)
    | {"contact.model": 2, "contact.dampingLaw": 3, "contact.huntCrossley": 0.3, "pendulum.drag": 0.1},
    "rigid, lasting contacts": nc.figure5(0.0)
    | {"contact.model": 3, "contact.restitution": 0.5, "pendulum.lengthRatio[3]": 1.1, "F_ext[5]": -3.0},
}
# How far behind the first onset the state is saved, s; None: in flight before it.
PLACES = {"in flight": None, "at the onset": 0.0, "within a pulse": 1e-7, "between pulses": 2.5e-7}


DERIVATIVES = {"held": [], "ramp": [["F_ext[2]", 1, 0.3], ["a_support", 2, -0.1]]}


@pytest.mark.parametrize("setup", SETUPS)
def test_a_new_process_goes_on_with_the_same_bits(fmu, setup, tmp_path):
    saved, expected = [], {}
    for place, derivatives in itertools.product(PLACES, DERIVATIVES):
        steps = [[size, DERIVATIVES[derivatives]] for size in [1e-7, 2e-7, 1e-6, 0.3, 0.25, 0.4]]
        with fmu.start(SETUPS[setup]) as run:
            steps_of(run, [[0.25, DERIVATIVES[derivatives]]])
            if PLACES[place] is not None:
                run.step_to_onset()
                if PLACES[place] > 0:
                    run.step(PLACES[place])
            file = tmp_path / f"{place}, {derivatives}"
            file.write_bytes(run.save().data)
            saved.append((str(file), steps))
            expected[place, derivatives] = steps_of(run, steps)
    script = Path(__file__).with_name("continue_run.py")
    done = subprocess.run(
        [sys.executable, script, fmu.path],
        input=json.dumps(saved),
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert dict(zip(expected, json.loads(done.stdout), strict=True)) == expected
    assert all(any(lines for _, lines in steps) for steps in expected.values())


def test_a_saved_state_can_be_loaded_again_and_again(fmu):
    with fmu.start(nc.figure5()) as run, fmu.start() as other:
        run.step_to(0.6)
        saved = run.save()
        run.step_to(1.0)
        for target in (run, other, other):
            target.load(saved)
            assert target.time == 0.6
            target.step_to(1.0)
            assert target.get("E_residual") == run.get("E_residual")


@pytest.mark.parametrize("damage", ["truncated", "flipped", "empty"])
def test_damaged_bytes_are_refused(fmu, damage):
    with fmu.start() as run:
        run.step_to(0.3)
        saved = run.save()
        data = bytearray(saved.data)
        data[len(data) // 2] ^= 4
        bad = {"truncated": saved.data[:-1], "flipped": bytes(data), "empty": b""}[damage]
        with pytest.raises(nc.FmuError, match="the state is refused: "):
            run.load(nc.Saved(0.0, bad))
        x = run.get("x[1]")
        run.load(saved)
        assert run.get("x[1]") == x
