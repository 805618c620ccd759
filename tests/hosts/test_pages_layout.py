"""All pages in windows of a desktop and of a phone, light and dark: nothing overprints, and axe-core finds nothing
serious."""

from pathlib import Path

import pytest
from browser import SIZES, assert_quiet, serious, set_screen, visit
from newtons_cradle import look

pytestmark = pytest.mark.all

#: Each text of the page as [text, left, top, right, bottom, whether it may scroll away sideways], CSS pixels.
TEXTS = """
const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node; (node = walk.nextNode());) {
  const parent = node.parentElement, text = node.textContent.trim();
  if (!text || parent.closest("script, style, .spoken, dialog:not([open])")) continue;
  if (!parent.checkVisibility({visibilityProperty: true})) continue;
  if (getComputedStyle(parent).clipPath !== "none") continue;
  const range = document.createRange(), scrolls = Boolean(parent.closest("[role=region], .wide"));
  range.selectNodeContents(node);
  for (const {left, top, right, bottom} of range.getClientRects()) {
    if (right - left > 1) found.push([text.slice(0, 60), left, top + scrollY, right, bottom + scrollY, scrolls]);
  }
}
return found;"""


@pytest.fixture(scope="module")
def pages(animation, paper, fmu) -> dict[str, Path]:
    """The three kinds of pages."""
    return {
        "animation": animation,
        "report": paper[0] / "report.html",
        "fmu": Path(fmu.folder) / "documentation/index.html",
    }


def overprints(browser) -> list[tuple[str, str]]:
    """Pairs of texts that lie on each other, by more than what letters leave free in their line."""
    texts = sorted(browser.execute_script(TEXTS), key=lambda text: text[2])
    found = []
    for i, (text, left, top, right, bottom, _) in enumerate(texts):
        for other, *box, _ in texts[i + 1 :]:
            if box[1] >= bottom:
                break
            wide = min(right, box[2]) - max(left, box[0])
            high = min(bottom, box[3]) - max(top, box[1])
            if wide > 1.5 and high > 0.35 * min(bottom - top, box[3] - box[1]):
                found.append((text, other))
    return found


def assert_fits(browser) -> None:
    """No text on another one or beyond the sides of the window, and nothing that makes the page scroll sideways."""
    assert overprints(browser) == []
    width = browser.execute_script("return innerWidth")
    texts = browser.execute_script(TEXTS)
    assert len(texts) > 10
    assert [t for t in texts if not t[5] and not (t[1] >= 0 and t[3] <= width + 0.5)] == []
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("page", ["animation", "report", "fmu"])
def test_nothing_overprints(browser, pages, page, size, dark):
    set_screen(browser, size, dark=dark)
    visit(browser, pages[page])
    assert_fits(browser)
    if page == "animation":
        assert_the_player_fits(browser)
        browser.execute_script("cradle.open(); cradle.play(false); cradle.jump(1); cradle.draw()")
        assert_fits(browser)
        assert_the_player_fits(browser)
        browser.execute_script("document.getElementById('about').click()")
        assert browser.execute_script("return details.scrollWidth <= details.clientWidth")
    assert_quiet(browser)


def assert_the_player_fits(browser) -> None:
    """All of it is in the window at once: picture, buttons, legends of energies and forces."""
    inside = browser.execute_script(
        """const ids = "stage clock caption play inside about energies energy forces force whole";
        return Object.fromEntries(ids.split(" ").map((id) => {
          const {left, top, right, bottom} = document.getElementById(id).getBoundingClientRect();
          const within = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
          return [id, within && right > left && bottom - top >= 14];
        }));"""
    )
    assert inside == dict.fromkeys(inside, True)
    assert browser.execute_script("return document.getElementById('stage').clientHeight") > 150
    assert "kinetic" in browser.execute_script("return document.getElementById('energies').textContent")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("page", ["animation", "report", "fmu"])
def test_axe_finds_nothing_serious(browser, axe, pages, page, dark):
    set_screen(browser, dark=dark)
    visit(browser, pages[page])
    browser.execute_script(axe)
    states = [""]
    if page == "animation":
        states += ["cradle.open(); cradle.play(false)", "document.getElementById('about').click()"]
    for action in states:
        browser.execute_script(action)
        for size in SIZES:
            set_screen(browser, size, dark=dark)
            assert serious(browser) == []


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_colours_are_told_from_what_they_are_on(browser, pages, dark):
    """Texts, also those drawn on canvases, which axe-core does not see: 4.5 to 1; curves: 3 to 1, energies at least
    from each other."""
    set_screen(browser, dark=dark)
    visit(browser, pages["animation"])
    texts, curves = ["ink", "soft", "accent", "good", "bad"], ["edge", *(f"series-{i}" for i in range(1, 7))]
    names = "return Object.fromEntries(arguments[0].map((name) => [name, colour(`--${name}`)]))"
    shown = browser.execute_script(names, [*texts, *curves, "paper", "card", "on-accent"])
    for name in texts + curves:
        least = min(contrast(shown[name], shown[ground]) for ground in ("paper", "card"))
        assert least >= (4.5 if name in texts else 3), name
    assert contrast(shown["on-accent"], shown["accent"]) >= 4.5


def contrast(one: str, other: str) -> float:
    """Contrast of two colours #rrggbb after WCAG 2, 1 to 21."""

    def luminance(colour):
        channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_all_pages_have_one_look(pages):
    for path in pages.values():
        assert look.STYLE in path.read_text(encoding="utf-8")
    assert len(look.SERIES) == len(set(look.SERIES)) == 6
    assert look.series(4) == look.SERIES[:4]
    many = look.series(12)
    assert len(set(many)) == 12 and (many[0], many[-1]) == (look.SERIES[0], look.SERIES[1])
