"""Controllers in a loop of one's own and in `simulate`, and the grid that they step on."""

import newtons_cradle as nc
import pytest


def test_controller_of_ones_own(fmu):
    """An active brake on ball 1 does what a drag on that ball would: its energy falls."""
    swing, record = nc.lifted(1, amplitude=0.1), ["x", "E_total"]
    with fmu.start(swing) as run:
        recorder = run.recorder(record)
        for time in run.until(20.0, 0.01):
            assert time == len(recorder) * 0.01
            run["F_ext[1]"] = -0.5 * run["v[1]"]
            recorder.sample()
        recorder.sample()
        braked = recorder.result()
    brake = {"control": lambda run: {"F_ext[1]": -0.5 * run["v[1]"]}}
    again, free = (fmu.simulate(swing, stop=20.0, record=record, **more)["E_total"] for more in (brake, {}))
    assert braked["x"].shape == (len(braked.samples), 5)
    assert braked["E_total"][-1] < 0.5 * free[-1]
    assert len(again) == len(braked.time) == 2001 and braked.time[-1] == 20.0
    assert again[-1] == pytest.approx(braked["E_total"][-1], rel=1e-9)


@pytest.mark.parametrize(
    ("begin", "end", "step"), [(0.0, 10.0, 0.01), (0.0, 0.7, 0.1), (0.35, 1.0, 0.1), (0.3, 0.95, 0.1)]
)
def test_run_until_steps_on_the_grid(fmu, begin, end, step):
    """Of multiples of the step, whatever their rounding; the last step ends where it was asked to."""
    with fmu.start() as run:
        if begin:
            run.step_to(begin)
        times = [*run.until(end, step), run.time]
        assert list(run.until(end, step)) == [] and run.time == end
    points = [k * step for k in range(1001) if begin + 1e-9 < k * step < end - 1e-9]
    assert times == [begin, *points, end]


def test_run_until_goes_on_after_steps_of_the_loop(fmu):
    with fmu.start() as run:
        for time in run.until(1.0, 0.25):
            if time == 0.25:
                run.step_to(0.9)
        assert time == 0.9 and run.time == 1.0
