"""The FMU's page and the report, opened from disk in a headless Chromium. All pages in windows of a desktop and of a
phone, light and dark: nothing overprints or is cut off, axe-core finds nothing serious, and balls can be dragged beside
panels and strips."""

import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from browser import PANELS, SIZES, colours
from selenium.webdriver import ActionChains
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.all


def test_pages_documentation_of_the_fmu(browser, fmu):
    """Opened as the FMU carries it: a picture, and every variable with its unit."""
    path = Path(fmu.folder) / "documentation/index.html"
    browser.visit(path)
    assert colours(browser.find("figure svg")) > 100
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
    browser.visit(paper[0] / "report.html")
    return browser


def test_report_shows_all_figures(report, paper):
    """It links its numbers and the cradle."""
    charts = report.find_all(".chart canvas")
    assert len(charts) >= 12
    for chart in charts:
        show(report, chart)
        assert colours(chart) > 20, chart.accessible_name
    assert len(report.find_all("td.holds")) >= 50
    assert report.find_all("td.fails") == []
    out, _ = paper
    links = report.execute_script("return [...document.links].map((link) => link.getAttribute('href'))")
    names = {unquote(link) for link in links if not link.startswith("#")}
    assert {path.name for path in out.glob("*.csv")} | {"cradle.html"} == names
    report.visit(out / "cradle.html")
    assert report.execute_script("return cradle.sources[0].clicks.length") >= 7


def test_report_zooms_from_seconds_to_nanoseconds(report):
    """A button of Figure 4 ends at 10 ns, where its first contact's force rises from 0; keys read values there."""
    buttons = report.find_all("#figure4 button")
    show(report, buttons[3])
    buttons[3].click()
    width = "report.charts.figure4[0].right - report.charts.figure4[0].left"
    report.wait(f"{width} < 1.01e-8")
    left, right, largest = report.execute_script(
        """const [chart] = report.charts.figure4, {x, y} = chart.strips[1].traces[0];
        return [chart.left, chart.right, Math.max(...y.filter((_, i) => x[i] >= chart.left && x[i] <= chart.right))]"""
    )
    assert left < 0.702481589380 < right
    assert 0 < largest < 3e6
    buttons[-1].click()
    assert report.js(f"return {width}") == pytest.approx(2e-8, rel=1e-3)
    # Where the axis is far from 0, values are read from the round one that is written below it.
    buttons[3].click()
    report.wait(f"{width} < 1.01e-8")
    chart = report.find("#figure4 canvas")
    chart.send_keys(Keys.SHIFT + Keys.ARROW_RIGHT)
    said = report.find("#figure4 .spoken").get_attribute("textContent")
    assert re.match(r"0\.7024815\d* s \+ [\d.]+ ns; F\[1\] 0\.000 MN; F\[2\] 0\.\d+ MN; ", said)
    chart.send_keys(Keys.ESCAPE)
    assert report.execute_script("return report.charts.figure4[0].reading") is None
    [start, _] = ranges(report, "figure4")[0]
    chart.send_keys(Keys.ARROW_RIGHT)
    assert ranges(report, "figure4")[0][0] == pytest.approx(start + 1e-9, abs=1e-13)


def ranges(browser, figure: str) -> list:
    """What each chart of a figure shows: [left, right]."""
    return browser.execute_script(f"return report.charts.{figure}.map(({{left, right}}) => [left, right])")


def test_report_charts_side_by_side_move_together(report):
    """By buttons, dragging and keys. The pointer reads both, in the units of their axes."""
    left, right = report.find_all("#figure5 canvas")
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
    onset = report.find_all("#figure5 button")[1]
    assert onset.text == "onset"
    onset.click()
    report.wait("report.charts.figure5.every(({left, right}) => left === -2e-9 && right === 4e-8)")
    pressed = report.find_all("#figure5 button[aria-pressed=true]")
    assert [button.text for button in pressed] == ["onset", "onset"]
    ActionChains(report).drag_and_drop_by_offset(right, -60, 0).perform()
    moved = ranges(report, "figure5")
    assert moved[0] == moved[1] and moved[0][0] > -2e-9
    right.send_keys("+")
    closer = ranges(report, "figure5")
    assert closer[0] == closer[1]
    assert closer[0][1] - closer[0][0] == pytest.approx(2.1e-8, rel=1e-3)
    left.send_keys("0")
    report.wait("report.charts.figure5.every(({left, right}) => left === -5e-8 && right === 1.1e-6)")
    assert ranges(report, "figure4") == [[0, 10]]


#: What is done with a page, one after the other: a recording stands still in a click, with strips, and with its
#: parameters; a live run is shown with each panel, in 3D, as a lesson, and inside a click.
ACTIONS = {
    "recorded": (
        "cradle.setRunning(false); cradle.clock.slowAt('always');"
        " cradle.seek(cradle.sources[0].clicks[0].begin + 3e-5)",
        "for (const kind of ['force', 'energy']) cradle.set(kind, true)",
        "for (const kind of ['force', 'energy']) cradle.set(kind, false); cradle.panels.toggle('details')",
    ),
    "live": (
        "cradle.open('preset=steel&lift=2&show=energy')",
        *(f"cradle.panels.toggle('{panel}')" for panel in PANELS),
        "cradle.panels.close(); cradle.open('view=3d')",
        "cradle.open('present')",
        """cradle.open('preset=steel&lift=2&show=energy&slow=always'); const [source] = cradle.sources;
        while (!source.shownClick?.sampled) source.advance(source.time + 0.9 * source.ahead(Infinity).distance);
        cradle.seek(source.shownClick.begin + 3e-5)""",
    ),
}
TYPICAL = ("desktop", "phone", "landscape")
#: Whether the last action of a live run has led into a click.
INSIDE = "return cradle.clock.inside && Boolean(cradle.sources[0].shownClick?.sampled)"

#: Each text of the page as [text, left, top, right, bottom, whether it may scroll away sideways], CSS pixels.
TEXTS = """
const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node; (node = walk.nextNode());) {
  const parent = node.parentElement, text = node.textContent.trim();
  if (!text || parent.closest("script, style, .spoken, #panelbody")) continue;
  if (arguments[0] && parent.closest("#status")) continue;
  if (!parent.checkVisibility({visibilityProperty: true})) continue;
  if (getComputedStyle(parent).clipPath !== "none") continue;
  const strips = parent.closest(".strips")?.getBoundingClientRect(); // what is scrolled out of it is not seen
  const range = document.createRange(), scrolls = Boolean(parent.closest("[role=region], .wide"));
  range.selectNodeContents(node);
  for (const {left, top, right, bottom} of range.getClientRects()) {
    if (strips && (top < strips.top || bottom > strips.bottom)) continue;
    if (right - left > 1) found.push([text.slice(0, 60), left, top + scrollY, right, bottom + scrollY, scrolls]);
  }
}
return found;"""


@pytest.fixture
def kind(request, page) -> Path:
    """The page of a kind. Without the engine for browsers there is no live one."""
    if page == "report":
        return request.getfixturevalue("paper")[0] / "report.html"
    if page == "fmu":
        return Path(request.getfixturevalue("fmu").folder) / "documentation/index.html"
    return request.getfixturevalue(f"{page}_path")


def overprints(texts: list) -> list[tuple[str, str]]:
    """Pairs of texts that lie on each other, by more than what letters leave free in their line."""
    left, top, right, bottom = np.array([text[1:5] for text in texts]).T
    wide = np.minimum.outer(right, right) - np.maximum.outer(left, left)
    high = np.minimum.outer(bottom, bottom) - np.maximum.outer(top, top)
    least = 0.35 * np.minimum.outer(bottom - top, bottom - top)
    pairs = np.argwhere(np.triu((wide > 1.5) & (high > least), k=1))
    return [(texts[i][0], texts[j][0]) for i, j in pairs]


def assert_fits(browser, live: bool) -> None:
    """No text on another one or beyond the sides of the window, and nothing that makes the page scroll sideways. A live
    run says for a moment what has happened, over what is there."""
    width, texts = browser.execute_script("return innerWidth"), browser.execute_script(TEXTS, live)
    assert len(texts) > 10 and overprints(texts) == []
    assert [t for t in texts if not t[5] and not (t[1] >= 0 and t[3] <= width + 0.5)] == []
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("page", ["live", "recorded", "report", "fmu"])
def test_pages_overprint_nothing_and_axe_finds_nothing_serious(browser, axe, kind, page):
    """In windows of all sizes, and what axe-core takes longer for in typical ones, light and dark, whatever has been
    done."""
    browser.visit(kind, still=True)  # no view glides
    browser.execute_script(axe)
    for action in ["", *ACTIONS.get(page, ())]:
        browser.execute_script(action)
        for size in SIZES:
            browser.set_screen(size, still=True)
            browser.drawn()
            assert_fits(browser, page == "live")
            if page in ACTIONS:
                browser.boxes()
            for dark in (False, True) if size in TYPICAL else ():
                browser.set_screen(size, dark=dark, still=True)
                assert browser.serious() == [], (action, size, dark)
    assert page != "live" or browser.execute_script(INSIDE)
    browser.assert_quiet()


#: Of the report: colours of texts, of curves, and of what they are drawn on.
TEXT_COLOURS, GROUNDS = ("ink", "soft", "accent", "good", "bad"), ("paper", "card")
CURVES = ("edge", *(f"series-{i}" for i in range(1, 7)))
#: The contrast of two of them after WCAG 2, 1 to 21.
CONTRAST = """const {Color, getContrast} = axe.commons.color, style = getComputedStyle(document.documentElement);
return getContrast(...[...arguments].map((name) => {
  const colour = new Color();
  colour.parseString(style.getPropertyValue(`--${name}`).trim());
  return colour;
}))"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_pages_colours_have_contrast(report, axe, dark):
    """Texts, also those drawn on canvases, which axe-core does not see: 4.5 to 1; curves: 3 to 1."""
    report.set_screen(dark=dark)
    report.execute_script(axe)
    for name in TEXT_COLOURS + CURVES:
        least = min(report.execute_script(CONTRAST, name, ground) for ground in GROUNDS)
        assert least >= (4.5 if name in TEXT_COLOURS else 3), name
    assert report.execute_script(CONTRAST, "on-accent", "accent") >= 4.5


@pytest.mark.parametrize("size", SIZES)
def test_pages_leave_room_for_the_cradle(page, size):
    """Swinging, it comes close to two sides of its canvas at least, and sticks out at none. All strips together take
    no more of its height than two and a bit; the rest is scrolled to. Balls are as large as can be told apart, beside
    each step of the lesson in large letters, and, in German, whose words are long, beside panels, where a hand takes
    one of them."""
    page.set_screen(size)
    page.js("cradle.lift(2)")
    page.wait("source.run.time > 1.5")
    [alone] = page.boxes()
    across, up = page.js(
        """const {scene, canvas} = cradle.stages[0], {unit, floor, long} = scene;
        const {x} = scene.place(0, -0.1), {x: last} = scene.place(4, 0.1);
        return [(last - x + 2 * unit) / canvas.clientWidth, unit * (long - floor + 0.42) / canvas.clientHeight]""",
    )
    assert 0.85 < max(across, up) < 1
    page.js("for (const kind of ['velocity', 'force', 'energy', 'momentum']) cradle.set(kind, true)")
    page.wait("cradle.stages[0].strips.box.scrollHeight > 1.5 * cradle.stages[0].strips.box.clientHeight")
    [beside] = page.boxes()
    assert beside["bottom"] - beside["top"] > 0.6 * (alone["bottom"] - alone["top"])
    for step in range(1, 7):
        page.js("cradle.open(`present=${arguments[0]}`)", step)
        assert all(box["bottom"] - box["top"] > 120 for box in page.boxes()), step
    page.js("cradle.open('preset=textbook&lang=de')")
    for beside, least in (("stop", 140), ("hertz", 100 if size == "small" else 120)):
        page.js("cradle.compare(arguments[0])", beside)
        page.boxes()
        for panel in page.each_panel():
            assert all(box["bottom"] - box["top"] > least for box in page.boxes()), panel
        page.js("cradle.panels.toggle('change')")
        page.boxes()
        page.drag(0, -30)
        lifted = page.execute_script("return cradle.sources.map(({setup}) => setup.values.x_start[0])")
        assert max(lifted) < -0.01
        page.js("cradle.panels.toggle('change'); cradle.stopAll()")
