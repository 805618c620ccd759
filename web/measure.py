#!/usr/bin/env python3
"""Measures the finished page in a headless Chromium, beside the native engine, and prints what it found.

    .venv/bin/python web/measure.py [--fmu FILE] [--minutes 10]

It needs Chromium with its driver, Selenium and FMPy. Times are those of this machine, as busy as it is.
"""

import argparse
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python"))

import newtons_cradle as nc  # noqa: E402
from selenium import webdriver  # noqa: E402
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.support.wait import WebDriverWait  # noqa: E402

PAGE = ROOT / "target/web/cradle.html"
SECONDS = 30  # of each measurement of pictures
LAWS = ("linear", "hertz", "quadratic", "rigid", "cubic")

# Lifts two balls, changes the contact every second, and notes each picture: time between pictures, the engine's part (ms).
SWING = """
const [balls, seconds, laws, done] = arguments, shown = [], begun = performance.now();
cradle.resize(balls);
cradle.lift(2);
let last = begun, changes = 0;
const note = (now) => {
  shown.push([now - last, cradle.spent]);
  last = now;
  if (now - begun > 1000 * (changes + 1)) cradle.change(LAWS[laws[changes++ % laws.length]]);
  if (now - begun < 1000 * seconds) requestAnimationFrame(note);
  else done([shown, changes]);
};
requestAnimationFrame(note);
"""

FIGURE6 = """
const run = cradle.engine.start(fromFile("figure6").recipe()), begun = performance.now();
run.advance(600);
const passed = performance.now() - begun, {energy, residual} = run.look();
run.forget();
return [passed / 1000, residual / energy]
"""


def browser() -> webdriver.Chrome:
    """A Chromium of 1280 by 860."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome") or ""
    for argument in ("headless=new", "no-sandbox", "window-size=1280,860", "enable-precise-memory-info"):
        options.add_argument(f"--{argument}")
    started = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    started.set_script_timeout(3600)
    return started


def visit(page, throttling: int = 1) -> float:
    """Opens the page with a processor so many times slower; how long the first picture took, ms."""
    page.get("about:blank")
    page.execute_cdp_cmd("Emulation.setCPUThrottlingRate", {"rate": throttling})
    page.get(PAGE.as_uri())
    WebDriverWait(page, 60).until(lambda _: page.execute_script("return Boolean(window.cradle?.first)"))
    return page.execute_script("return cradle.first")


def pictures(page, balls: int, throttling: int) -> str:
    visit(page, throttling)
    shown, changes = page.execute_async_script(SWING, balls, SECONDS, LAWS)
    between, engine = np.array(shown[1:]).T
    quantiles = [np.quantile(values, q) for values in (between, engine) for q in (0.5, 0.99)]
    return (
        f"{balls} balls, processor / {throttling}, {changes} changes: {len(engine)} pictures, one every "
        f"{quantiles[0]:.1f} ms (99 %: {quantiles[1]:.1f} ms); engine {quantiles[2]:.2f} ms (99 %: {quantiles[3]:.2f} ms, most: {engine.max():.2f} ms)"
    )


def alone(balls: int) -> str:
    """The engine's part in processor time, without what else the machine does."""
    if shutil.which("node") is None:
        return "engine in processor time: not measured, node is missing"
    command = ["node", "--single-threaded", ROOT / "web/node.mjs", PAGE, str(balls)]
    script = (ROOT / "web/frames.mjs").read_text(encoding="utf-8")
    return subprocess.run(command, input=script, capture_output=True, text=True, check=True).stdout.strip()


def native(fmu_path: Path) -> tuple[float, float]:
    """Seconds and relative energy error of ten minutes of Figure 6 in the FMU, in one step."""
    with nc.Fmu(fmu_path) as fmu, fmu.start(nc.figure6()) as run:
        run.slave.setDebugLogging(False, ["logEvents"])
        begun = time.perf_counter()
        run.slave.doStep(0.0, 600.0)
        return time.perf_counter() - begun, run.get("E_residual") / run.get("E_total")


def memory(page, minutes: float) -> str:
    """Bytes in use after each minute of swinging, changing, looking into clicks."""
    visit(page)
    page.execute_script(
        """cradle.setShow('force', true); cradle.setShow('energy', true); let turn = 0;
        setInterval(() => {
          turn++;
          if (turn % 5 === 0) cradle.lift(1 + turn % 4);
          if (turn % 7 === 0) cradle.inside();
          if (turn % 11 === 0) cradle.compare(turn % 2 ? 'hertz' : 'stop');
          cradle.change(Object.values(LAWS)[turn % 5]);
        }, 1000)"""
    )
    found = []
    for _ in range(max(1, round(minutes))):
        time.sleep(60)
        page.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        used = page.execute_script("return [performance.memory.usedJSHeapSize, cradle.engine.memory]")
        found.append("{:.1f} + {:.1f}".format(*(size / 1e6 for size in used)))
    return "script + engine, MB, minute by minute: " + ", ".join(found)


def main() -> int:
    """Measures all of it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--fmu", type=Path, default=ROOT / "target/fmu/NewtonsCradle.fmu")
    parser.add_argument("--minutes", type=float, default=10, help="how long memory is watched; 0: not at all")
    options = parser.parse_args()
    print(f"file: {PAGE.stat().st_size / 1e3:.0f} kB")
    page = browser()
    try:
        for throttling in (1, 4):
            first = [visit(page, throttling) for _ in range(5)]
            print(f"first picture, processor / {throttling}: {np.median(first):.0f} ms (median of 5)")
        page.execute_cdp_cmd("Emulation.setCPUThrottlingRate", {"rate": 1})
        inside, outside = (
            min((run() for _ in range(7)), key=lambda found: found[0])
            for run in (lambda: page.execute_script(FIGURE6), lambda: native(options.fmu))
        )
        print(
            f"ten minutes of Figure 6: {inside[0]:.3f} s in the page, {outside[0]:.3f} s in the FMU "
            f"({inside[0] / outside[0]:.2f} times); energy error {inside[1]:.2e} and {outside[1]:.2e}"
        )
        for balls in (5, 20):
            print(alone(balls), flush=True)
            for throttling in (1, 4):
                print(pictures(page, balls, throttling), flush=True)
        if options.minutes:
            print(memory(page, options.minutes))
    finally:
        page.quit()
    return 0


if __name__ == "__main__":
    sys.exit(main())
