#!/usr/bin/env python3
"""Measures the finished page in a headless Chromium: the first picture, the others, the engine's part of them, and memory.

    .venv/bin/python web/measure.py [--minutes 10]

Times are those of this machine, as busy as it is.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from selenium.webdriver.support.wait import WebDriverWait

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/hosts"))

import browser  # noqa: E402

PAGE = ROOT / "target/web/cradle.html"

# Lifts two balls and changes the contact every second. Notes of each picture, for half a minute: time since the last one,
# the engine's part (ms).
SWING = """
const [balls, done] = arguments, shown = [], begun = performance.now(), laws = Object.values(LAWS);
cradle.resize(balls);
cradle.lift(2);
let last = begun, changes = 0;
const note = (now) => {
  shown.push([now - last, cradle.spent]);
  last = now;
  if (now - begun > 1000 * (changes + 1)) cradle.change(laws[changes++ % laws.length]);
  if (now - begun < 30000) requestAnimationFrame(note);
  else done(shown);
};
requestAnimationFrame(note);
"""

# Goes on swinging, changing, looking into clicks.
USE = """
cradle.setShow('force', true); cradle.setShow('energy', true); let turn = 0;
setInterval(() => {
  turn++;
  if (turn % 5 === 0) cradle.lift(1 + turn % 4);
  if (turn % 7 === 0) cradle.inside();
  if (turn % 11 === 0) cradle.compare(turn % 2 ? 'hertz' : 'stop');
  cradle.change(Object.values(LAWS)[turn % 5]);
}, 1000);
"""


def visit(page, throttling: int = 1) -> float:
    """Opens the page with a processor so many times slower; how long the first picture took, ms."""
    page.get("about:blank")
    page.execute_cdp_cmd("Emulation.setCPUThrottlingRate", {"rate": throttling})
    page.get(PAGE.as_uri())
    WebDriverWait(page, 60).until(lambda _: page.execute_script("return Boolean(window.cradle?.first)"))
    return page.execute_script("return cradle.first")


def main() -> int:
    """Measures all of it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=int, default=10, help="how long memory is watched; 0: not at all")
    minutes = parser.parse_args().minutes
    page = browser.start()
    page.set_script_timeout(60)
    try:
        for throttling in (1, 4):
            first = np.median([visit(page, throttling) for _ in range(5)])
            print(f"processor / {throttling}: first picture after {first:.0f} ms (median of 5)")
            for balls in (5, 20):
                visit(page, throttling)
                table = np.array(page.execute_async_script(SWING, balls)[1:])
                for name, times in zip(("between pictures", "engine"), table.T, strict=True):
                    found = ", ".join(f"{np.quantile(times, q):.2f}" for q in (0.5, 0.99, 1))
                    print(f"  {balls} balls, {name}, median, 99 % and most: {found} ms", flush=True)
        visit(page)
        page.execute_script(USE)
        for minute in range(minutes):
            time.sleep(60)
            page.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
            script = page.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"]
            engine = page.execute_script("return cradle.engine.memory")
            print(
                f"minute {minute + 1}: script {script / 1e6:.1f} MB, engine {engine / 1e6:.1f} MB", flush=True
            )
    finally:
        page.quit()
    return 0


if __name__ == "__main__":
    sys.exit(main())
