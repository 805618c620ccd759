"""A headless Chromium for the tests of pages: windows of given sizes, light and dark; what a page shows, asks for and
complains about; pointers and keys; and the native run to compare with what runs in the page."""

import io
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.support.wait import WebDriverWait

SIZES = {"desktop": (1280, 800), "phone": (390, 844), "landscape": (844, 390)}
SIZES |= {"tablet": (768, 1024), "small": (320, 568), "low": (640, 400)}
SCREENS = SIZES | {"projector": (1920, 1080)}

# Pages draw 20 times a second: without a GPU, pictures take more processor time than all else that is tested.
FEW_FRAMES = "requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 50)"

# A page keeps nothing, and knows that 3D takes long, so that nobody measures that; in a window called "keeps" it does.
NOTHING_KEPT = """if (window.name !== "keeps") Object.assign(Storage.prototype,
  {getItem: () => '{"picture": 99}', setItem() {}});"""

GRID = [k / 64 for k in range(60 * 64 + 1)]  # s; doubles without rounding error
SUMS = ("E_total", "E_dissipated", "W_external", "E_residual", "p_total", "F_support", "solver.events")
COLUMNS = ("onset", "contact", "release", "peak", "impulse", "peak_time")  # of a pulse
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
  wide: seen(`html, body, main, nav, button, #panel, #panelbody, .strips, .caption, label, legend, h1, h2, dt, dd,
    p:not(.spoken), li`).flatMap(wide)}"""


class Browser(webdriver.Chrome):
    """Chromium without a GPU and without a window, with `more` options; skips where it is not installed."""

    def __init__(self, *more: str):
        program = shutil.which("chromium") or shutil.which("google-chrome")
        driver = shutil.which("chromedriver")
        if program is None or driver is None:
            pytest.skip("chromium or chromedriver is missing: on Debian, `apt install chromium chromium-driver`")
        options = webdriver.ChromeOptions()
        options.binary_location = program
        usual = "headless=new", "no-sandbox", "window-size=1280,860", "enable-unsafe-swiftshader"
        for argument in usual + more:
            options.add_argument(f"--{argument}")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        super().__init__(options=options, service=Service(driver))
        for source in (FEW_FRAMES, NOTHING_KEPT):
            self.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": source})

    def set_screen(self, size: str = "desktop", *, dark: bool = False, still: bool = False) -> None:
        """The size of what is seen, the colours that the user prefers, and whether motion is to be reduced."""
        width, height = SCREENS[size]
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        wishes = {
            "prefers-color-scheme": "dark" if dark else "light",
            "prefers-reduced-motion": "reduce" if still else "no-preference",
        }
        features = [{"name": name, "value": value} for name, value in wishes.items()]
        self.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})

    def visit(self, path: Path, link: str = "", **screen) -> None:
        """Opens a page on a screen and asserts that it asks for nothing but itself and says nothing on the console.

        Those with scripts are ready once they have left `cradle` or `report` in the window.
        """
        self.set_screen(**screen)
        for kind in ("browser", "performance"):
            self.get_log(kind)  # what earlier pages left
        self.load(path.as_uri() + link)
        self.assert_quiet()
        messages = [json.loads(entry["message"])["message"] for entry in self.get_log("performance")]
        requests = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        assert [url for url in requests if not url.startswith(("data:", "blob:"))] == [path.as_uri()]

    def load(self, address: str) -> None:
        """Opens an address anew, even if its page is open, and waits for its scripts."""
        self.get("about:blank")
        self.get(address)
        self.wait("!document.scripts.length || Boolean(window.cradle ?? window.report)", 60)

    def open_cradle(self, path: Path, link: str = "", **screen) -> None:
        """Opens the cradle's page as `visit` does; names that these of its modules export become its window's."""
        self.visit(path, link, **screen)
        rooms = ("engine/live", "engine/setup", "view/captions", "control/keep", "control/link", "view/graph")
        self.execute_script("Object.assign(window, ...arguments[0].map((room) => modules[`#${room}.js`]))", rooms)

    def assert_quiet(self) -> None:
        """Nothing on the console but what the renderer without a GPU says about itself."""
        entries = [entry for entry in self.get_log("browser") if "GPU stall" not in entry["message"]]
        assert entries == []

    def serious(self) -> list:
        """What axe-core, once its script has run in the page, finds serious or critical: rules and what breaks them."""
        options = {"resultTypes": ["violations"], "rules": {"label-content-name-mismatch": {"enabled": True}}}
        found = self.execute_async_script("axe.run(arguments[0]).then(arguments[1])", options)
        assert len(found["passes"]) > 10
        worst = [finding for finding in found["violations"] if finding["impact"] in ("serious", "critical")]
        return [(finding["id"], [node["html"][:200] for node in finding["nodes"]]) for finding in worst]

    def js(self, script: str, *given):
        """Runs a script in the page; `source` is the first cradle's, if it has one."""
        return self.execute_script(f"const {{source}} = window.cradle?.stages[0] ?? {{}}; {script}", *given)

    def wait(self, condition: str, seconds: float = 240, every: float = 0.1) -> None:
        """Until this is the case. However busy the machine is, a picture moves a run on by 50 ms at most."""
        WebDriverWait(self, seconds, every).until(lambda _: self.js(f"return {condition}"), condition)

    def drawn(self) -> None:
        """Waits until all is drawn as it is now."""
        self.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")

    def find(self, selector: str):
        """The first element that a selector of CSS finds."""
        return self.find_element("css selector", selector)

    def find_all(self, selector: str) -> list:
        return self.find_elements("css selector", selector)

    def text(self, selector: str) -> str:
        """What an element says once all is drawn."""
        self.drawn()
        return self.find(selector).text

    def seen(self, selector: str) -> bool:
        """Whether an element is shown."""
        return self.find(selector).is_displayed()

    def press(self, name: str) -> None:
        """Clicks the button with this id."""
        self.find(f"#{name}").click()

    def keys(self, *given: str) -> None:
        """Keys to whatever has the focus."""
        ActionChains(self).send_keys(*given).perform()

    def place(self, ball: int) -> tuple[int, int]:
        """Where a ball (from 0) is in the window, px."""
        script = """const {canvas, scene} = cradle.stages[0], box = canvas.getBoundingClientRect();
          const {x, y} = scene.place(arguments[0], source.state.x[arguments[0]]);
          return [box.left + x, box.top + y]"""
        x, y = self.js(script, ball)
        return round(x), round(y)

    def drag(self, ball: int, by: int, release: bool = True) -> None:
        """Takes a ball with the mouse, moves it aside by so many px, keeps still, and lets go."""
        x, y = self.place(ball)
        path = [(x + by * k // 5, y - abs(by) * k // 40) for k in range(6)]
        self.gesture(path, hold=0.3, release=release)

    def gesture(self, *paths, kind="mouse", button=0, hold: float = 0.0, release: bool = True) -> None:
        """Pointers that are pressed where their paths begin, follow them together, keep still for `hold` (s) and let
        go."""
        builder = ActionBuilder(self, mouse=PointerInput(kind, f"{kind}0"), duration=20)
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

    def let_go(self) -> None:
        """The mouse that a gesture has left pressed."""
        builder = ActionBuilder(self, mouse=PointerInput("mouse", "mouse0"))
        builder.pointer_action.pointer_up()
        builder.perform()

    def each_panel(self):
        """Opens and closes one panel after the other; their names."""
        for panel in PANELS:
            self.js("cradle.panels.toggle(arguments[0])", panel)
            yield panel
            self.js("cradle.panels.toggle(arguments[0])", panel)

    def boxes(self) -> list:
        """The canvases' boxes; asserts that nothing lies over one, and that nothing is cut off."""
        self.drawn()
        found = self.js(BOXES)
        assert (found["out"], found["wide"]) == ([], [])
        for a in found["canvases"]:
            for b in found["others"]:
                across = min(a["right"], b["right"]) - max(a["left"], b["left"])
                assert min(across, min(a["bottom"], b["bottom"]) - max(a["top"], b["top"])) <= 1, (a, b)
        return found["canvases"]

    def assert_native(self, fmu, recipe: dict | None = None, times=GRID[:640]) -> None:
        """At these times the recipe, or that of what runs in the page, gives the native run."""
        recipe = recipe or self.js("cradle.setRunning(false); return source.setup.recipe()")
        begun = f"return ({FOLLOW})(cradle.engine.start(arguments[0]), arguments[1])"
        rows, pulses = self.js(begun, recipe, times)
        assert same_run(fmu, recipe, rows, pulses, times) and len(pulses) > 10


def colours(element) -> int:
    """How many colours an element shows: a blank one has a single one."""
    picture = Image.open(io.BytesIO(element.screenshot_as_png)).convert("RGBA")
    return np.unique(np.frombuffer(picture.tobytes(), np.uint32)).size


def by_onset(pulses) -> np.ndarray:
    return np.array(sorted(tuple(float(pulse[name]) for name in COLUMNS) for pulse in pulses))


def same_run(fmu, recipe: dict, rows, pulses, times) -> bool:
    """Whether sums, positions, velocities and pulses of the page, whose contacts count from 0, are what the FMU gives
    for the recipe, to the last bit."""
    start = recipe["start"] | {"contact.model": ITEMS[recipe["start"].get("contact.model", "powerLaw")]}
    names = [*SUMS, *(f"{name}[{i}]" for name in "xv" for i in range(1, recipe["balls"] + 1))]
    result = fmu.simulate(start, times=times, record=names)
    wanted = np.column_stack([result[name] for name in names])
    rows = np.array(rows)[:, 1 : 1 + len(names)]
    counted = [pulse | {"contact": pulse["contact"] + 1, "peak_time": pulse["peakTime"]} for pulse in pulses]
    return (
        rows.tobytes() == wanted[-len(rows) :].tobytes()
        and by_onset(counted).tobytes() == by_onset(result.pulses).tobytes()
    )
