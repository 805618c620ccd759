"""Many runs side by side: cases, results with the cases in front, errors by case."""

import os

import newtons_cradle as nc
import numpy as np
import pytest

AXES = {"contact.exponent": [1.0, 1.5, 20.0], "contact.deadBand": [0.0, 2.6e-6]}
SHORT = {"stop": 1.0, "record": ["x", "E_total"]}


def measured(fmu, case):
    """The largest force, or the end of the process."""
    if case["mass"] < 0.0:
        os._exit(1)
    return {"peak": fmu.simulate({"ball.mass": case["mass"]}, stop=1.0, record=[]).pulses["peak"].max()}


@pytest.mark.parametrize("workers", [1, 2])
def test_a_product_of_axes_has_its_results_side_by_side(fmu, workers):
    told = []
    found = nc.sweep(AXES, fmu=fmu, workers=workers, progress=told.append, **SHORT)
    assert [tuple(case.values()) for case in found.cases] == [(p, d) for p in (1.0, 1.5, 20.0) for d in (0.0, 2.6e-6)]
    assert found["x"].shape == (6, 101, 5) and found["E_total"].shape == (6, 101) and found.time[-1] == 1.0
    assert list(found) == ["time", *(f"x[{i}]" for i in range(1, 6)), "E_total"] and len(found.seconds) == 6
    assert told == sorted(told) and told[-1] == 1.0
    alone = [fmu.simulate(case, **SHORT) for case in found.cases[:4]]
    assert all(np.array_equal(found["x"][i], one["x"]) for i, one in enumerate(alone))
    assert all(found.pulses[i].tobytes() == one.pulses.tobytes() for i, one in enumerate(alone))
    assert set(found.errors) == {4, 5} and np.isnan(found["x"][4:]).all() and len(found.pulses[5]) == 0
    assert "contact.exponent = 20 is refused; allowed: 1 to 10" in found.errors[4]
    assert repr(found).startswith("Sweep(6 cases, 2 failed; ")
    pytest.importorskip("pandas")
    frame = found.to_dataframe()
    assert list(frame["contact.exponent"]) == [1.0, 1.0, 1.5, 1.5, 20.0, 20.0]
    assert frame["x[5]"][0] == alone[0]["x[5]"][-1] and list(frame["error"] != "") == [False] * 4 + [True] * 2


def test_cases_are_dicts_or_rows(fmu, fmu_path):
    rows = [{"ball.mass": 1.0}, {"ball.mass": 2.0, "x_start": [-0.1, 0, 0, 0, 0]}]
    found = nc.sweep(rows, fmu=fmu_path, workers=1, **SHORT)
    assert found["x"][:, 0, 1].tolist() == [-0.1, 0.0] and not found.errors
    assert nc.sweep([], fmu=fmu).results == []
    pandas = pytest.importorskip("pandas")
    again = nc.sweep(pandas.DataFrame({"ball.mass": [1.0, 2.0]}), fmu=fmu, workers=1, **SHORT)
    assert np.array_equal(again["x"][0], found["x"][0])


def test_a_process_that_dies_costs_its_case_only(fmu):
    found = nc.sweep({"mass": [0.5, -1.0, 1.0, 2.0]}, measured, fmu=fmu, workers=2)
    assert found.errors == {1: "its process has died"}
    assert np.isnan(found["peak"][1]) and (np.diff(found["peak"][[0, 2, 3]]) > 0).all()
    assert found.results[0] == measured(fmu, {"mass": 0.5})


def test_a_data_set_has_named_dimensions(fmu, cradle, fmu_path):
    """Of a run and of many; balls and contacts count from 1."""
    pytest.importorskip("xarray")
    result = fmu.simulate(nc.figure5(), stop=1.0)
    data = result.to_xarray()
    assert data.x.dims == ("time", "ball") and data.F.dims == ("time", "contact") and data.E_total.dims == ("time",)
    assert (
        data.x.sel(ball=5)[-1] == result["x[5]"][-1] and data.F_peak.sel(contact=2).max() == result["F_peak[2]"].max()
    )
    assert data.x.units == "m" and data.time.units == "s" and data.inContact.dtype == bool
    some = fmu.simulate(stop=0.1, record=["x[2]", "x[4]", "v"]).to_xarray()
    assert some.x.sel(ball=4)[0] == 0.0 and np.isnan(some.x.sel(ball=1)).all() and some.v.shape == (11, 5)
    many = nc.sweep(AXES, fmu=fmu, workers=1, **SHORT).to_xarray()
    assert many.x.dims[-2:] == ("time", "ball") and set(many.x.dims) == {*AXES, "time", "ball"}
    one = many.x.sel({"contact.exponent": 1.5, "contact.deadBand": 2.6e-6})
    alone = fmu.simulate({"contact.exponent": 1.5, "contact.deadBand": 2.6e-6}, **SHORT)
    assert np.array_equal(one.transpose("time", "ball"), alone["x"])
    listed = nc.sweep([{"ball.mass": 1.0}, {"ball.mass": 2.0}], fmu=fmu, workers=1, **SHORT).to_xarray()
    assert listed.x.dims == ("case", "time", "ball") and listed["ball.mass"].values.tolist() == [1.0, 2.0]
    assert cradle(balls=2, binaries=fmu_path).simulate(stop=0.1).to_xarray().F.dims == ("time", "contact")
