"""The animation, opened from disk in a headless Chromium."""

import itertools

import newtons_cradle as nc
import numpy as np
import pytest
from browser import SIZES, colours, set_screen, state, visit
from fmpy import simulate_fmu
from fmpy.util import write_csv
from newtons_cradle.animation import from_csv, from_fmu, save_page
from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.wait import WebDriverWait

pytestmark = pytest.mark.all

SPEED = np.sqrt(5.0) * 0.1  # m/s, of the two balls that the default parameters lift by 0.1 m


@pytest.fixture
def player(browser, animation):
    """The browser with the animation of the default experiment open."""
    set_screen(browser)
    visit(browser, animation)
    return browser


def text(browser, name: str) -> str:
    """What an element says once all is drawn."""
    browser.execute_script("cradle.draw()")
    return browser.find_element(By.ID, name).text


def test_the_animation_moves_the_right_balls(player):
    """From rest, through the pulses of the first click in their order, to the other side."""
    assert state(player, 0.0)["v"] == [0] * 5
    assert state(player)["x"] == pytest.approx([-0.1, -0.1, 0, 0, 0])
    player.find_element(By.ID, "next").click()
    shown = state(player)
    assert shown["time"] == pytest.approx(0.702493100658, abs=1e-12)
    assert np.divide(shown["v"], SPEED) == pytest.approx([1, 1, 0, 0, 0], abs=1e-6)
    begin, end = player.execute_script("const [click] = cradle.run.clicks; return [click.begin, click.end]")
    assert 5e-5 < end - begin < 1.5e-4
    moving = [(1, 0, 1, 0, 0), (0, 1, 0, 1, 0), (0, 0, 1, 0, 1), (0, 0, 0, 1, 1)]
    pulses = player.execute_script("return cradle.run.pulses.map(({release}) => release[0])")
    for t, wanted in zip([pulses[1], pulses[0], pulses[3], end], moving, strict=True):
        assert np.divide(state(player, t)["v"], SPEED) == pytest.approx(wanted, abs=1e-4)
    middle = state(player, 0.5 * (begin + pulses[1]))
    assert np.argmax(middle["glow"]) == 1 and middle["F"][1] > 1e4


def test_the_animation_is_drawn(player):
    """Picture, curves and controls: not blank, other after scrubbing, and playing moves on."""
    names = ("stage", "energy", "force", "whole")
    stage, energy, force, whole = (player.find_element(By.ID, name) for name in names)
    assert colours(player, stage) > 500
    assert min(colours(player, canvas) for canvas in (energy, force)) > 20
    before = stage.screenshot_as_png
    ActionChains(player).move_to_element_with_offset(whole, whole.size["width"] // 4, 0).click().perform()
    assert state(player)["time"] == pytest.approx(7.5, abs=0.1)
    assert stage.screenshot_as_png != before
    ActionChains(player).drag_and_drop_by_offset(force, whole.size["width"] // 8, 0).perform()
    assert state(player)["time"] < 7.3
    state(player, 0.0)
    player.find_element(By.ID, "play").click()
    WebDriverWait(player, 60).until(lambda _: state(player)["time"] > 0.3)


#: Seconds of the viewer's that playing up to a time takes, in frames of 20 ms.
PLAYED = """const until = arguments[0];
let seconds = 0;
for (; cradle.t < until; seconds += 0.02) cradle.advance(0.02, 0);
return seconds;"""


def test_only_the_first_click_is_slow(player):
    assert 8 < player.execute_script(PLAYED, 1.5) < 25
    assert player.execute_script(PLAYED, 6.5) == pytest.approx(5.0, abs=0.1)
    player.execute_script("cradle.seek(0)")
    assert player.execute_script(PLAYED, 1.5) == pytest.approx(1.5, abs=0.1)


def test_a_click_can_be_looked_into_stage_by_stage(player):
    """The third click, by buttons; captions say what happens."""
    player.execute_script("cradle.seek(3.6); cradle.go(3.6)")
    assert text(player, "caption") == "Click 3 of 7."
    player.find_element(By.ID, "inside").click()
    WebDriverWait(player, 60).until(lambda _: player.execute_script("return cradle.inside"))
    player.execute_script("cradle.play(false); cradle.seek(cradle.opened.begin - 1e-9)")
    assert text(player, "caption") == "Click 3 of 7: balls 1 and 2 arrive at 224 mm/s."
    assert "1 s shows" in text(player, "pace") and "µs" in text(player, "pace")
    captions = []
    for _ in range(8):
        player.find_element(By.ID, "next").click()
        captions.append(text(player, "caption").removeprefix("Click 3 of 7, "))
    assert captions == [
        "stage 1 of 7: balls 2 and 3 press each other, up to 15.8 kN.",
        "stage 2 of 7: no balls touch; balls 1 and 3 move.",
        "stage 3 of 7: balls 1 and 2, and 3 and 4 press each other, up to 15.8 kN.",
        "stage 4 of 7: no balls touch; balls 2 and 4 move.",
        "stage 5 of 7: balls 2 and 3, and 4 and 5 press each other, up to 15.8 kN.",
        "stage 6 of 7: no balls touch; balls 3 and 5 move.",
        "stage 7 of 7: balls 3 and 4 press each other, up to 15.8 kN.",
        "Click 3 of 7 took 90.4 µs: balls 4 and 5 leave at 224 mm/s.",
    ]
    player.find_element(By.ID, "inside").click()
    assert state(player)["speed"] == 1
    assert text(player, "inside") == "Look inside this click"


def test_nothing_is_opened_that_has_no_inside(browser, fmu_path, tmp_path):
    """Rigid impacts that take no time."""
    path = tmp_path / "rigid.html"
    save_page(path, from_fmu(fmu_path, {"contact.model": "rigid", "contact.deadBand": 0.0}, stop=3.0))
    visit(browser, path)
    assert not browser.find_element(By.ID, "inside").is_enabled()
    assert text(browser, "caption") == "Rigid impacts take no time: there is nothing to look into."
    assert browser.execute_script(PLAYED, 2.9) == pytest.approx(2.9, abs=0.1)


#: By how much of the picture's half the balls stay away from its sides; negative where one is cut off.
MARGIN = """cradle.draw();
const {eye, shown, radius} = cradle.scene, forward = eye.camera.getWorldDirection(new THREE.Vector3());
return Math.min(...shown.map(({x, y}) => {
  const ball = new THREE.Vector3(x, y, 0), {x: h, y: v} = ball.clone().project(eye.camera);
  const deep = ball.clone().sub(eye.camera.position).dot(forward);
  const size = radius / deep / Math.tan(OPENING / 2);
  return Math.min(1 - Math.abs(v) - size, 1 - Math.abs(h) - size / eye.camera.aspect);
}));"""


@pytest.mark.parametrize("size", SIZES)
def test_coming_closer_cuts_no_ball_off(browser, animation, size):
    """From all sides and all the way, in every phase of the swing; the balls fill most of the picture's width or
    height."""
    set_screen(browser, size)
    visit(browser, animation)
    for t, factor, azimuth, height in itertools.product(
        (0, 0.5, 2.1, 2.9), (10, 1, 0.5, 1e-9), (0.28, 1.2, 3.0), (-0.2, 0.2, 1.2)
    ):
        browser.execute_script(
            "const [t, factor, azimuth, height] = arguments, {eye} = cradle.scene; cradle.seek(t);"
            "eye.home(); eye.approach(factor); Object.assign(eye, {azimuth, height}); cradle.draw()",
            t, factor, azimuth, height,
        )  # fmt: skip
        margin = browser.execute_script(MARGIN)
        assert margin > 0, (t, factor, azimuth, height)
    browser.execute_script(
        "cradle.open(); cradle.play(false); cradle.jump(1); cradle.scene.eye.close = 1; cradle.scene.eye.home()"
    )
    assert 0 < browser.execute_script(MARGIN) < 0.5


def test_two_fingers_come_closer(player):
    zoom = "return cradle.scene.eye.zoom"
    before = player.execute_script(zoom)
    for kind, apart in (("touchStart", 40), ("touchMove", 80), ("touchMove", 120), ("touchEnd", None)):
        points = [] if apart is None else [{"x": 600 + side * apart, "y": 250, "id": side} for side in (0, 1)]
        player.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    WebDriverWait(player, 60).until(lambda _: player.execute_script(zoom) < 0.8 * before)


def test_the_values_at_the_pointer(player):
    """Energies and forces at the time shown, or below the pointer, with prefixes of their units."""
    player.execute_script("cradle.open(); cradle.play(false)")
    player.execute_script("cradle.seek(cradle.opened.begin - 1e-9); cradle.jump(1)")
    forces = "Contact forces 1\u20132 0 N 2\u20133 15.8 kN 3\u20134 0 N 4\u20135 0 N"
    assert text(player, "forces").split() == forces.split()
    assert "in contacts 12.5 mJ" in text(player, "energies")
    force = player.find_element(By.ID, "force")
    ActionChains(player).move_to_element_with_offset(force, force.size["width"] // 5, 0).perform()
    pointer = "return cradle.strips.pointer"
    WebDriverWait(player, 60).until(lambda _: player.execute_script(pointer) is not None)
    assert "1\u20132 0 N" not in text(player, "forces").replace("\n", " ")
    assert player.execute_script("return cradle.strips.reading") > state(player)["time"]


def test_the_keyboard_does_all(player):
    body = player.find_element(By.TAG_NAME, "body")
    body.send_keys("]")
    assert state(player)["time"] == pytest.approx(0.702493100658, abs=1e-12)
    body.send_keys("]")
    assert state(player)["time"] == pytest.approx(2.1075697, abs=1e-6)
    body.send_keys("[")
    body.send_keys(Keys.ARROW_RIGHT)
    assert state(player)["time"] == pytest.approx(0.702493100658 + 0.16, abs=1e-9)
    body.send_keys("i")
    WebDriverWait(player, 60).until(lambda _: player.execute_script("return cradle.inside && cradle.playing"))
    body.send_keys(" ")
    assert not player.execute_script("return cradle.playing")
    body.send_keys("i")
    assert state(player)["speed"] == 1
    stage = player.find_element(By.ID, "stage")
    eye = "const {azimuth, height, zoom} = cradle.scene.eye; return [azimuth, height, zoom]"
    before = player.execute_script(eye)
    stage.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_UP, "+")
    assert np.all(np.not_equal(player.execute_script(eye), before))
    stage.send_keys("0")
    assert player.execute_script(eye) == before
    order = []
    for _ in range(8):
        player.switch_to.active_element.send_keys(Keys.TAB)
        order.append(player.switch_to.active_element.get_attribute("id"))
    assert order[:7] == ["previous", "play", "next", "inside", "speed", "about", "whole"]
    player.find_element(By.ID, "about").send_keys(Keys.ENTER)
    assert player.find_element(By.ID, "details").is_displayed()
    player.switch_to.active_element.send_keys(Keys.ESCAPE)
    WebDriverWait(player, 60).until(lambda _: not player.find_element(By.ID, "details").is_displayed())


def test_parameters_are_shown_with_their_units(player, fmu):
    player.find_element(By.ID, "about").click()
    rows = player.execute_script(
        "return [...document.querySelectorAll('#parameters tbody tr')].map((row) => [...row.cells].map((cell) => "
        "cell.textContent))"
    )
    shown = {name: (value, unit) for name, value, unit, _ in rows}
    assert shown["contact.stiffness"] == ("1e+10", "N/m")
    assert shown["contact.model"] == ("powerLaw", "")
    assert shown["x_start[i]"] == ("-0.1, -0.1, 0, 0, 0", "m")
    names = {v.name.partition("[")[0] for v in fmu.description.modelVariables if v.causality == "parameter"}
    assert {name.partition("[")[0] for name in shown} == names


def test_motion_is_reduced_where_that_is_wanted(browser, animation):
    """A click opens at its first stage and stays there; the eye jumps; nothing glows on."""
    set_screen(browser, still=True)
    visit(browser, animation)
    browser.find_element(By.ID, "inside").click()
    assert not browser.execute_script("return cradle.playing")
    assert ", stage 1 of 7: " in text(browser, "caption")
    WebDriverWait(browser, 60).until(lambda _: browser.execute_script("return cradle.scene.eye.close") == 1)
    after = browser.execute_script("return cradle.opened.stages[1].from + 1e-9")
    assert max(state(browser, after)["glow"]) == 0
    browser.find_element(By.ID, "next").click()
    browser.find_element(By.ID, "next").click()
    assert ", stage 4 of 7: " in text(browser, "caption")


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
    """Impacts come from F_peak; its samples are too far apart to look inside a click."""
    result = simulate_fmu(fmu_path, stop_time=3.0, output_interval=0.01)
    write_csv(tmp_path / "result.csv", result)
    path = tmp_path / "result.html"
    save_page(path, from_csv(tmp_path / "result.csv"))
    set_screen(browser)
    visit(browser, path)
    shown = state(browser, result["time"][123])
    assert shown["x"] == pytest.approx([result[f"x[{i}]"][123] for i in range(1, 6)], abs=1e-7)
    ends = browser.execute_script("return cradle.run.clicks.map(({end}) => end)")
    assert ends == pytest.approx([0.71, 2.11])
    assert not browser.find_element(By.ID, "inside").is_enabled()
    assert text(browser, "caption") == "Click 1 of 2. The samples do not resolve this click."
