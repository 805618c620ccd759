"""A headless Chromium for the tests of pages: windows of given sizes, light and dark, and what a page shows, asks for
and complains about."""

import io
import json
import shutil

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.wait import WebDriverWait

SIZES = {"desktop": (1280, 800), "phone": (390, 844), "landscape": (844, 390)}

# Pages draw 20 times a second: without a GPU, pictures take more processor time than all else that is tested.
FEW_FRAMES = "requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 50)"


def start(*more: str):
    """Chromium without a GPU and without a window, with `more` options; skips where it is not installed."""
    program, driver = shutil.which("chromium") or shutil.which("google-chrome"), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("chromium or chromedriver is missing: on Debian, `apt install chromium chromium-driver`")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    usual = "headless=new", "no-sandbox", "window-size=1280,860", "enable-unsafe-swiftshader"
    for argument in usual + more:
        options.add_argument(f"--{argument}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(driver))
    browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": FEW_FRAMES})
    return browser


def set_screen(browser, size: str = "desktop", *, dark: bool = False, still: bool = False) -> None:
    """The size of what is seen, the colours that the user prefers, and whether motion is to be reduced."""
    width, height = SIZES[size]
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    wishes = {
        "prefers-color-scheme": "dark" if dark else "light",
        "prefers-reduced-motion": "reduce" if still else "no-preference",
    }
    features = [{"name": name, "value": value} for name, value in wishes.items()]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def visit(browser, path, link: str = "") -> None:
    """Opens a page and asserts that it asks for nothing but itself and says nothing on the console.

    Those with scripts are ready once they have left `cradle` or `report` in the window.
    """
    browser.get("about:blank")  # even if it is the same page that is open
    for kind in ("browser", "performance"):
        browser.get_log(kind)  # what earlier pages left
    browser.get(path.as_uri() + link)
    ready(browser)
    assert_quiet(browser)
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    requests = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    assert [url for url in requests if not url.startswith(("data:", "blob:"))] == [path.as_uri()]


def ready(browser) -> None:
    """Waits for the scripts of a page."""
    done = "return !document.scripts.length || Boolean(window.cradle ?? window.report)"
    WebDriverWait(browser, 60).until(lambda _: browser.execute_script(done))


def assert_quiet(browser) -> None:
    """Nothing on the console but what the renderer without a GPU says about itself."""
    entries = [entry for entry in browser.get_log("browser") if "GPU stall" not in entry["message"]]
    assert entries == []


def colours(browser, element) -> int:
    """How many colours an element shows: a blank one has a single one."""
    picture = Image.open(io.BytesIO(element.screenshot_as_png)).convert("RGBA")
    return np.unique(np.frombuffer(picture.tobytes(), np.uint32)).size


def serious(browser) -> list:
    """What axe-core, once its script has run in the page, finds serious or critical: rules, and what breaks them."""
    options = {"resultTypes": ["violations"], "rules": {"label-content-name-mismatch": {"enabled": True}}}
    found = browser.execute_async_script("axe.run(arguments[0]).then(arguments[1])", options)
    assert len(found["passes"]) > 10
    worst = [finding for finding in found["violations"] if finding["impact"] in ("serious", "critical")]
    return [(finding["id"], [node["html"][:200] for node in finding["nodes"]]) for finding in worst]
