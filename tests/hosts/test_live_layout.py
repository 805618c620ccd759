"""Where things are on the page in which the engine runs live, in windows of all sizes: no panel and no strip covers the
balls, which can be dragged beside them; nothing is cut off."""

import pytest
from browser import SIZES, set_screen
from live_page import DRAWN, drag, each_panel, js, wait

pytestmark = pytest.mark.all

# The boxes of canvases and of what must not cover them, and how far anything that is seen sticks out of the window.
BOXES = """
const box = (item) => { const {left, top, right, bottom} = item.getBoundingClientRect();
  return {left, top, right, bottom}; };
const seen = (names) => [...document.querySelectorAll(names)].filter((item) => item.checkVisibility());
const out = (item) => { const {left, top, right, bottom} = box(item);
  return left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1 ? [item.id || item.className] : []; };
const wide = (item) => item.scrollWidth > item.clientWidth + 1 ? [item.id || item.className || item.tagName] : [];
return {canvases: seen(".cradle").map(box), others: seen("#panel, nav, .strips, .caption").map(box),
  out: seen("nav button, #panel, .cradle, .caption, .strips, header").flatMap(out),
  wide: seen(`html, body, main, nav, button, #panel, #panelbody, .strips, .caption, label, legend, h1, h2, p, dt, dd,
    li`).flatMap(wide)}"""


def boxes(page) -> list:
    """The canvases' boxes; asserts that nothing lies over one, and that nothing is cut off."""
    page.execute_async_script(DRAWN)
    found = js(page, BOXES)
    assert (found["out"], found["wide"]) == ([], [])
    for a in found["canvases"]:
        for b in found["others"]:
            across = min(a["right"], b["right"]) - max(a["left"], b["left"])
            assert min(across, min(a["bottom"], b["bottom"]) - max(a["top"], b["top"])) <= 1, (a, b)
    return found["canvases"]


@pytest.mark.parametrize("size", SIZES)
def test_balls_are_beside_each_panel(page, size):
    """They are as large as can be told apart, and a hand takes one of them; in German, whose words are long."""
    set_screen(page, size)
    js(page, "cradle.setLanguage('de')")
    for beside, least in (("stop", 140), ("hertz", 120)):
        js(page, "cradle.compare(arguments[0])", beside)
        boxes(page)
        for panel in each_panel(page):
            assert all(box["bottom"] - box["top"] > least for box in boxes(page)), panel
        js(page, "cradle.panels.toggle('change')")
        boxes(page)
        drag(page, 0, -30)
        lifted = page.execute_script("return cradle.sources.map(({setup}) => setup.values.x_start[0])")
        assert max(lifted) < -0.01
        js(page, "cradle.panels.toggle('change'); cradle.stopAll()")


@pytest.mark.parametrize("size", SIZES)
def test_a_class_sees_all_of_the_lesson(page, size):
    """Each step in large letters, with its question where there is one."""
    set_screen(page, size)
    for step in range(1, 7):
        js(page, "cradle.open(`present=${arguments[0]}`)", step)
        assert all(box["bottom"] - box["top"] > 120 for box in boxes(page)), step


@pytest.mark.parametrize("size", SIZES)
def test_the_cradle_fills_its_room(page, size):
    """Swinging, it comes close to two sides of its canvas at least, and sticks out at none. All strips together take
    no more of its height than two and a bit; the rest is scrolled to."""
    set_screen(page, size)
    js(page, "cradle.lift(2)")
    wait(page, "source.run.time > 1.5")
    [alone] = boxes(page)
    across, up = js(
        page,
        """const {scene, canvas} = cradle.stages[0], {unit, floor, top} = scene;
        const {x} = scene.place(0, -0.1), {x: last} = scene.place(4, 0.1);
        return [(last - x + 2 * unit) / canvas.clientWidth, (floor + 0.42 * unit - top) / canvas.clientHeight]""",
    )
    assert 0.85 < max(across, up) < 1
    js(page, "for (const kind of ['velocity', 'force', 'energy', 'momentum']) cradle.setShow(kind, true)")
    wait(page, "cradle.stages[0].strips.box.scrollHeight > 1.5 * cradle.stages[0].strips.box.clientHeight")
    [beside] = boxes(page)
    assert beside["bottom"] - beside["top"] > 0.6 * (alone["bottom"] - alone["top"])
