"""What the tests of the page share: the page in Chromium, pointers, and the native run to compare with."""

from pathlib import Path

import numpy as np
from browser import visit
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

GRID = [k / 64 for k in range(60 * 64 + 1)]  # s; doubles without rounding error
SUMS = ("E_total", "E_dissipated", "W_external", "E_residual", "p_total", "F_support", "solver.events")
COLUMNS = ("onset", "contact", "release", "peak", "impulse")  # of a pulse
# What a run shows at given times, and its pulses.
FOLLOW = """(run, times) => {
  const pulses = [];
  const rows = times.map((time) => {
    run.advance(time);
    pulses.push(...run.takePulses());
    return Array.from(run.look().numbers);
  });
  return [rows, pulses];
}"""
ITEMS = {"powerLaw": 1, "hertz": 2, "rigid": 3}
PANELS = ("change", "show", "beside", "lesson", "keep", "help")
DRAWN = "requestAnimationFrame(() => requestAnimationFrame(arguments[0]))"


def open_page(browser, path: Path, link: str = "#preset=textbook") -> None:
    """Opens the page by a link, so that nothing moves by itself, or "" for what is recorded in it; names that its
    modules export become its window's."""
    visit(browser, path, link)
    rooms = ("engine/live", "engine/setup", "view/captions", "control/keep", "control/link")
    script = """const [rooms, done] = arguments;
      Promise.all(rooms.map((room) => import(`#${room}.js`))).then((all) => done(Object.assign(window, ...all) && 0))"""
    browser.execute_async_script(script, rooms)


def by_onset(pulses) -> np.ndarray:
    return np.array(sorted(tuple(float(pulse[name]) for name in COLUMNS) for pulse in pulses))


def same_run(fmu, recipe: dict, rows, pulses, times=GRID) -> bool:
    """Whether sums, positions, velocities and pulses of the page, whose contacts count from 0, are what the FMU gives
    for the recipe, to the last bit."""
    start = recipe["start"] | {"contact.model": ITEMS[recipe["start"].get("contact.model", "powerLaw")]}
    names = [*SUMS, *(f"{name}[{i}]" for name in "xv" for i in range(1, recipe["balls"] + 1))]
    result = fmu.simulate(start, times=times, record=names)
    wanted = np.column_stack([result[name] for name in names])
    rows = np.array(rows)[:, 1 : 1 + len(names)]
    counted = [pulse | {"contact": pulse["contact"] + 1} for pulse in pulses]
    return (
        rows.tobytes() == wanted[-len(rows) :].tobytes()
        and by_onset(counted).tobytes() == by_onset(result.pulses).tobytes()
    )


def js(page, script: str, *given):
    """Runs a script in the page; `source` is the first cradle's."""
    return page.execute_script(f"const {{source}} = cradle.stages[0]; {script}", *given)


def place(page, ball: int) -> tuple[int, int]:
    """Where a ball (from 0) is in the window, px."""
    x, y = js(
        page,
        """const {canvas, scene} = cradle.stages[0], box = canvas.getBoundingClientRect();
        const {x, y} = scene.place(arguments[0], source.state.x[arguments[0]]);
        return [box.left + x, box.top + y]""",
        ball,
    )
    return round(x), round(y)


def drag(page, ball: int, by: int, kind="mouse", hold: float = 0.3, release: bool = True) -> None:
    """Takes a ball with a pointer, moves it aside by so many px, keeps still, and lets go."""
    x, y = place(page, ball)
    path = [(x + by * k // 5, y - abs(by) * k // 40) for k in range(6)]
    gesture(page, path, kind=kind, hold=hold, release=release)


def gesture(page, *paths, kind="mouse", button=0, hold: float = 0.0, release: bool = True) -> None:
    """Pointers that are pressed where their paths begin, follow them together, keep still for `hold` (s) and let go."""
    builder = ActionBuilder(page, mouse=PointerInput(kind, f"{kind}0"), duration=20)
    others = (builder.add_pointer_input(kind, f"{kind}{k}") for k in range(1, len(paths)))
    for pointer, path in zip([builder.pointer_action.source, *others], paths, strict=True):
        for k, (x, y) in enumerate(path):
            pointer.create_pointer_move(duration=20 if k else 0, x=x, y=y)
            if k == 0:
                pointer.create_pointer_down(button=button)
        pointer.create_pause(hold)
        if release:
            pointer.create_pointer_up(button=button)
    builder.perform()


def let_go(page) -> None:
    """The mouse that a gesture has left pressed."""
    builder = ActionBuilder(page, mouse=PointerInput("mouse", "mouse0"))
    builder.pointer_action.pointer_up()
    builder.perform()


def press(page, name: str) -> None:
    page.find_element(By.ID, name).click()


def keys(page, *given: str) -> None:
    """Keys to whatever has the focus."""
    ActionChains(page).send_keys(*given).perform()


def text(page, selector: str) -> str:
    """What an element says once all is drawn."""
    page.execute_async_script(DRAWN)
    return page.find_element(By.CSS_SELECTOR, selector).text


def each_panel(page):
    """Opens and closes one panel after the other; their names."""
    for panel in PANELS:
        js(page, "cradle.panels.toggle(arguments[0])", panel)
        yield panel
        js(page, "cradle.panels.toggle(arguments[0])", panel)


def assert_native(page, fmu) -> None:
    """Ten seconds of what runs in the page, from its start, are the native run."""
    js(page, "cradle.setRunning(false)")
    begin = "const recipe = source.setup.recipe(), run = source.engine.start(recipe)"
    recipe, rows, pulses = js(page, f"{begin}; return [recipe, ...({FOLLOW})(run, arguments[0])]", GRID[:640])
    assert same_run(fmu, recipe, rows, pulses, GRID[:640]) and len(pulses) > 10


# The boxes of canvases and of what must not cover them, and how far anything that is seen sticks out of the window.
BOXES = """
const box = (item) => { const {left, top, right, bottom} = item.getBoundingClientRect();
  return {left, top, right, bottom}; };
const seen = (names) => [...document.querySelectorAll(names)].filter((item) => item.checkVisibility());
const out = (item) => { const {left, top, right, bottom} = box(item);
  const inside = left >= -1 && top >= -1 && right <= innerWidth + 1 && bottom <= innerHeight + 1;
  return inside ? [] : [item.id || item.className]; };
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


def wait(page, condition: str) -> None:
    """Until this is the case. However busy the machine is, a picture moves a run on by 50 ms at most."""
    WebDriverWait(page, 240).until(lambda _: js(page, f"return {condition}"), condition)
