"""The benchmark: the FMU in FMPy against the exact results, what is published beside them, and judgements."""

import json
import math
import re

import newtons_cradle as nc
import numpy as np
import pytest
from conftest import ROOT

CASES = [nc.benchmark(name) for name in nc.benchmarks()]
DOCUMENT = (ROOT / "docs/makers/exact-rows.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_exact_rows_by_the_fmu(case, cradle, fmu_path):
    """Within 1e-13 of the scale, or ten times the sensitivity; and two computations agree to 15 digits in each case."""
    # In FMI 3.0 arrays keep the description of a long row short.
    judgement = case.judge(case.run(cradle(balls=case.n, fmi=3, binaries=fmu_path)))
    assert set(judgement.verdicts) >= {"v", "release", "loss"}
    assert judgement.within, f"\n{judgement}"
    assert max(case.agreement.values()) <= 1e-15
    # Only onsets and releases are left out, if anything.
    for name, values in case.expected.items():
        assert len(values) == {"x": case.n, "v": case.n, "loss": 1}.get(name, case.n - 1)
        assert name in ("onset", "release") or not np.isnan(values).any()


def test_exact_rows_data_is_whole():
    """The version, the number of cases, and lines of the CSV file."""
    data = json.loads((ROOT / "exact-rows/cases.json").read_text(encoding="utf-8"))
    assert f"version: {data['version']}\n" in (ROOT / "exact-rows/CITATION.cff").read_text(encoding="utf-8")
    assert f"has {len(CASES)} rows" in DOCUMENT and max(case.n for case in CASES) == 1000
    rows = (ROOT / "exact-rows/cases.csv").read_text(encoding="utf-8").splitlines()
    peak = data["cases"][0]["results"]["peak"]
    more = f"{peak['sensitivity'][0]},{peak['scale']},{peak['agreement']}"
    assert f"equal-2-hertz,peak,1,{peak['value'][0]},{more}" in rows
    assert rows.count("cradle-1,order,2,1,,,") == rows.count("cradle-1,order,2,3,,,") == 1


@pytest.mark.parametrize(("p", "name"), [(1.0, "linear"), (1.5, "hertz"), (2.0, "square"), (3.0, "cubic")])
def test_exact_rows_of_two_have_a_closed_form(p, name):
    """Duration and largest force of an elastic impact of two."""
    case, x = nc.benchmark(f"equal-2-{name}"), 1.0 / (p + 1.0)
    deepest = ((p + 1.0) / 4.0) ** x
    duration = 2.0 * deepest * math.sqrt(math.pi) * math.gamma(1.0 + x) / math.gamma(0.5 + x)
    assert case.expected["peak"][0] == pytest.approx(deepest**p, rel=1e-14)
    assert case.expected["release"][0] == pytest.approx(duration, rel=1e-14)
    assert case.expected["v"] == pytest.approx([0.0, 1.0], abs=1e-15)


def test_exact_rows_of_two_part_at_their_restitution():
    case = nc.benchmark("constant-2-hertz")
    assert case.expected["v"] == pytest.approx([0.5 * (1.0 - case.damping), 0.5 * (1.0 + case.damping)], abs=1e-15)


@pytest.mark.parametrize("case", [case for case in CASES if case.material], ids=lambda case: case.name)
def test_exact_rows_of_steel_are_of_spheres(case):
    """Masses, and stiffnesses after Hertz, by the formulas of docs/makers/exact-rows.md."""
    r, e = np.array(case.radius), case.material["youngModulus"] / (1.0 - case.material["poissonRatio"] ** 2)
    assert case.mass == pytest.approx(4.0 / 3.0 * math.pi * case.material["density"] * r**3, rel=1e-15)
    stiffness = 2.0 / 3.0 * e * np.sqrt(r[:-1] * r[1:] / (r[:-1] + r[1:]))
    assert case.stiffness == pytest.approx(stiffness, rel=1e-15)


@pytest.mark.parametrize("case", [case for case in CASES if case.material], ids=lambda case: case.name)
def test_exact_rows_of_steel_by_radii(cradle, fmu_path, case):
    fmu, record = cradle(balls=case.n, binaries=fmu_path), ["x", "v", "F_peak", "E_total"]
    assert case.judge(fmu.simulate(case.spheres, times=[0.0, case.stop], record=record)).within


def test_exact_rows_differ_from_published_results_as_the_document_says():
    """A chain that is tested to 1e-12 elsewhere, at most 5e-4 from the exact results in docs/makers/exact-rows.md."""
    names = ("siconos-monodisperse", "siconos-tapered-as-run", "siconos-tapered")
    equal, as_run, tapered = map(nc.benchmark, names)
    errors = [max(abs(case.published["v"] - case.expected["v"])) for case in (equal, as_run)]
    said = [f"up to {errors[0]:.1e} m/s".replace("e-0", "e-"), f"by {errors[1]:.1e} m/s".replace("e-0", "e-")]
    said += [f"leaves at {case.expected['v'][-1]:.4f} m/s" for case in (as_run, tapered)]
    assert [words for words in said if words not in " ".join(DOCUMENT.split())] == []


def test_exact_rows_judgements():
    """The ten lines of docs/makers/exact-rows.md have a few digits of case 1, and it tells which; exact results have all."""
    scope = {}
    exec(DOCUMENT.split("```python\n")[1].split("```")[0], scope)
    verdicts = scope["judgement"].verdicts
    assert 3.0 < verdicts["v"].digits < 16.0 and 3.0 < verdicts["peak"].digits < 16.0
    assert str(scope["judgement"]) in DOCUMENT
    case, wide = nc.benchmark("equal-5-hertz"), nc.benchmark("apart-5-wide")
    assert case.judge({name: values.tolist() for name, values in case.expected.items()}).within
    off = case.judge({"v": case.expected["v"] + [0, 0, 1e-6, 0, 0]})
    assert off.verdicts["v"].digits == pytest.approx(6.0) and not off.within
    assert wide.judge({"order": [1, 2, 3, 4]}).within and not wide.judge({"order": [2, 1, 3, 4]}).within
    assert not case.judge({"onset": [None] * 4, "order": []}).verdicts  # of balls in touch


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"u": [1.0]}, "there is no 'u'; allowed: v, x, peak, onset, release, loss"),
        ({"v": [1.0]}, r"v: shape \(1,\); allowed: 5, one for each ball"),
        ({"peak": ["a"] * 4}, "peak: a list of numbers is needed"),
        ({"v": [0, 0, 0, np.nan, 1]}, r"v\[4\] is nan; a finite number is needed"),
        ({"order": 3}, "order: the form is"),
        ({"order": "1234"}, r"is \[\[1, 2\], \[1\]\]"),
        ([1.0], "result: a Result is needed, or a dict"),
        ({}, "result: a Result is needed, or a dict"),
    ],
)
def test_exact_rows_refuse_wrong_results(given, complaint):
    with pytest.raises(nc.CradleError, match=complaint):
        nc.benchmark("apart-5-wide").judge(given)


def test_exact_rows_refuse_unknown_cases_and_other_ends(fmu):
    for name, hint in (("equal-5-herz", ".*did you mean equal-5-hertz"), ([1], "")):
        with pytest.raises(nc.InvalidValue, match=re.escape(f"there is no case {name!r}") + hint):
            nc.benchmark(name)
    case = nc.benchmark("equal-5-hertz")
    with pytest.raises(nc.InvalidValue, match=r"it ends at 0.5 s; allowed:"):
        case.judge(fmu.simulate(case.values, times=[0.0, 0.5]))
