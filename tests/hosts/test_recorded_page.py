"""The page of a recorded run, opened from disk in a headless Chromium; runs of CSV files that are dropped on it."""

import re

import newtons_cradle as nc
import numpy as np
import pytest
from browser import colours
from fmpy import simulate_fmu
from fmpy.util import write_csv
from newtons_cradle import page as pages
from newtons_cradle.page import save_page
from newtons_cradle.recording import from_csv
from newtons_cradle.views import from_fmu
from selenium.webdriver import ActionChains
from selenium.webdriver.common.keys import Keys
from test_live import CAPTIONS
from test_recording import REFUSED

pytestmark = pytest.mark.all

SPEED = np.sqrt(5.0) * 0.1  # m/s, of the two balls that the default parameters lift by 0.1 m
STOP = "cradle.setRunning(false); cradle.clock.slowAt('no'); cradle.seek(0)"
ONSET = 0.702493100658  # s, of the first contact


@pytest.fixture
def player(browser, recorded_path):
    """The browser with the recording of the default experiment, which stands still."""
    browser.open_cradle(recorded_path)
    browser.js(STOP)
    return browser


def state(page, t: float | None = None) -> tuple[float, list, list, list]:
    """Time, positions, velocities and forces that are shown, at time t (s) if given."""
    script = """if (arguments[0] !== null) cradle.seek(arguments[0]);
      const {now, state: {x, v, F}} = source; return [now, ...[x, v, F].map((values) => Array.from(values))]"""
    return page.js(script, t)


def test_recorded_page_moves_the_right_balls(player):
    """From rest, through the pulses of the first click in their order, to the other side; they shine as they push."""
    _, x, v, _ = state(player, 0.0)
    assert v == [0] * 5 and x == pytest.approx([-0.1, -0.1, 0, 0, 0])
    player.press("next")
    time, _, v, _ = state(player)
    assert time == pytest.approx(ONSET, abs=1e-12)
    assert np.divide(v, SPEED) == pytest.approx([1, 1, 0, 0, 0], abs=1e-6)
    begin, end = player.js("const [click] = source.clicks; return [click.begin, click.end]")
    assert 5e-5 < end - begin < 1.5e-4
    pulses = player.js("return source.clicks[0].pulses.map(({contact, release}) => [contact, release])")
    ends = dict(reversed(pulses))
    moving = [(1, 0, 1, 0, 0), (0, 1, 0, 1, 0), (0, 0, 1, 0, 1), (0, 0, 0, 1, 1)]
    for t, wanted in zip([ends[1], ends[0], ends[3], end], moving, strict=True):
        assert np.divide(state(player, t)[2], SPEED) == pytest.approx(wanted, abs=1e-4)
    assert state(player, 0.5 * (begin + ends[1]))[3][1] > 1e4
    player.drawn()
    assert np.argmax(player.js("return Array.from(cradle.stages[0].scene.glow)")) == 1


def test_recorded_page_is_drawn(player):
    """Picture, strips and slider: not blank, other after scrubbing, and playing moves on. Values of forces and energies
    are those of the time shown, or below the pointer."""
    player.js("for (const kind of ['force', 'energy']) cradle.set(kind, true); cradle.setPace(1)")
    cradle, strips = (player.find(name) for name in (".cradle", ".graph"))
    assert colours(cradle) > 500 and colours(strips) > 20
    player.js("cradle.clock.slowAt('always')")
    player.js("const [{onset, release}] = source.pulses; cradle.seek(0.5 * (onset + release))")
    shown = "Forces (kN) 1\u20132: 0 2\u20133: 15.8 3\u20134: 0 4\u20135: 0"
    assert " ".join(player.text(".titles p").split()) == shown
    assert "in contacts: 12.5" in player.text(".titles div:nth-child(2)")
    away = strips.size["width"] // 5
    ActionChains(player).move_to_element_with_offset(strips, away, -30).perform()
    player.wait("cradle.stages[0].strips.pointer !== null")
    at = "const {strips} = cradle.stages[0]; return strips.graph.timeAt(strips.pointer, strips.window)"
    _, _, _, forces = state(player, player.js(at))
    numbers = [1000 * float(number) for number in re.findall(r"\u2013\d: ([\d.]+)", player.text(".titles p"))]
    assert numbers == pytest.approx(forces, rel=5e-3) and max(forces) > 1000 and forces[2] != forces[3]
    player.js(STOP)
    before = cradle.screenshot_as_png
    whole = player.find("#whole")
    ActionChains(player).move_to_element_with_offset(whole, whole.size["width"] // 4, 0).click().perform()
    assert state(player)[0] == pytest.approx(7.5, abs=0.15)
    assert cradle.screenshot_as_png != before
    ActionChains(player).move_to_element_with_offset(strips, -100, -20).click().perform()
    assert state(player)[0] < 7.3
    state(player, 0.0)
    player.press("play")
    player.wait("source.now > 0.3")
    state(player, 9.9)
    player.wait("!cradle.clock.running && source.now === source.end")
    player.press("play")
    player.wait("source.now > 0 && source.now < 5")
    player.js("cradle.set('sound', true); cradle.seek(0.6)")
    player.wait("cradle.sound.played > 0")


#: Seconds of the viewer's that playing up to a time takes, in frames of 20 ms.
PLAYED = """let seconds = 0;
for (; source.now < arguments[0]; seconds += 0.02) cradle.clock.frame(0.02, cradle.sources);
return seconds;"""


def test_recorded_page_slows_at_the_first_click_only(browser, recorded_path):
    browser.open_cradle(recorded_path)
    browser.js("cradle.setRunning(false); source.seek(0); cradle.clock.reset()")
    assert 12 < browser.js(PLAYED, 1.5) < 40
    assert browser.js(PLAYED, 6.5) == pytest.approx(5.0, abs=0.1)
    state(browser, 0)
    assert browser.js(PLAYED, 1.5) == pytest.approx(1.5, abs=0.1)


#: Of the stages of a click, when they begin, after the first touch.
BEGINS = ("0 µs", "22.2 µs", "22.7 µs", "44.9 µs", "45.5 µs", "67.7 µs", "68.2 µs")


def test_recorded_page_click_is_gone_through_by_buttons(player):
    """The third one; what is said is said of live clicks, too."""
    state(player, 3.4)
    assert player.text(".sentence") == "Click 2 of 7."
    player.press("inside")
    player.wait("cradle.clock.inside")
    player.js("cradle.setRunning(false); cradle.seek(source.shownClick.begin - 1e-7)")
    assert player.text(".sentence") == "Balls 2 and 3 meet in 100 ns."
    assert "Slowed" in player.text("#pace") and player.text("#factor") == player.text("#pace")
    assert not player.find("#speed").is_enabled()
    for sentence, begin in zip(CAPTIONS["textbook", 2][1:8], BEGINS, strict=True):
        player.press("next")
        assert player.text(".sentence") == sentence
        assert player.text(".detail").startswith(f"{begin} after the first touch")
    player.js("const {pulses: [first]} = source.shownClick; cradle.seek(0.5 * (first.onset + first.release))")
    assert player.text(".detail").endswith("strongest: 2\u20133 with 15.8 kN")
    player.js("cradle.seek(source.shownClick.pulses.at(-1).onset)")
    player.press("next")
    assert player.text(".sentence") == "The click took 90.4 µs: 6 pushes."
    assert player.text(".detail").startswith(CAPTIONS["textbook", 2][-1])
    player.press("inside")
    assert player.js("return cradle.clock.rate") == 1
    player.drawn()
    assert player.find("#speed").is_enabled()
    assert player.text("#inside") == "Look inside a click"
    # Behind the last one there is none to wait for.
    player.js("cradle.clock.slowAt('next'); cradle.seek(source.end)")
    assert player.js("return cradle.clock.slow") == "no"


def test_recorded_page_says_where_a_click_has_no_inside(browser, fmu_path, tmp_path):
    """Rigid impacts that take no time."""
    path = tmp_path / "rigid.html"
    save_page(path, from_fmu(fmu_path, {"contact.model": "rigid", "contact.deadBand": 0.0}, stop=3.0))
    browser.open_cradle(path)
    assert not browser.seen("#inside")
    why = "Rigid impacts take no time: there is nothing to look into."
    assert browser.text(".sentence").endswith(why) and browser.text("#status") == ""
    browser.js(STOP)
    assert browser.js(PLAYED, 2.9) == pytest.approx(2.9, abs=0.1)


RIGID = {"contact.model": "rigid"}
PLAYABLE = {  # start values, and whether overlaps are known
    "bdf": ({"solver.method": "bdf"}, True),
    "adams": ({"solver.method": "adams"}, True),
    "rk4": ({"solver.method": "rk4", "solver.fixedStep": 2e-6}, True),
    "apart": (RIGID, False),
    "touching": (RIGID | {"contact.deadBand": 0.0}, False),
}


@pytest.mark.parametrize("name", PLAYABLE)
def test_recorded_page_plays_what_the_engine_would_refuse(browser, fmu, tmp_path, name):
    """Methods that the page has not; rigid balls that overlap between two samples, as they are drawn."""
    values, known = PLAYABLE[name]
    path = tmp_path / "run.html"
    parts = ["x", "v", "F", "F_peak", "E_kinetic", "E_gravity", "E_contact"]
    fmu.simulate(values, stop=1.5, step=0.01, record=parts).page(path)
    browser.open_cradle(path)
    browser.js(f"{STOP}; for (let t = 0; t < 1; t += 0.001) source.seek(t); source.seek(0)")
    assert browser.js(PLAYED, 1.4) == pytest.approx(1.4, abs=0.1)
    assert browser.js("return source.state.overlap.some((depth) => depth !== 0)") is known
    browser.js("cradle.setRunning(false)")
    browser.press("goOn")
    assert browser.js("return source.live && cradle.clock.running")
    browser.assert_quiet()


#: The points of ball 1's curve, and the texts beside it.
CURVE = """cradle.set("velocity", true);
const [stage] = cradle.stages, {graph} = stage.strips, {prototype} = CanvasRenderingContext2D, curves = [], texts = [];
const {points} = graph, {fillText} = prototype;
prototype.fillText = (text) => texts.push(text);
graph.points = (...given) => curves[curves.push(points.apply(graph, given)) - 1];
stage.draw(cradle.theme);
prototype.fillText = fillText;
delete graph.points;
return [curves[0], texts]"""


def assert_jumps(page) -> None:
    """Ball 1's velocity has two values at one time where it is struck, and no steep slopes; its axes have units."""
    curve, texts = page.js(CURVE)
    times, values = np.transpose(curve)
    after = np.searchsorted(times, times + 0.01) - 1  # the last point that is at the same time, or this one
    assert np.max(np.abs(values[after] - values)) > 20
    slopes = np.abs(np.diff(values))[np.diff(times) >= 0.01]
    assert slopes.max() < 15
    assert {"0 mm/s", "2 s"} <= set(texts) and any(re.fullmatch(r"\d+ mm/s", text) for text in texts)


def test_recorded_page_velocities_jump_where_balls_are_struck(player, live_path):
    """In a run with samples within each pulse; in a live one, between two pictures; and in what is kept of that."""
    assert_jumps(player)
    player.open_cradle(live_path, "#preset=textbook")
    player.js("cradle.lift(1)")
    player.wait("source.run.time > 3")
    assert_jumps(player)
    again = "cradle.setRunning(false); const run = source.engine.start(source.setup.recipe()); run.advance(1.234);"
    shown = player.js(f"{again} return Array.from(run.look().x)")
    assert len(assert_tables(player)) > 5
    assert state(player, 1.234)[1] == pytest.approx(shown, abs=1e-4)
    assert_jumps(player)


def test_recorded_page_keys_go_from_click_to_click(player):
    body = player.find("body")
    body.send_keys("]")
    assert state(player)[0] == pytest.approx(ONSET, abs=1e-12)
    body.send_keys("]")
    assert state(player)[0] == pytest.approx(2.1075697, abs=1e-6)
    body.send_keys("[")
    body.send_keys(Keys.ARROW_RIGHT)
    assert state(player)[0] == pytest.approx(ONSET + 0.14, abs=1e-9)
    order = []
    for _ in range(20):
        player.switch_to.active_element.send_keys(Keys.TAB)
        focus = player.switch_to.active_element
        order.append(focus.get_attribute("id") or focus.get_attribute("data-opens"))
    wanted = ["previous", "whole", "next", "speed", "play", "inside", "details", "show", "keep"]
    assert [name for name in order if name in wanted][: len(wanted)] == wanted
    body.send_keys("r")
    assert player.text("#paneltitle") == "Details"


def test_recorded_page_shows_parameters_with_units(player, fmu):
    player.js("cradle.panels.toggle('details')")
    rows = player.js("return source.parameters")
    shown = {name: (value, unit) for name, value, unit, _ in rows}
    assert shown["contact.stiffness"] == ("1e+10", "N/m")
    assert shown["contact.model"] == ("powerLaw", "")
    assert shown["x_start[i]"] == ("-0.1, -0.1, 0, 0, 0", "m")
    names = {v.name.partition("[")[0] for v in fmu.description.modelVariables if v.causality == "parameter"}
    assert {name.partition("[")[0] for name in shown} == names
    panel = player.text("#panelbody")
    assert all(f"{name}\n{value} {unit}".strip() in panel for name, (value, unit) in shown.items())
    assert "Strings of 1.962 m, balls with a radius of 31.3 mm." in panel
    assert re.search(r"Balls are drawn (\d+|\d\.\d) times as large as strings and swings.", panel)


def test_recorded_page_reduces_motion_where_wanted(browser, recorded_path):
    """It stands still until asked; a click opens at its beginning and stays there."""
    browser.open_cradle(recorded_path, still=True)
    assert browser.js("return [cradle.clock.running, source.now]") == [False, 0]
    browser.press("inside")
    assert browser.text(".sentence") == "Ball 2 touches ball 3."
    assert browser.js("return [cradle.clock.running, cradle.stages[0].near]") == [False, 1]
    browser.press("next")
    assert browser.text(".sentence") == "Balls 2 and 3 part. Nothing touches."


def test_recorded_page_of_thirteen_balls_for_a_minute_is_small(browser, fmu_path, cradle, tmp_path):
    path = tmp_path / "thirteen.html"
    views = from_fmu(cradle(balls=13, binaries=fmu_path).path, nc.preset("figure3"), stop=60.0)
    assert save_page(path, views) < 5e6
    browser.open_cradle(path)
    _, x, v, F = state(browser, 0.5)
    assert len(x) == 13 and len(F) == 12
    assert np.divide(v, np.sqrt(9.81)) == pytest.approx([1] * 3 + [0] * 8 + [-1] * 2, abs=1e-4)
    assert colours(browser.find(".cradle")) > 500


def drop(page, name: str, content: str) -> str:
    """Drops a file on the page; what the page says."""
    script = """const [name, content, done] = arguments, dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([content], name));
      window.dispatchEvent(new DragEvent("drop", {dataTransfer, cancelable: true}));
      setTimeout(done, 300)"""
    page.execute_async_script(script, name, content)
    return page.text("#status")


def test_recorded_page_takes_results_of_fmpy(player, browser, fmu_path, tmp_path):
    """Impacts come from F_peak; its samples are too far apart to look inside a click."""
    result = simulate_fmu(fmu_path, stop_time=3.0, output_interval=0.01)
    write_csv(tmp_path / "result.csv", result)
    save_page(tmp_path / "result.html", from_csv(tmp_path / "result.csv"))
    content = (tmp_path / "result.csv").read_text()
    for made in (
        lambda: drop(browser, "result.csv", content),
        lambda: browser.visit(tmp_path / "result.html"),
    ):
        made()
        browser.wait("!source.live && source.end === 3")
        browser.js("cradle.setRunning(false)")
        _, x, *_ = state(browser, result["time"][123])
        assert x == pytest.approx([result[f"x[{i}]"][123] for i in range(1, 6)], abs=1e-7)
        assert_jumps(browser)
        assert browser.js("return source.clicks.map(({end}) => end)") == pytest.approx([0.71, 2.11])
        assert browser.text(".sentence") == "Click 1 of 2. The samples do not resolve the clicks."
        assert not browser.seen("#inside") and not browser.seen("#goOn")


def test_recorded_page_refuses_bad_files_in_the_words_of_the_program(player):
    """Nothing is changed. A file of one ball, which a command would ask about, is shown."""
    for content, complaint, *own in sorted(REFUSED, key=lambda row: "one ball" in row[1]):
        said = drop(player, "bad.csv", content).replace("…", "...")
        if "one ball" in complaint:
            assert player.js("return source.balls") == 1
            continue
        assert said.startswith("bad.csv cannot be shown: ")
        assert (own or complaint.split("missing: "))[-1] in said
        assert player.js("return source.balls") == 5


@pytest.mark.parametrize("at", [1.3, ONSET + 2e-5])
def test_recorded_page_goes_on_live(player, fmu, live_path, at):
    """From where it stands, between clicks or within one: what follows is the native run."""
    state(player, at)
    player.press("goOn")
    assert player.js("return source.live && cradle.clock.running")
    assert player.js("return source.setup.recipe().start['x_start[1]']") != -0.1
    player.assert_native(fmu)


def test_recorded_page_keeps_a_recording(player):
    """Its samples are shown again as they were; its link goes on live from the release."""
    player.js("cradle.panels.toggle('keep')")
    buttons = [button.text for button in player.find_all("#panelbody button")]
    tables = ["All contacts as a table (CSV)", "The run as a table (CSV)"]
    assert buttons == ["Copy a link to this", "Picture (PNG)", *tables]
    link, shown = player.js("return linkTo(cradle)"), state(player, 1.234)
    impulses = assert_tables(player)
    assert impulses == pytest.approx(SPEED, rel=1e-3)  # N.s, of 1 kg that takes over all the speed
    assert state(player, 1.234) == shown
    player.load(link)
    assert player.js("return source.live")
    assert player.js("return source.setup.values.x_start") == [-0.1, -0.1, 0, 0, 0]


def assert_tables(page) -> np.ndarray:
    """The pulses in CSV are those of what runs, and the run in CSV is shown in its place; the pulses' impulses."""
    pulses = page.js("return source.pulses.map(({onset, release, peak}) => [onset, release, peak])")
    kept = """const done = arguments[0], [source] = cradle.sources;
      Promise.all([pulsesTable(source).text(), runTable(source).text()]).then(done)"""
    table, run = page.execute_async_script(kept)
    assert table.startswith("contact,onset,release,peak,impulse")
    rows = np.genfromtxt(table.splitlines(), delimiter=",", names=True)
    assert [list(row) for row in rows[["onset", "release", "peak"]].tolist()] == pulses
    drop(page, "run.csv", run)
    assert page.js("return [source.name, source.setup]") == ["run.csv", None]
    return rows["impulse"]


def test_recorded_page_plays_without_an_engine(browser, recorded_path, monkeypatch, tmp_path):
    """What needs one is not offered."""
    monkeypatch.setattr(pages, "ENGINE", tmp_path / "none")
    path = tmp_path / "run.html"
    with nc.Fmu() as fmu:
        result = nc.resolved(fmu, stop=3.0, record=["x", "v", "F", "E_kinetic", "E_gravity", "E_contact"])
    assert result.page(path) < 1e6
    browser.open_cradle(path)
    browser.wait("source.now > 0.5")
    buttons = "[...document.querySelectorAll('nav button')].filter((button) => button.checkVisibility())"
    shown = browser.js(f"return {buttons}.map(({{id, dataset}}) => dataset.opens ?? id)")
    assert shown == ["previous", "next", "play", "inside", "details", "show", "keep", "help"]
    with pytest.raises(pages.PageError, match="the engine for browsers is missing"):
        save_page(path)


def test_recorded_page_of_hours_is_gone_through(browser, tmp_path):
    """Four hours of clicks: from one to the next, and to the last; what is drawn is what there is around now."""
    time = np.arange(0, 4 * 3600, 0.1)
    x = np.column_stack([np.cos(2 * time), np.zeros_like(time)])
    v = np.column_stack([-2 * np.sin(2 * time), np.zeros_like(time)])
    pulses = np.zeros(20_000, nc.PULSE)
    pulses["onset"] = np.linspace(1, time[-1] - 1, len(pulses))
    pulses["release"], pulses["contact"], pulses["peak"] = pulses["onset"] + 1e-4, 1, 1
    path = tmp_path / "hours.html"
    save_page(path, nc.recording.Recording("hours", time, x, v, 0 * x[:, :1], pulses))
    browser.open_cradle(path)
    browser.js("cradle.set('force', true); cradle.set('velocity', true); cradle.seek(source.end)")
    browser.press("previous")
    assert state(browser)[0] == pytest.approx(time[-1] - 1)
    assert browser.text(".sentence").startswith("Click 20000 of 20000.")
    assert browser.js("return source.pulsesIn(100, 107).length") < 20
