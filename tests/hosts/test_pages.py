"""The FMU's page and the report, opened from disk in a headless Chromium."""

import re
from pathlib import Path
from urllib.parse import unquote

import pytest
from browser import colours, set_screen, visit
from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.wait import WebDriverWait

pytestmark = pytest.mark.all


def test_the_fmus_documentation(browser, fmu):
    """Opened as the FMU carries it: a picture, and every variable with its unit."""
    path = Path(fmu.folder) / "documentation/index.html"
    visit(browser, path)
    assert colours(browser, browser.find_element(By.CSS_SELECTOR, "figure svg")) > 100
    rows = browser.execute_script(
        "return [...document.querySelectorAll('tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))"
    )
    units = {name: unit for name, unit, *_ in rows}
    for variable in fmu.description.modelVariables:
        assert units[re.sub(r"\[\d+\]", "[i]", variable.name)] == (variable.unit or "")


def show(report, item) -> None:
    """Scrolls to an element."""
    report.execute_script("arguments[0].scrollIntoView({behavior: 'instant', block: 'center'})", item)


@pytest.fixture
def report(browser, paper):
    """The browser with the report open."""
    set_screen(browser)
    visit(browser, paper[0] / "report.html")
    return browser


def test_the_report_shows_all_figures(report, paper):
    """It links its numbers and the cradle."""
    charts = report.find_elements(By.CSS_SELECTOR, ".chart canvas")
    assert len(charts) >= 12
    for chart in charts:
        show(report, chart)
        assert colours(report, chart) > 20, chart.accessible_name
    assert len(report.find_elements(By.CSS_SELECTOR, "td.holds")) >= 50
    assert report.find_elements(By.CSS_SELECTOR, "td.fails") == []
    out, _ = paper
    links = report.execute_script("return [...document.links].map((link) => link.getAttribute('href'))")
    names = {unquote(link) for link in links if not link.startswith("#")}
    assert {path.name for path in out.glob("*.csv")} | {"cradle.html"} == names
    visit(report, out / "cradle.html")
    assert report.execute_script("return cradle.sources[0].clicks.length") >= 7


def test_the_report_zooms_from_seconds_to_nanoseconds(report):
    """A button of Figure 4 ends at 10 ns, where its first contact's force rises from 0; keys read values there."""
    buttons = report.find_elements(By.CSS_SELECTOR, "#figure4 button")
    show(report, buttons[3])
    buttons[3].click()
    width = "const [chart] = report.charts.figure4; return chart.right - chart.left"
    WebDriverWait(report, 30).until(lambda _: report.execute_script(width) < 1.01e-8)
    left, right, largest = report.execute_script(
        """const [chart] = report.charts.figure4, {x, y} = chart.strips[1].traces[0];
        return [chart.left, chart.right, Math.max(...y.filter((_, i) => x[i] >= chart.left && x[i] <= chart.right))]"""
    )
    assert left < 0.702481589380 < right
    assert 0 < largest < 3e6
    buttons[-1].click()
    assert report.execute_script(width) == pytest.approx(2e-8, rel=1e-3)
    # Where the axis is far from 0, values are read from the round one that is written below it.
    buttons[3].click()
    WebDriverWait(report, 30).until(lambda _: report.execute_script(width) < 1.01e-8)
    chart = report.find_element(By.CSS_SELECTOR, "#figure4 canvas")
    chart.send_keys(Keys.SHIFT + Keys.ARROW_RIGHT)
    said = report.find_element(By.CSS_SELECTOR, "#figure4 .spoken").get_attribute("textContent")
    assert re.match(r"0\.7024815\d* s \+ [\d.]+ ns; F\[1\] 0\.000 MN; F\[2\] 0\.\d+ MN; ", said)
    chart.send_keys(Keys.ESCAPE)
    assert report.execute_script("return report.charts.figure4[0].reading") is None
    [start, _] = ranges(report, "figure4")[0]
    chart.send_keys(Keys.ARROW_RIGHT)
    assert ranges(report, "figure4")[0][0] == pytest.approx(start + 1e-9, abs=1e-13)


def ranges(browser, figure: str) -> list:
    """What each chart of a figure shows: [left, right]."""
    return browser.execute_script(f"return report.charts.{figure}.map(({{left, right}}) => [left, right])")


def test_charts_side_by_side_move_together(report):
    """Those of the same range; by buttons, dragging and keys. The pointer reads both, in the units of their axes."""
    left, right = report.find_elements(By.CSS_SELECTOR, "#figure5 canvas")
    show(report, left)
    before = left.screenshot_as_png
    ActionChains(report).move_to_element_with_offset(left, -100, 0).perform()
    read = "({...chart.readings(), seconds: chart.reading})"
    one, other = report.execute_script(f"return report.charts.figure5.map((chart) => {read})")
    assert one["at"] == other["at"]
    time, unit = one["at"].split()
    assert unit == "µs" and float(time) * 1e-6 == pytest.approx(one["seconds"], abs=3e-9)
    exact = report.execute_script(
        """const [{reading, strips}] = report.charts.figure5, {x, y} = strips[0].traces[0], i = x.findIndex((at) => at
        > reading); return y[i - 1] + (y[i] - y[i - 1]) * (reading - x[i - 1]) / (x[i] - x[i - 1])"""
    )
    [first] = one["values"][0]
    value, unit = first["text"].split()
    assert first["name"] == "F[1]" and unit == "MN"
    assert exact > 1e5 and float(value) * 1e6 == pytest.approx(exact, abs=6e3)
    assert left.screenshot_as_png != before
    onset = report.find_elements(By.CSS_SELECTOR, "#figure5 button")[1]
    assert onset.text == "onset"
    onset.click()
    WebDriverWait(report, 30).until(lambda _: ranges(report, "figure5") == [[-2e-9, 4e-8]] * 2)
    pressed = report.find_elements(By.CSS_SELECTOR, "#figure5 button[aria-pressed=true]")
    assert [button.text for button in pressed] == ["onset", "onset"]
    ActionChains(report).drag_and_drop_by_offset(right, -60, 0).perform()
    moved = ranges(report, "figure5")
    assert moved[0] == moved[1] and moved[0][0] > -2e-9
    right.send_keys("+")
    closer = ranges(report, "figure5")
    assert closer[0] == closer[1]
    assert closer[0][1] - closer[0][0] == pytest.approx(2.1e-8, rel=1e-3)
    left.send_keys("0")
    WebDriverWait(report, 30).until(lambda _: ranges(report, "figure5") == [[-5e-8, 1.1e-6]] * 2)
    assert ranges(report, "figure4") == [[0, 10]]
