"""The Python package with the FMU of FMI 3.0: the same results under the same names, to the last bit."""

import newtons_cradle as nc
import numpy as np
import pandas
import pytest
from newtons_cradle.views import from_fmu

pytestmark = pytest.mark.all


@pytest.mark.parametrize(
    "values",
    [
        {},
        nc.figure5(),
        {"contact.model": "hertz", "contact.relaxationTime": 1e-6, "F_ext[2]": 0.1},
        {"contact.model": "rigid", "contact.restitution": 0.9},
        {"x_start[1]": -0.15, "v_start": [0, 0, 0.1, 0, 0], "contact.gap[4]": 1e-4, "ball.massRatio[5]": 2.0},
    ],
)
def test_package_with_fmi3_has_the_data_frames_of_fmi_2(fmu, fmu3, values):
    one, other = (
        each.simulate(values, stop=3.0, inputs=lambda t: {"a_support": 0.1 * (t > 1.0)}) for each in (fmu, fmu3)
    )
    pandas.testing.assert_frame_equal(one.to_dataframe(), other.to_dataframe(), check_exact=True)
    assert one.samples.tobytes() == other.samples.tobytes() and one.units == other.units
    assert one.pulses.tobytes() == other.pulses.tobytes() and len(one.pulses) > 0


@pytest.mark.parametrize("method", ["eventDriven", "adams"])
def test_package_with_fmi3_zooms_the_same(fmu, fmu3, method):
    """Without the variable that tells an onset from a time up to which there is none, as far as one look of `adams`
    goes."""
    found = []
    for each in (fmu, fmu3):
        with each.start({"solver.method": method}) as run:
            onset, result = run.zoom(1e-5, 1e-7, ["x", "F"], before=1e-6)
            run.step_to(2.0)
            found.append((onset, result.samples.tobytes(), [line.text for line in run.log]))
    assert found[0] == found[1]
    assert found[0][0] == pytest.approx(0.702493100658, abs=1e-9)
    with fmu3.start({"gravity": 0.0}) as run, pytest.raises(nc.FmuError, match="no contact closes any more"):
        run.step_to_onset()


def test_package_with_fmi3_records_the_same(fmu_path, fmu3):
    setup, told = {"contact.deadBand": 1e-6}, []
    paths = (fmu_path, fmu3.path)
    one, other = (dict(vars(from_fmu(path, setup, stop=2.0, progress=told.append))) for path in paths)
    half = told[: len(told) // 2]
    assert half * 2 == told and half == sorted(half) and half[0] < 0.1 and half[-1] == 1.0
    assert len([done for done in half if done < 0.5]) > 50
    ours, theirs = one.pop("parameters"), other.pop("parameters")
    assert {row[0] for row in theirs} - {row[0] for row in ours} == {"derivatives.of"}
    assert set(ours) < set(theirs)
    np.testing.assert_equal(one, other)
