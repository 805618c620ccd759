"""The page in which the engine runs live, in a headless Chromium: keyboard, links, tables, languages;
for classes: what will fly out is asked before it is seen, and the lesson is presented step by step."""

import json
import os
import re
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import pytest
from conftest import ROOT
from newtons_cradle.page import save_site
from selenium.webdriver import Keys

pytestmark = pytest.mark.all


def test_live_page_keyboard_does_everything(page):
    body = page.find("body")
    body.send_keys("2")
    assert page.js("return source.setup.values.x_start") == [-0.1, -0.1, 0, 0, 0]
    body.send_keys("0")
    slider = page.find_all(".sliders input")[1]
    page.execute_script("arguments[0].focus()", slider)
    slider.send_keys(Keys.ARROW_LEFT * 4)
    assert slider.get_attribute("aria-valuetext") == "40.0 mm to the left, held"
    slider.send_keys(Keys.ENTER)
    assert page.js("return source.setup.values.x_start") == pytest.approx([-0.04, -0.04, 0, 0, 0])
    panels = {"c": "Change", "s": "Show", "b": "Compare", "k": "Save and share", "h": "Keys"}
    for key, title in panels.items():
        body.send_keys(key)
        assert page.find("#paneltitle").text == title
        page.keys(Keys.ESCAPE)
        assert not page.seen("#panel")
    body.send_keys("i")
    assert page.js("return cradle.clock.slow") == "next"
    shown = "return [cradle.clock.running, cradle.panels.kind]"
    page.press("again")
    page.keys(Keys.SPACE)  # pauses, whatever was clicked before
    assert page.js(shown) == [False, None]
    page.js("cradle.set('keys', false)")
    page.keys("s", Keys.SPACE)
    assert page.js(shown) == [False, None]
    page.js("cradle.set('keys', true)")
    page.keys("s")
    assert page.js(shown) == [False, "show"]


@pytest.mark.parametrize("still", [False, True])
def test_live_page_drawn_hand_shows_how_to_begin(page, live_path, still):
    """It pulls the first ball aside and lets it go, unless motion is to be reduced; who touches the page ends it."""
    page.visit(live_path, still=still)
    hint = "Pull a ball aside and let it go."
    page.wait("cradle.guide.seconds > 1.8")
    x, shown = page.js("return [source.state.x[0], Number(getComputedStyle(cradle.controls.hand).opacity)]")
    assert (x == 0 and shown == 0) if still else (x < -0.005 and shown > 0)
    shown = "cradle.guide.phase === 'has shown' && source.pulses.length > 0"
    page.wait("cradle.guide.seconds > 4" if still else shown)
    moved = page.js("return [source.setup.values.x_start[0], cradle.stages[0].sentence.textContent]")
    assert moved == [0 if still else pytest.approx(-0.12), hint]
    page.find("h1").click()
    said = hint if still else ""
    page.wait(f"cradle.guide.phase === null && cradle.stages[0].sentence.textContent === '{said}'")


def test_live_page_defaults_are_those_of_the_fmu(page, fmu):
    """Those of the engine, and the sizes for drawings that a page without one has."""
    sizes = json.loads(page.find("#sizes").get_attribute("textContent"))
    defaults = page.execute_script("return DEFAULTS")
    assert len(defaults) > 20 and len(sizes) == 2
    for name, value in [*defaults.items(), *sizes.items()]:
        assert fmu.built_with(name) == fmu.number(name, value), name


def test_links_carry_the_set_up(page, live_path):
    """That of both cradles; the button that copies it says so."""
    page.js("cradle.choose('desk'); cradle.change({gravity: 1.62}); cradle.compare('hertz')")
    page.js("cradle.change({'contact.model': 'powerLaw', 'contact.exponent': 3})")
    page.wait("cradle.sources.every(({pending}) => !pending)")
    page.js("cradle.lift(2); cradle.set('space', true)")
    shown = "return [cradle.space, cradle.side, cradle.sources.map(({setup}) => setup.recipe())]"
    wanted, link = page.js(shown), page.js("return linkTo(cradle)")
    assert link.startswith(live_path.as_uri() + "#")
    page.js("cradle.panels.toggle('keep'); document.querySelector('#panelbody button').click()")
    told = "/(The link is in the clipboard|Here is the link:).* It works on this computer/"
    page.wait(f"{told}.test(cradle.controls.status.textContent)")
    page.load(link)
    assert page.js(shown) == wanted


#: What anybody may write behind #, and what is said of it.
ODD = {
    "lang=constructor": "Ignored in the address: lang=constructor.",
    "show=force,toString&view=2d": "Ignored in the address: view=2d, show=force,toString.",
    "slow=__proto__": "Ignored in the address: slow=__proto__.",
    "preset=constructor": "preset = constructor is refused; allowed: textbook, ",
    "%": "% is refused; allowed: text in which % is written as %25",
    "__proto__=1": 'no variable has the name "__proto__"',
    "constructor=1": 'no variable has the name "constructor"',
}


@pytest.mark.parametrize("link", ODD)
def test_links_ignore_what_they_do_not_know_with_a_word(page, live_path, link):
    """While the page is open, and when it opens."""
    for act in (
        lambda: page.js("location.hash = arguments[0]", link),
        lambda: page.load(f"{live_path.as_uri()}#{link}"),
    ):
        act()
        page.wait("cradle.controls.status.textContent")
        assert ODD[link] in page.js("return cradle.controls.status.textContent")
        page.js("cradle.lift(1)")
        page.wait("source.run.time > 0.1")


def test_links_have_round_numbers(page):
    """Of a release by hand, at rest and thrown: what the link starts is what runs."""
    page.js("cradle.setRunning(false)")
    page.drag(1, -87)
    for speed in (0, 0.123456789123):
        page.js("cradle.take('test', 1, -0.1731); cradle.move('test', 1, -0.17310000000000003)")
        page.js("source.release('test', arguments[0])", speed)
        link, recipe = page.js("return [source.setup.toLink('textbook'), source.setup.recipe()]")
        assert max(len(number) for number in re.findall(r"[-\d.e]+", link)) < 16, link
        assert page.js("return Setup.fromLink(arguments[0]).setup.recipe()", link) == recipe


#: Ways in which something brings another script into a page, or another style.
BAD = {
    "text": """document.body.append(Object.assign(document.createElement("script"), {textContent: "bad = true"}))""",
    "data": """document.body.append(Object.assign(document.createElement("script"),
      {src: "data:text/javascript,bad = true"}))""",
    "module": """import("data:text/javascript,bad = true").catch(() => {})""",
    "event": """document.body.insertAdjacentHTML("beforeend", "<img src=x onerror='bad = true'>")""",
    "link": """document.body.append(Object.assign(document.createElement("a"), {href: "javascript:bad = true"}));
      document.body.lastChild.click()""",
    "eval": """setTimeout("bad = true")""",
    "style": """document.body.insertAdjacentHTML("beforeend", "<style>h1 { display: none }</style>")""",
}


@pytest.mark.parametrize("way", BAD)
def test_security_policy_counts_only_the_pages_own_scripts_and_styles(page, way):
    refused = """const done = arguments[0]; window.bad = false;
      addEventListener("securitypolicyviolation", ({effectiveDirective}) => done(effectiveDirective), {once: true});"""
    kind = "style-src" if way == "style" else "script-src"
    assert page.execute_async_script(refused + BAD[way]).startswith(kind)
    page.drawn()
    assert page.js("return bad") is False and page.seen("h1")
    assert any("Content Security Policy" in entry["message"] for entry in page.get_log("browser"))


def test_links_of_the_lesson(page):
    """Each opens the step that the page's own lesson has, and is understood."""
    links = re.findall(r"\(cradle\.html#([^)]+)", (ROOT / "docs/lesson.md").read_text(encoding="utf-8"))
    assert set(page.execute_script("return LESSON")) <= set(links)
    for link in links:
        page.js("location.hash = arguments[0]", link)
        lifted = int(re.search(r"lift=(\d)|present", link)[1] or 2)
        page.wait(f"source.setup.values.x_start.filter((x) => x < 0).length === {lifted}")
        assert page.js("return cradle.lesson.answer(1)") == ("lift" not in link or "ask" in link), link
        page.wait("source.run.time > 0.05")
        shown = page.js("return [cradle.controls.status.textContent, cradle.stages.length]")
        assert shown == ["", 2 if "beside" in link else 1], link
        page.js("cradle.stopAll()")
    for beside in ("nonsense", "stop"):  # the values of a second cradle are shown, whatever its name
        page.js(f"cradle.compare('stop'); location.hash = '#beside={beside}&right.gravity=1.62'")
        page.wait("cradle.stages[1]?.source.setup.get('gravity') === 1.62")
        assert page.js("return cradle.besideChoice") == "usual"


def test_links_of_the_documents_are_understood(page, live_path):
    """All parts of addresses in docs/page.md, which names every cradle to compare with."""
    text = (ROOT / "docs/page.md").read_text(encoding="utf-8").split("## Addresses")[1]
    others = re.findall(r"`(\w+)`", re.search(r"compares with (.+?);", text)[1])
    assert set(others) == set(TEXTS["en"]["besides"]) - {"stop"}
    parts = [*re.findall(r"`(?:cradle.html#)?([\w.]+=[^`]+|ask)`", text), *(f"beside={name}" for name in others)]
    assert len(parts) > 20
    for part in parts:
        page.load(f"{live_path.as_uri()}#{part}")
        assert page.js("return cradle.controls.status.textContent") in ("", TEXTS["en"]["turn"]), part


def test_live_page_from_a_web_server(browser, live_path, tmp_path):
    """Its site can be installed, and is there when the server no longer is."""
    assert save_site(tmp_path) < 2e6
    newer = "return 'newer' in document.documentElement.dataset"
    handler = partial(SimpleHTTPRequestHandler, directory=tmp_path)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/"
        browser.get(address)
        browser.execute_async_script("navigator.serviceWorker.ready.then(arguments[0])")
        manifest = browser.execute_cdp_cmd("Page.getAppManifest", {})
        assert json.loads(manifest["data"])["icons"] and manifest["errors"] == []
        assert browser.execute_cdp_cmd("Page.getInstallabilityErrors", {})["installabilityErrors"] == []
        page = tmp_path / "index.html"
        page.write_bytes(page.read_bytes().replace(b"<html", b"<html data-newer", 1))
        os.utime(page, (2e9, 2e9))  # later by more than the second that a server tells
        browser.get(address)
        assert browser.execute_script(newer)
        server.shutdown()
    browser.load(address + "#preset=desk&lift=1")
    browser.wait("source.run.time > 0.1")
    assert browser.js(f"{newer} && cradle.preset") == "desk"


PICTURE = """const done = arguments[0], {scene, source, canvas} = cradle.stages[0];
URL.createObjectURL = (blob) => {
  createImageBitmap(blob).then((picture) => {
    const copy = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
    copy.drawImage(picture, 0, 0);
    const {x, y, unit} = scene.place(2, source.state.x[2]);
    const {data} = copy.getImageData(2 * (x - unit / 2), 2 * y, 2 * unit, unit);
    done([blob.type, picture.width / canvas.clientWidth, new Set(new Uint32Array(data.buffer)).size]);
  });
  return "#kept"; };
savePicture(cradle)"""


def test_live_page_keeps_a_picture(page):
    """Twice as large as the stage, flat and in 3D, with the balls."""
    for space in (False, True):
        page.js("cradle.set('space', arguments[0])", space)
        page.wait("cradle.stages[0].scene.painter?.drawn ?? true")
        kind, large, colours = page.execute_async_script(PICTURE)
        assert (kind, large) == ("image/png", 2) and colours > 300, space


TEXTS = {path.stem: json.loads(path.read_bytes()) for path in (ROOT / "web/page/texts").glob("*.json")}


def places(text) -> object:
    """The shape of a table of texts: its names, and the places in each text."""
    if isinstance(text, dict):
        return {name: places(part) for name, part in text.items()}
    if isinstance(text, list):
        return [places(part) for part in text]
    return set(re.findall(r"{\w+}", text))


@pytest.mark.parametrize("language", sorted(set(TEXTS) - {"en"}))
def test_languages_have_all_texts_and_they_fit(page, language):
    """Chosen under Show; on a phone, with each panel open, side by side, inside a click."""
    shape, other = places(TEXTS["en"]), places(TEXTS[language])
    for forms in ("pressed", "over", "overRigid"):  # "one" may name no number
        shape[forms], other[forms] = shape[forms]["other"], other[forms]["other"]
    assert other == shape
    page.set_screen("phone")
    page.js("cradle.panels.toggle('show')")
    page.find(f"input[data-key$=' {language}']").click()
    assert page.find("#paneltitle").text == TEXTS[language]["show"]
    assert page.execute_script("return document.documentElement.lang") == language
    page.js("cradle.panels.toggle('show'); cradle.compare('heavy')")
    page.boxes()
    for _ in page.each_panel():
        page.boxes()
    page.js("cradle.compare('stop'); cradle.lift(2); cradle.inside()")
    page.wait("cradle.clock.inside")
    page.boxes()
    assert f"lang={language}" in page.js("return linkTo(cradle)")


SENTENCE = "cradle.stages[0].sentence.textContent"


def guess(page, count: int) -> None:
    page.find_all("#guesses button")[count - 1].click()


GUESSES = [
    ("textbook", 2, 2, "You said 2, and 2 balls flew out."),
    ("textbook", 3, 1, "You said 1, but 3 balls flew out."),
    ("textbook", 1, 5, "You said 5, but one ball flew out."),
    ("steel", 2, 2, "You said 2, but 3 balls flew out."),
    ("rigid", 4, 4, "You said 4, and 4 balls flew out."),
]


def test_lesson_asks_what_will_fly_out(page):
    """Time stands still until it has; then it is told what did."""
    page.js("cradle.set('ask', true)")
    for preset, lifted, guessed, said in GUESSES:
        page.js(f"cradle.choose('{preset}'); cradle.lift({lifted})")
        page.wait(f"{SENTENCE} === 'How many balls will fly out on the other side?'")
        assert len(page.find_all("#guesses button")) == 5
        assert page.js("return [cradle.clock.running, source.run.time]") == [False, 0]
        guess(page, guessed)
        assert not page.seen("#guesses")
        page.wait(f"{SENTENCE}.startsWith('You said')")
        shown, detail = page.js(f"return [{SENTENCE}, cradle.stages[0].detail.textContent]")
        assert shown == said and detail.startswith("Compared with the incoming speed: ball")


@pytest.mark.parametrize(("start", "ball", "guess"), [("lift=2", 3, 2), ("x_start=0,0,0,0,0.1", 1, 2)])
def test_lesson_accepts_a_hanging_ball(page, start, ball, guess):
    """It and those beyond it are expected to fly out; one that is lifted can still be taken."""
    page.js("location.hash = arguments[0]", f"#preset=textbook&ask&{start}")
    page.wait("cradle.lesson.phase === 'asks'")
    lifted = page.js("return source.setup.values.x_start.findIndex((x) => x !== 0)")
    page.drag(lifted, 30 if lifted else -30)
    assert page.js("return cradle.lesson.phase") == "asks"
    page.gesture([page.place(ball)])
    assert page.js("return [cradle.lesson.phase, cradle.lesson.guess]") == ["waits", guess]
    assert page.js("return [cradle.clock.running, source.holds.size]") == [True, 0]


def test_keys_that_are_listed_do_something(page, live_path, recorded_path):
    """Of a live run, of a recording, and of one whose clicks have no inside."""
    shown = "cradle.panels.toggle('help'); return [...document.querySelectorAll('.keys dt')].map((k) => k.innerText)"
    always = {"Space", "D", "V", "C", "S", "L", "P, N", "K"}
    inside = {"I", "E", ", ."}
    live = {"Tab", "\u2190 \u2192", "Enter", "1 to 9", "A", "0", "B"}
    assert set(page.js(shown)) == always | inside | live
    page.open_cradle(recorded_path)
    recorded = always | {"[ ]", "\u2190 \u2192", "R"}
    assert set(page.js(shown)) == recorded | inside
    page.js("source.openable = []; cradle.panels.toggle('help'); cradle.clock.slowAt('no')")
    assert set(page.js(shown)) == recorded
    page.keys("0", "a", "2", "b", "i")
    assert page.js("return [source.live, cradle.panels.kind, cradle.clock.slow]") == [False, "help", "no"]


def test_lesson_asks_after_a_hand_and_goes_on_without_an_answer(page):
    page.js("cradle.set('ask', true)")
    page.drag(1, -80)
    shown = page.js("return [cradle.lesson.phase, cradle.clock.running, source.holds.size]")
    assert shown == ["asks", False, 0]
    lifted = page.js("return source.setup.values.x_start[0]")
    assert page.js("return source.state.x[0]") == pytest.approx(lifted) and lifted < -0.01
    page.keys("2")  # a guess, not two balls to be lifted
    assert page.js("return [cradle.lesson.phase, source.setup.values.x_start[0]]") == ["waits", lifted]
    page.js("cradle.lift(1)")
    page.keys(Keys.SPACE)
    page.wait("cradle.lesson.phase === null && source.pulses.length > 0")
    assert not page.seen("#guesses")
    page.js("cradle.lift(2)")
    assert page.seen("#guesses")
    page.js("cradle.stopAll()")
    assert not page.seen("#guesses")
    assert "&ask" in page.js("return linkTo(cradle)")


def emphasised(page) -> list[bool]:
    """Whether answers, and the next step, are seen in the colour of what is to be done."""
    colours = """const colour = (item) => getComputedStyle(item).backgroundColor;
      const [guess] = document.querySelectorAll("#guesses button"), {nextStep, play} = cradle.controls;
      return [guess, nextStep].map((item) => item.checkVisibility() && colour(item) !== colour(play))"""
    return page.js(colours)


def test_lesson_is_presented_step_by_step(page, live_path):
    """The head of the page does not give the answer away; each step has its link, and Escape leaves."""
    page.visit(live_path, "#present")
    titles = []
    for step in range(1, 7):
        assert page.execute_script("return location.hash") == f"#present={step}"
        asked = step in (1, 4, 6)
        assert (page.find("h1").text == f"{step}/6 What will fly out?") is asked
        assert page.js("return cradle.stages[0].scene.glow.some(Boolean)") is False or not asked
        assert page.seen("#guesses") is asked
        if asked:
            assert emphasised(page) == [True, False]
            assert page.find("#about").text == TEXTS["en"]["lessons"][step - 1]["asked"]
            assert not page.seen(".strips")  # nothing has moved yet
            page.set_screen("low")
            assert page.seen("#about")
            page.set_screen()
            guess(page, 2)
            assert emphasised(page) == [False, step < 6]
            page.js("cradle.clock.slowAt('no')")
            page.wait("cradle.lesson.phase === 'knows'")
        if step == 2:  # the unit of the scale, however small the value
            page.wait("source.run.time > 0.4")
            curves = page.js("cradle.setRunning(false); return cradle.stages[0].strips.titles.textContent")
            assert re.search(r"Momentum \(kg m/s\)\s+[\d.]+ ", curves), curves
        titles.append(page.find("h1").text)
        assert not page.seen("#openers")
        if step < 6:
            page.press("nextStep")
    assert not page.seen("#nextStep")
    page.press("endLesson")
    assert len(set(titles)) == 6 and titles[1] == "2/6 Why not one, twice as fast?"
    assert page.seen("#openers")
    page.visit(live_path, "#present=5")
    assert page.find("h1").text == "5/6 See the difference grow"
    page.keys(Keys.ESCAPE)
    assert page.find("h1").text == "Newton's cradle"
    assert page.execute_script("return location.hash").startswith("#preset=textbook")
