"""The page for those who see nothing of it and have only keys: what a screen reader says tells what happens."""

import re

import pytest
from selenium.webdriver import Keys

pytestmark = pytest.mark.all

#: From now on, what is announced: texts of live regions, once they have changed.
LISTEN = """window.heard = [];
new MutationObserver((changes) => {
  const regions = new Set(changes.map(({target}) => (target.nodeType === 1 ? target : target.parentElement)
    ?.closest("[aria-live], [role=status]")).filter(Boolean));
  for (const region of regions) if (region.textContent.trim()) heard.push(region.textContent.trim());
}).observe(document.body, {subtree: true, childList: true, characterData: true});"""


def heard(page, pattern: str, seconds: float = 120) -> str:
    """Waits until something is announced that matches; that. What was announced before it is forgotten."""
    page.wait(f"heard.some((text) => /{pattern}/.test(text))", seconds)
    found = page.js(f"return heard.splice(0, heard.findIndex((text) => /{pattern}/.test(text)) + 1).pop()")
    page.assert_quiet()
    return found


def go_to(page, name: str) -> None:
    """Presses Tab until something with this accessible name has the focus."""
    for _ in range(60):
        page.keys(Keys.TAB)
        if page.switch_to.active_element.accessible_name == name:
            return
    raise AssertionError(f"Tab does not lead to {name}")


def read(page) -> str:
    """The heading, and the text below it."""
    return page.find("h1").text + " " + page.find("#about").text


def test_heard_lesson_is_followed_by_ear_and_keys(browser, live_path):
    """Each step says what is new, asks, and tells who pushed whom, when and how hard, and what flew out."""
    browser.visit(live_path, "#preset=textbook")
    browser.js(LISTEN)
    go_to(browser, "Lesson")
    browser.keys(Keys.ENTER)
    go_to(browser, "Present it in large letters")
    browser.keys(Keys.ENTER)
    assert "Two balls are lifted" in read(browser)
    heard(browser, "How many balls will fly out")
    go_to(browser, "2")
    browser.keys(Keys.ENTER)
    told = heard(browser, "A click at")
    pushes = re.findall(r"Ball (\d) pushes ball (\d) after ([\d.]+) µs with up to ([\d.]+) kN", told)
    assert len(pushes) == 6 and pushes[0][:3] == ("2", "3", "0") and pushes[-1][:2] == ("3", "4")
    assert {float(force) for *_, force in pushes} == {35.3}
    assert told.endswith("ball 4 at 100 %, ball 5 at 100 %.")
    heard(browser, "You said 2, and 2 balls flew out")
    assert read(browser).startswith("1/6 Two up, two out")
    for step in range(2, 7):
        go_to(browser, "Next")
        browser.keys(Keys.ENTER)
        browser.wait(f"cradle.lesson.step === {step - 1}")
        browser.js("heard.length = 0")
        if step == 3:
            heard(browser, "Balls 2 and 3 meet in", 240)
            heard(browser, "The click took 176.µs: 6 pushes", 240)
        if step not in (4, 6):
            continue
        assert ("steel balls that touch" if step == 4 else "weighs half as much") in read(browser)
        browser.keys("2")
        browser.keys("i")  # without slow motion
        told = heard(browser, "A click at")
        last = "ball 5 at 114 %." if step == 4 else "ball 4 at 33 %, ball 5 at 133 %."
        assert told.endswith(last) and "pushes ball 5" in told
        heard(browser, "but 3 balls flew out" if step == 4 else "You said 2, and 2 balls flew out")
    go_to(browser, "End the lesson")
    browser.keys(Keys.ENTER)
    assert browser.find("h1").text == "Newton's cradle"


def test_heard_ball_is_lifted_by_ear_and_keys(page):
    """Its slider says where it is, in mm; the picture's name what moves."""
    page.js(LISTEN + "cradle.stopAll()")
    go_to(page, "Ball 1")
    ball = page.switch_to.active_element
    assert ball.get_attribute("aria-valuetext") == "hanging down"
    page.keys(Keys.ARROW_LEFT * 6)
    assert ball.get_attribute("aria-valuetext") == "60.0 mm to the left, held"
    assert float(ball.get_attribute("value")) == -60
    assert page.js("return document.activeElement.min <= -60")
    page.keys(Keys.ENTER)
    told = heard(page, "A click at")
    assert "Ball 1 pushes ball 2 after 0 µs" in told and told.endswith("ball 5 at 100 %.")
    page.wait("cradle.stages[0].canvas.ariaLabel.endsWith('Ball 5 moves.')")
    others = "[...document.querySelectorAll('.sliders input')].slice(1, 4).map((ball) => ball.ariaValueText)"
    assert page.js(f"return {others}") == ["hanging down"] * 3
    page.js("cradle.stopAll()")
    page.wait("cradle.stages[0].canvas.ariaLabel.endsWith('Each ball hangs still.')")


def test_heard_waiting_for_a_click_is_told(page):
    """Nothing moves yet; the button says that it is pressed, and no more once it is pressed again."""
    page.js(LISTEN + "cradle.stopAll()")
    pressed = "cradle.controls.inside.ariaPressed"
    page.keys("i")
    heard(page, "Time slows down at the next click")
    page.wait(f"{pressed} === 'true'")
    page.keys("i")
    page.wait(f"{pressed} === 'false'")


def test_heard_clicks_of_a_recording_are_told(browser, recorded_path):
    browser.open_cradle(recorded_path, still=True)
    browser.js(LISTEN)
    browser.keys("]")
    browser.js("cradle.seek(source.clicks[0].end)")
    assert "Ball 2 pushes ball 3 after 0 µs" in heard(browser, "A click at 0.702 s that took 90.4 µs")
