#!/usr/bin/env python3
"""Makes the pictures of docs/lesson.md from the finished page: .venv/bin/python web/pictures.py"""

import io
import sys
from pathlib import Path

from PIL import Image
from selenium.webdriver.support.wait import WebDriverWait

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/hosts"))

import browser  # noqa: E402
import live_page  # noqa: E402

PAGE = ROOT / "target/web/cradle.html"
FOLDER = ROOT / "docs/lesson"
SIZE = (960, 600)

# Of each step of the lesson: a name, and when, in seconds after the release or as a part of the click.
STEPS = (("two", 0.52, None), ("energy", 3.4, None), ("inside", None, 0.115), ("steel", None, 0.36))
STEPS += (("beside", 10.05, None), ("faster", None, 1.04))
INSIDE = "cradle.sources[0].shownClick?.sampled && cradle.clock.rate < 1e-3 && cradle.stages[0].near > 0.99"
SEEK = "const click = cradle.sources[0].shownClick; cradle.seek(click.begin + arguments[0] * click.length)"


def main() -> int:
    """Opens each step, waits for its moment, and saves what is seen."""
    page = browser.start()
    try:
        FOLDER.mkdir(exist_ok=True)
        for step, (name, seconds, part) in enumerate(STEPS):
            screen = {"width": SIZE[0], "height": SIZE[1], "deviceScaleFactor": 1.5, "mobile": False}
            page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
            live_page.open_page(page, PAGE)
            page.execute_script("cradle.setTheme(false); location.hash = LESSON[arguments[0]]", step)
            swung = f"cradle.clock.base === 1 && cradle.sources[0].run.time > {seconds}"
            until = f"return {INSIDE if seconds is None else swung}"
            WebDriverWait(page, 60, 0.005).until(lambda _, until=until: page.execute_script(until))
            if part is not None:
                page.execute_script(SEEK, part)
                page.execute_async_script("setTimeout(arguments[0], 700)")
            picture = Image.open(io.BytesIO(page.get_screenshot_as_png())).convert("RGB")
            picture.save(FOLDER / f"{name}.jpg", quality=82, optimize=True)
            print(FOLDER / f"{name}.jpg")
    finally:
        page.quit()
    return 0


if __name__ == "__main__":
    sys.exit(main())
