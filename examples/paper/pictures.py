"""The pictures of the README, of the lesson and of the FMU's documentation, from real runs.

    .venv/bin/python examples/paper/pictures.py

writes docs/*.png, docs/cradle.jpg, docs/lesson/*.jpg, packaging/assets/run.svg and scene.svg. The pictures of the
cradle, the lesson and the report need Chromium and its driver. Run the other examples first, because it takes their
pictures: `python3 cradle.py paper`, examples/study/study.py, examples/mechatronics/couple.py,
examples/events/metronome.py, examples/fit/contacts.py and examples/losses/laws.py.
"""

import base64
import io
import re
import sys
import tempfile
import time
from pathlib import Path

import matplotlib.pyplot as plt
from newtons_cradle.page import save_page
from newtons_cradle.views import from_fmu
from PIL import Image
from plots import Column, Plot, Strip, Trace, family, save_picture
from support import ROOT, command_line, ended, nc, opened, parsed, shorter

sys.path.append(str(ROOT / "tests/hosts"))

from browser import Browser

# For each step of the lesson: a name, and the moment, in seconds after the release or as a fraction of the click.
LESSON = (("two", 0.52, None), ("energy", 3.4, None), ("inside", None, 0.115), ("steel", None, 0.36))
LESSON += (("beside", 10.05, None), ("faster", None, 1.04))
OPEN = 'cradle.setTheme(false); location.hash = modules["#engine/setup.js"].LESSON[arguments[0]]'
INSIDE = "cradle.sources[0].shownClick?.sampled && cradle.clock.rate < 1e-3 && cradle.stages[0].near > 0.99"
SEEK = "const click = cradle.sources[0].shownClick; cradle.seek(click.begin + arguments[0] * click.length)"


def main() -> None:
    """Makes all pictures."""
    options = parsed(command_line(__doc__.splitlines()[0], "paper"))
    docs, assets = ROOT / "docs", ROOT / "packaging/assets"
    with opened(options) as fmus:
        svg(default_run(fmus[5]), assets / "run.svg")
        photographs(fmus, options.out / "report.html", docs, assets / "scene.svg")
    others = ("study/study", "mechatronics/coupling", "mechatronics/machine", "events/metronome", "fit/contacts")
    others += ("losses/laws",)
    pictures = [options.out / "figure3.png", options.out / "figure5.png"]
    for path in [*pictures, *(ROOT / f"out/{name}.png" for name in others)]:
        small(Image.open(path), docs / path.name)


def default_run(fmu: nc.Fmu) -> Plot:
    """Ten seconds of positions beside the first click's forces, with the default parameters."""
    macro = fmu.simulate(stop=10.0, step=0.05, record=["x"])
    with fmu.start() as run:
        onset, micro = run.zoom(span=1e-4, step=1e-6, record=["F", "E_contact"], before=5e-6)
    stored = Trace(micro["time"] - onset, micro["E_contact"].sum(axis=1), nc.look.COLOURS["contact"], "area")
    pulses = [*family(micro, "F", origin=onset), Strip("stored", [stored], "J")]
    columns = [
        Column(family(macro, "x", limits=(-0.12, 0.12)), {"": (0.0, 10.0)}, "ten seconds"),
        Column(pulses, {"": (-5e-6, 1e-4)}, "the first click", "time after the first onset"),
    ]
    return Plot("run", "", "", columns, height=0.8)


def svg(plot: Plot, path: Path) -> None:
    """Writes a plot as SVG to be put into a page: with text as text, three digits, and the colours of the page."""
    plt.rcParams["svg.fonttype"] = "none"
    plt.rcParams["svg.hashsalt"] = "cradle"
    plt.rcParams["path.simplify_threshold"] = 0.3
    save_picture(plot, path, metadata={"Date": None, "Creator": None})
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"\d+\.\d{3,}", lambda number: f"{float(number[0]):.1f}", text)
    names = {value: name for name, value in nc.look.COLOURS.items() if value != "#ffffff"}
    text = re.sub(r"#[0-9a-f]{6}", lambda shade: f"var(--{names[shade[0]]})", text.replace("#ffffff", "none"))
    text = text.replace("font-family: 'DejaVu Sans'", "font-family: inherit")
    path.write_text(re.sub(r"\n\s*", "\n", text), encoding="utf-8")
    print(f"  wrote {shorter(path)}")


def photographs(fmus, report: Path, docs: Path, scene: Path) -> None:
    """Photographs the cradle in a click, for `docs`, and without its surroundings as `scene`; the lesson; the report's
    top."""
    with Browser("hide-scrollbars") as browser, tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "cradle.html"
        save_page(page, from_fmu(fmus[5].path))
        browser.get(page.as_uri())
        time.sleep(3)
        browser.execute_script(
            "cradle.setRunning(false); cradle.clock.slowAt('always');"
            "const [click] = cradle.sources[0].clicks; cradle.seek(click.begin + 0.37 * click.length)"
        )
        time.sleep(3)
        photograph(browser, docs / "cradle.jpg")
        save_scene(browser, scene)
        lesson(browser, page, docs / "lesson")
        browser.get(report.as_uri())
        browser.execute_script("document.getElementById('figure5').scrollIntoView({behavior: 'instant'})")
        photograph(browser, docs / "report.png")


def save_scene(browser, path: Path, width: int = 960) -> None:
    """Writes the balls alone as SVG to be put into a page, which then needs no other file."""
    picture = Image.open(io.BytesIO(browser.find(".cradle").screenshot_as_png)).convert("RGB")
    picture.thumbnail((width, width))
    (width, height), file = picture.size, io.BytesIO()
    picture.save(file, "JPEG", optimize=True, quality=72)
    data = base64.b64encode(file.getvalue()).decode()
    named = 'role="img" aria-label="Five balls inside a click: two pairs press each other"'
    image = f'<image width="{width}" height="{height}" href="data:image/jpeg;base64,{data}"/>'
    path.write_text(f'<svg viewBox="0 0 {width} {height}" {named}>{image}</svg>\n')
    print(f"  wrote {shorter(path)}, {path.stat().st_size / 1000:.0f} kB")


def lesson(browser, page: Path, folder: Path) -> None:
    """Opens each step of the lesson, and waits for its moment."""
    for step, (name, seconds, part) in enumerate(LESSON):
        browser.visit(page, "#preset=textbook")
        # Without a GPU, each pixel takes time: the resolution is low until shortly before the moment.
        set_screen(browser, 0.25)
        browser.execute_script(OPEN, step)
        if part is None:
            swung = "cradle.clock.base === 1 && cradle.sources[0].run?.time > {}"
            browser.wait(swung.format(seconds - 0.4))
            set_screen(browser, 1.5)
            browser.wait(swung.format(seconds), every=0.005)
        else:
            browser.wait(INSIDE)
            set_screen(browser, 1.5)
            browser.execute_script(SEEK, part)
        photograph(browser, folder / f"{name}.jpg", wait=0.0 if part is None else 1.0, width=1440)
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def set_screen(browser, scale: float) -> None:
    """Sets the screen to the size of the lesson's pictures, with `scale` pixels for a CSS pixel."""
    screen = {"width": 960, "height": 600, "deviceScaleFactor": scale, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)


def photograph(browser, path: Path, wait: float = 1.0, width: int = 1000) -> None:
    time.sleep(wait)
    small(Image.open(io.BytesIO(browser.get_screenshot_as_png())), path, width)


def small(picture: Image.Image, path: Path, width: int = 1000) -> None:
    """Writes a picture at most `width` pixels wide, as a PNG with at most 256 colours, or a JPEG."""
    picture = picture.convert("RGB")
    picture.thumbnail((width, picture.height), Image.Resampling.LANCZOS, reducing_gap=None)
    if path.suffix == ".png":
        picture = picture.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    picture.save(path, optimize=True, quality=88)
    print(f"  wrote {shorter(path)}, {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    ended(main)
