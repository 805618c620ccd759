"""The report and the animation, opened from disk in a headless Chromium, and the command that makes animations."""

import io
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import newtons_cradle as nc
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.util import write_csv
from newtons_cradle.animation import from_fmu, save_page
from PIL import Image
from selenium import webdriver
from selenium.webdriver import ActionChains
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

SPEED = np.sqrt(5.0) * 0.1  # m/s, of the two balls that the default parameters lift by 0.1 m


@pytest.fixture(scope="module")
def browser():
    """Chromium without a GPU and without a window; skips where it is not installed."""
    program, driver = shutil.which("chromium") or shutil.which("google-chrome"), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("chromium or chromedriver is missing: on Debian, `apt install chromium chromium-driver`")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for argument in ("headless=new", "no-sandbox", "window-size=1280,860", "enable-unsafe-swiftshader"):
        options.add_argument(f"--{argument}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    started = webdriver.Chrome(options=options, service=Service(driver))
    yield started
    started.quit()


@pytest.fixture(scope="module")
def animation(fmu_path, tmp_path_factory):
    """The default experiment as a page."""
    path = tmp_path_factory.mktemp("animation") / "cradle.html"
    save_page(path, from_fmu(fmu_path))
    return path


def visit(browser, path) -> None:
    """Opens a page and asserts that it asks for nothing but itself and complains about nothing.

    Those with scripts are ready once they have left `cradle` or `report` in the window.
    """
    for kind in ("browser", "performance"):
        browser.get_log(kind)  # what earlier pages left
    browser.get(path.as_uri())
    WebDriverWait(browser, 60).until(
        lambda _: browser.execute_script(
            "return !document.scripts.length || Boolean(window.cradle ?? window.report)"
        )
    )
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    requests = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    assert [url for url in requests if not url.startswith(("data:", "blob:"))] == [path.as_uri()]


def colours(browser, element) -> int:
    """How many colours an element shows: a blank one has a single one."""
    picture = Image.open(io.BytesIO(element.screenshot_as_png)).convert("RGB")
    return len(np.unique(np.asarray(picture).reshape(-1, 3), axis=0))


def state(browser, t: float | None = None) -> dict:
    """What the player shows, at time t (s) if given."""
    if t is not None:
        browser.execute_script("cradle.seek(arguments[0])", t)
    return browser.execute_script("return cradle.state()")


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
        assert units[re.sub(r"\[\d+\]$", "[i]", variable.name)] == (variable.unit or "")


def test_the_report_shows_all_figures(browser, paper):
    out, _ = paper
    visit(browser, out / "report.html")
    charts = browser.find_elements(By.CSS_SELECTOR, ".chart canvas")
    assert len(charts) >= 12
    for chart in charts:
        browser.execute_script("arguments[0].scrollIntoView({behavior: 'instant', block: 'center'})", chart)
        assert colours(browser, chart) > 20, chart.accessible_name
    assert len(browser.find_elements(By.CSS_SELECTOR, "td.holds")) >= 50
    assert browser.find_elements(By.CSS_SELECTOR, "td.fails") == []


def test_the_report_zooms_from_seconds_to_nanoseconds(browser, paper):
    """A button of Figure 4 ends at 10 ns, where its first contact's force rises from 0; keys zoom on."""
    out, _ = paper
    visit(browser, out / "report.html")
    buttons = browser.find_elements(By.CSS_SELECTOR, "#figure4 button")
    browser.execute_script("arguments[0].scrollIntoView({behavior: 'instant'})", buttons[3])
    buttons[3].click()
    width = "const [chart] = report.charts.figure4; return chart.right - chart.left"
    WebDriverWait(browser, 30).until(lambda _: browser.execute_script(width) < 1.01e-8)
    left, right, largest = browser.execute_script(
        """const [chart] = report.charts.figure4, {x, y} = chart.strips[1].traces[0];
        return [chart.left, chart.right, Math.max(...y.filter((_, i) => x[i] >= chart.left && x[i] <= chart.right))]"""
    )
    assert left < 0.702481589380 < right
    assert 0 < largest < 3e6
    buttons[-1].click()
    assert browser.execute_script(width) == pytest.approx(2e-8, rel=1e-3)


def test_the_animation_moves_the_right_balls(browser, animation):
    """From rest, through the pulses of the first click in their order, to the other side."""
    visit(browser, animation)
    assert state(browser, 0.0)["v"] == [0] * 5
    assert state(browser)["x"] == pytest.approx([-0.1, -0.1, 0, 0, 0])
    browser.find_element(By.ID, "next").click()
    shown = state(browser)
    assert shown["time"] == pytest.approx(0.702493100658, abs=1e-12)
    assert np.divide(shown["v"], SPEED) == pytest.approx([1, 1, 0, 0, 0], abs=1e-6)
    begin, end = browser.execute_script(
        "const [impact] = cradle.run.impacts; return [impact.begin, impact.end]"
    )
    assert 5e-5 < end - begin < 1.5e-4
    moving = [(1, 0, 1, 0, 0), (0, 1, 0, 1, 0), (0, 0, 1, 0, 1), (0, 0, 0, 1, 1)]
    pulses = browser.execute_script("return cradle.run.pulses.map(({release}) => release[0])")
    for t, wanted in zip([pulses[1], pulses[0], pulses[3], end], moving, strict=True):
        shown = state(browser, t)
        assert np.divide(shown["v"], SPEED) == pytest.approx(wanted, abs=1e-4)
    middle = state(browser, 0.5 * (begin + pulses[1]))
    assert np.argmax(middle["glow"]) == 1 and middle["F"][1] > 1e4
    assert middle["speed"] < 1e-4


def test_the_animation_is_drawn(browser, animation):
    """Picture, strips and controls: not blank, other after scrubbing, and playing moves on."""
    visit(browser, animation)
    stage, strips, whole = (browser.find_element(By.ID, name) for name in ("stage", "strips", "whole"))
    assert colours(browser, stage) > 500
    assert colours(browser, strips) > 20
    before = stage.screenshot_as_png
    ActionChains(browser).move_to_element_with_offset(whole, whole.size["width"] // 4, 0).click().perform()
    assert state(browser)["time"] == pytest.approx(7.5, abs=0.05)
    assert stage.screenshot_as_png != before
    ActionChains(browser).drag_and_drop_by_offset(strips, whole.size["width"] // 8, 0).perform()
    assert state(browser)["time"] < 7.4
    state(browser, 0.0)
    browser.find_element(By.ID, "play").click()
    WebDriverWait(browser, 60).until(lambda _: state(browser)["time"] > 0.3)


def test_the_animation_has_the_licence_of_three_js(animation):
    assert "Permission is hereby granted, free of charge" in animation.read_text(encoding="utf-8")


def test_thirteen_balls_for_a_minute_stay_small(browser, fmu13_path, tmp_path):
    path = tmp_path / "thirteen.html"
    assert save_page(path, from_fmu(fmu13_path, nc.figure3(), stop=60.0)) < 5e6
    visit(browser, path)
    shown = state(browser, 0.5)
    assert len(shown["x"]) == 13 and len(shown["F"]) == 12
    assert np.divide(shown["v"], np.sqrt(9.81)) == pytest.approx([1] * 3 + [0] * 8 + [-1] * 2, abs=1e-4)
    assert colours(browser, browser.find_element(By.ID, "stage")) > 500


def test_an_animation_of_fmpys_result(browser, fmu_path, tmp_path):
    """A result that FMPy wrote, through the command line; impacts come from F_peak."""
    result = simulate_fmu(fmu_path, stop_time=3.0, output_interval=0.01)
    write_csv(tmp_path / "result.csv", result)
    done = page(tmp_path / "result.csv")
    assert done.returncode == 0, done.stderr
    visit(browser, tmp_path / "result.html")
    shown = state(browser, result["time"][123])
    assert shown["x"] == pytest.approx([result[f"x[{i}]"][123] for i in range(1, 6)], abs=1e-7)
    assert browser.execute_script("return cradle.run.impacts.map(({end}) => end)") == pytest.approx(
        [0.71, 2.11]
    )


def page(*arguments) -> subprocess.CompletedProcess:
    """The command that makes a page."""
    return subprocess.run(
        [sys.executable, "-m", "newtons_cradle", "page", *map(str, arguments)], capture_output=True, text=True
    )


def test_the_producer_makes_the_same_page(producer, fmu_path, tmp_path):
    """`cradle-fmu page` is the same command."""
    pages = [tmp_path / "one.html", tmp_path / "two.html"]
    options = [fmu_path, "--stop", "1", "--set", "contact.model=hertz", "--out"]
    assert page(*options, pages[0]).returncode == 0
    command = [producer, "page", "--python", sys.executable]
    done = subprocess.run([*command, *map(str, options), pages[1]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert pages[0].read_bytes() == pages[1].read_bytes()
    failed = subprocess.run([*command, "missing.fmu"], capture_output=True, text=True)
    assert failed.returncode == 1 and failed.stderr.startswith("error: ") and "import" not in failed.stderr


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "the columns time, x[1], x[2], ... are needed"),
        ("time,y\n0,1\n1,2\n", "the columns time, x[1], x[2], ... are needed; there are time, y"),
        ("time,x[1]\n0,1\n", "at least two rows are needed, with times that rise"),
        ("time,x[1]\n0,1\n0,2\n", "at least two rows are needed, with times that rise"),
        ("time,x[1]\n0,1\n1,red\n", "line 3: could not convert string to float: 'red'"),
        ("time,x[1]\n0,1\n1,2,3\n", "line 3: 3 numbers for 2 names"),
        ("time,x[1]\n0,1\n1,nan\n", "NaN or infinite numbers cannot be drawn"),
        ("time,x[1],x[2],F[1],F[2]\n0,1,2,3,4\n1,1,2,3,4\n", "2 positions need 1 of F, not 2"),
    ],
)
def test_a_bad_result_is_refused_in_words(tmp_path, text, complaint):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    done = page(path)
    assert done.returncode == 1
    assert done.stderr.startswith("error: ") and complaint in done.stderr
    assert not path.with_suffix(".html").exists()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["missing.csv"], "No such file"),
        (["missing.fmu"], "missing.fmu"),
        (["README.md"], "only .fmu and .csv files can be shown"),
        (["FMU", "--set", "foo=1"], "has no variable 'foo'"),
        (["FMU", "--set", "ball.mass=-1"], "ball.mass = -1 kg is refused"),
        (["FMU", "--set", "ball.mass=heavy"], "ball.mass = heavy is not a number"),
        (["FMU", "--set", "contact.model=glue"], "contact.model = glue is refused; allowed: powerLaw, hertz"),
    ],
)
def test_a_bad_command_is_refused_in_words(fmu_path, arguments, complaint):
    done = page(*(fmu_path if argument == "FMU" else argument for argument in arguments))
    assert done.returncode == 1
    assert done.stderr.startswith("error: ") and complaint in done.stderr
