"""The page for classes: what will fly out is asked before it is seen, and the lesson is presented step by step."""

import pytest
from browser import visit
from live_page import drag, js, keys, press, wait
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.all

SENTENCE = "cradle.stages[0].sentence.textContent"


def guess(page, count: int) -> None:
    page.find_elements(By.CSS_SELECTOR, "#guesses button")[count - 1].click()


@pytest.mark.parametrize(
    "preset, lifted, guessed, said",
    [
        ("textbook", 2, 2, "You said 2, and 2 balls flew out."),
        ("textbook", 3, 1, "You said 1, but 3 balls flew out."),
        ("textbook", 1, 5, "You said 5, but one ball flew out."),
        ("hertz", 2, 2, "You said 2, but 3 balls flew out."),
        ("rigid", 4, 4, "You said 4, and 4 balls flew out."),
    ],
)
def test_a_class_says_what_will_fly_out(page, preset, lifted, guessed, said):
    """Time stands still until it has; then it is told what did."""
    js(page, f"cradle.choose('{preset}'); cradle.setOther('ask', true); cradle.lift({lifted})")
    wait(page, f"{SENTENCE} === 'How many balls will fly out on the other side?'")
    assert len(page.find_elements(By.CSS_SELECTOR, "#guesses button")) == 5
    assert js(page, "return [cradle.clock.running, source.run.time]") == [False, 0]
    guess(page, guessed)
    assert not page.find_element(By.ID, "guesses").is_displayed()
    wait(page, f"{SENTENCE}.startsWith('You said')")
    shown, detail = js(page, f"return [{SENTENCE}, cradle.stages[0].detail.textContent]")
    assert shown == said and detail.startswith("Compared with the incoming speed: ball")


def test_a_hand_is_asked_as_well_and_may_go_on_without_an_answer(page):
    js(page, "cradle.setOther('ask', true)")
    drag(page, 1, -80)
    shown = js(page, "return [cradle.lesson.phase, cradle.clock.running, source.holds.size]")
    assert shown == ["asks", False, 0]
    lifted = js(page, "return source.setup.values.x_start[0]")
    assert js(page, "return source.state.x[0]") == lifted < -0.01
    keys(page, "2")  # a guess, not two balls to be lifted
    assert js(page, "return [cradle.lesson.phase, source.setup.values.x_start[0]]") == ["waits", lifted]
    js(page, "cradle.lift(1)")
    keys(page, Keys.SPACE)
    wait(page, "cradle.lesson.phase === null && source.pulses.length > 0")
    assert not page.find_element(By.ID, "guesses").is_displayed()
    js(page, "cradle.lift(2)")
    assert page.find_element(By.ID, "guesses").is_displayed()
    js(page, "cradle.stopAll()")
    assert not page.find_element(By.ID, "guesses").is_displayed()
    assert "&ask" in js(page, "return linkTo(cradle)")


def test_the_lesson_is_presented_step_by_step(page, live_path):
    """The head of the page does not give the answer away; each step has its link, and Escape leaves."""
    visit(page, live_path, "#present")
    titles = []
    for step in range(1, 7):
        assert page.execute_script("return location.hash") == f"#present={step}"
        asked = step in (1, 4, 6)
        assert (page.find_element(By.TAG_NAME, "h1").text == "What will fly out?") is asked
        assert page.find_element(By.ID, "guesses").is_displayed() is asked
        if asked:
            assert page.find_element(By.ID, "about").text == ""
            guess(page, 2)
            js(page, "cradle.clock.slowAt('no')")
            wait(page, "cradle.lesson.phase === 'knows'")
        titles.append(page.find_element(By.TAG_NAME, "h1").text)
        assert not page.find_element(By.ID, "openers").is_displayed()
        press(page, "nextStep")
    assert len(set(titles)) == 6 and titles[1] == "Why not one, twice as fast?"
    assert page.find_element(By.ID, "openers").is_displayed()
    visit(page, live_path, "#present=5")
    assert page.find_element(By.TAG_NAME, "h1").text == "See the difference grow"
    keys(page, Keys.ESCAPE)
    assert page.find_element(By.TAG_NAME, "h1").text == "Newton's cradle"
    assert page.execute_script("return location.hash").startswith("#preset=textbook")
