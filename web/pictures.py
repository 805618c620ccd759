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

PAGE = ROOT / "target/web/cradle.html"
FOLDER = ROOT / "docs/lesson"
SIZE = (960, 600)

# Name, the step of the lesson (from 0), and when: seconds after the release, or a part of the click.
STEPS = (
    ("two", 0, {"time": 0.52}),
    ("energy", 1, {"time": 3.4}),
    ("inside", 2, {"part": 0.115}),
    ("steel", 3, {"part": 0.36}),
    ("beside", 4, {"time": 10.05}),
    ("faster", 5, {"part": 1.04}),
)


def main() -> int:
    """Opens each step, waits for its moment, and saves what is seen."""
    page = browser.start()
    try:
        FOLDER.mkdir(exist_ok=True)
        for name, step, when in STEPS:
            page.execute_cdp_cmd(
                "Emulation.setDeviceMetricsOverride",
                {"width": SIZE[0], "height": SIZE[1], "deviceScaleFactor": 1.5, "mobile": False},
            )
            browser.visit(page, PAGE)
            page.execute_script("cradle.setTheme(false); location.hash = LESSON[arguments[0]]", step)
            if "time" in when:
                condition = f"cradle.clock.base === 1 && cradle.sources[0].run.time > {when['time']}"
            else:
                condition = "cradle.sources[0].shownClick?.sampled && cradle.clock.rate < 1e-3 && cradle.stages[0].near > 0.99"
            WebDriverWait(page, 60, 0.005).until(lambda _, c=condition: page.execute_script(f"return {c}"))
            if "part" in when:
                seek = "const click = cradle.sources[0].shownClick; cradle.seek(click.begin + arguments[0] * click.length)"
                page.execute_script(seek, when["part"])
                page.execute_async_script("setTimeout(arguments[0], 700)")
            picture = Image.open(io.BytesIO(page.get_screenshot_as_png())).convert("RGB")
            picture.save(FOLDER / f"{name}.jpg", quality=82, optimize=True)
            print(FOLDER / f"{name}.jpg")
    finally:
        page.quit()
    return 0


if __name__ == "__main__":
    sys.exit(main())
