"""The curves of the page, as they are drawn: what the engine computes, at a click as well, live and in recordings."""

import re
from itertools import pairwise

import newtons_cradle as nc
import numpy as np
import pytest
from scipy.spatial import KDTree

pytestmark = pytest.mark.all

PRESETS = ("figure5", "steel", "desk")
NEAR = 2.5  # px, a line's width and what lies between two samples
COARSE = 5  # px, where a sample lies within pulses at the same time: what each has done by then is not known

#: Stands still, draws the strips once, and tells what lines and bars are drawn in each colour, with how times and values
#: lie on the canvas: {force, velocity}, each with `curves` {colour: lines of points}; the labels, and the pulses.
DRAWN = """
cradle.setRunning(false);
const [stage] = cradle.stages, {strips, strips: {graph}} = stage, {prototype} = CanvasRenderingContext2D;
const found = {};
const names = ["beginPath", "lineTo", "stroke", "fillRect"];
const kept = Object.fromEntries(names.map((name) => [name, prototype[name]]));
let row = null, path = [];
const colour = (text) => text.replaceAll(" ", "");
const note = (context, style, points) => { if (row) (row.curves[colour(style)] ??= []).push(points); };
prototype.beginPath = function () { path = []; kept.beginPath.call(this); };
prototype.lineTo = function (x, y) { path.push([x, y]); kept.lineTo.call(this, x, y); };
prototype.stroke = function () { note(this, this.strokeStyle, path); kept.stroke.call(this); };
prototype.fillRect = function (x, y, w, h) {
  note(this, this.fillStyle, [[x + w / 2, y + h], [x + w / 2, y], [x + w / 2, y + h]]);
  kept.fillRect.call(this, x, y, w, h); };
const {drawAxes} = graph;
graph.drawAxes = function (kind, view) {
  drawAxes.call(this, kind, view);
  const {left, right, place, level} = view, [x, y, most] = [place(left), level(0), level.most];
  row = found[kind] = {curves: {}, left, right, x, scale: (place(right) - x) / (right - left), y,
    rise: (level(most) - y) / most, colours: Array.from(this.track.curves[kind], (_, i) => {
      kept.beginPath.call(this.context);
      this.context.fillStyle = colourOf(kind, i, this.track, view.theme);
      return colour(this.context.fillStyle); })};
};
const {drawRow} = graph;
graph.drawRow = function (...given) { drawRow.apply(this, given); row = null; };
stage.draw(cradle.theme);
Object.assign(prototype, kept);
delete graph.drawAxes;
delete graph.drawRow;
return [found, (graph.labels ?? []).map(({text, x, y}) => [text, x, y]), strips.graph.track.pulsesIn(-1, Infinity)];
"""

#: Of a recipe, at these times: positions are left out; velocities and forces.
COMPUTED = """
const [recipe, times] = arguments, run = cradle.engine.start(recipe), rows = [];
for (const time of times) {
  run.advance(time);
  const {v, F} = run.look();
  rows.push([[...v], [...F]]);
}
run.forget();
return rows;
"""


def dense(lines) -> np.ndarray:
    """Points of lines, at most half a pixel apart."""
    points = []
    for line in lines:
        line = np.array(line)
        for a, b in pairwise(line):
            count = int(np.ceil(2 * np.max(np.abs(b - a)))) + 1
            points.append(np.linspace(a, b, count + 1))
    return np.concatenate(points)


def exact_times(row, pulses, steps) -> np.ndarray:
    """Instants that show all there is in a row of curves: 4 in a pixel, 65 in each pulse, but only the ends of `steps`
    that are narrower than a pixel."""
    left, right = row["left"], row["right"]
    narrow = [step for step in steps if step[1] - step[0] < 1 / row["scale"]]
    inside = [np.linspace(pulse["onset"], pulse["release"], 65) for pulse in pulses]
    times = np.concatenate([np.linspace(left, right, 5000), *inside])
    for onset, release in narrow:
        times = times[(times <= onset) | (times >= release)]
    times = np.unique(np.concatenate([times, np.ravel(narrow)]))
    return times[(times >= max(left, 0)) & (times <= right)]


def assert_drawn(page, recipe: dict, pulses, steps=(), near: float = NEAR) -> None:
    """Each curve lies on that of the engine, and nothing of that is missing but how velocities change within a pixel in
    `steps`, (onset, release) in s."""
    found, *_ = page.js(DRAWN)
    for column, kind in enumerate(("velocity", "force")):
        row = found[kind]
        times = exact_times(row, pulses, steps if kind == "velocity" else ())
        values = [np.array(of) for of in zip(*page.js(COMPUTED, recipe, times.tolist()), strict=True)][column]
        assert np.any(values != 0)
        for i, colour in enumerate(row["colours"]):
            x, y = row["x"] + row["scale"] * (times - row["left"]), row["y"] + row["rise"] * values[:, i]
            wanted, drawn = dense([np.column_stack([x, y])]), dense(row["curves"][colour])
            drawn = drawn[(drawn[:, 0] >= x[0] - NEAR) & (drawn[:, 0] <= x[-1] + NEAR)]
            if kind == "force":
                wanted = wanted[wanted[:, 1] < row["y"] - NEAR]  # a line of all contacts lies below
            away, missing = (KDTree(a).query(b)[0] for a, b in ((wanted, drawn), (drawn, wanted)))
            if kind == "force":
                away = away[drawn[:, 1] < row["y"] - 2 * NEAR]
            assert max(away) < near and max(missing) < near, (kind, i)


#: To shortly before the next onset, in steps of a picture.
BEFORE = """cradle.setRunning(false);
for (let left; (left = source.run.nextOnset().time - source.run.time) > 3e-3;)
  source.advance(source.time + Math.min(0.01, left - 2e-3));
cradle.setRunning(true);
return source.pulses.length"""


@pytest.mark.parametrize("pace", [1, 0.01])
@pytest.mark.parametrize("preset", PRESETS)
def test_curves_live_are_those_of_the_engine(page, preset, pace):
    """Steps of velocities and spikes of forces stand where they are and are as high as they are, however few pictures
    there are; what is wide enough to be seen has its shape."""
    page.js("location.hash = arguments[0]", f"#preset={preset}&lift=2&show=force,velocity")
    page.wait(f"cradle.preset === '{preset}' && source.run.time > {2.5 if pace == 1 else 0}")
    if pace < 1:
        page.js("cradle.setPace(arguments[0])", pace)
        count = page.js(BEFORE)
        page.wait(f"source.pulses.length > {count + 3} && !source.touches")
    page.js("cradle.setRunning(false)")
    recipe, pulses = page.js("return [source.setup.recipe(), source.pulses]")
    assert_drawn(page, recipe, pulses, [(pulse["onset"], pulse["release"]) for pulse in pulses])


@pytest.fixture(scope="module", params=PRESETS)
def runs(request, fmu) -> list[nc.Result]:
    """Three seconds, once with samples within all pulses, once with a hundred a second, most of which miss them."""
    record, values = ["x", "v", "F", "E_kinetic", "E_gravity", "E_contact"], nc.preset(request.param)
    return [nc.resolved(fmu, values, stop=3.0, record=record), fmu.simulate(values, stop=3.0, step=0.01, record=record)]


@pytest.mark.parametrize(("which", "pace"), [(0, 1), (0, 0.002), (1, 1)])
def test_curves_recorded_are_those_of_the_engine(browser, runs, tmp_path, which, pace):
    runs[which].page(tmp_path / "run.html")
    browser.open_cradle(tmp_path / "run.html")
    browser.js("""cradle.clock.slowAt('no'); cradle.setPace(arguments[0]); cradle.set('force', true);
      cradle.set('velocity', true); cradle.seek(source.clicks[1].begin)""", pace)  # fmt: skip
    recipe, pulses = browser.js("return [source.setup.recipe(), source.pulses]")
    steps: list = []
    for pulse in pulses if which else ():  # of those at the same time, peaks and all that they change are known
        if steps and pulse["onset"] < steps[-1][1]:
            steps[-1][1] = max(steps[-1][1], pulse["release"])
        else:
            steps.append([pulse["onset"], pulse["release"]])
    assert_drawn(browser, recipe, pulses, steps, COARSE if which else NEAR)


#: Into the next click of what runs, or is recorded, where it stands still.
INSIDE = """cradle.setRunning(false); cradle.clock.slowAt('always');
while (source.live && !source.shownClick?.sampled) source.advance(source.time + 0.9 * source.ahead(Infinity).distance);
cradle.seek((source.live ? source.shownClick : source.openable[0]).begin + 1e-9)"""


@pytest.mark.parametrize("size", ["desktop", "phone"])
@pytest.mark.parametrize("live", [True, False], ids=["live", "recorded"])
@pytest.mark.parametrize("preset", PRESETS)
def test_labels_of_forces_stand_at_their_peaks(browser, live_path, fmu, tmp_path, preset, live, size):
    """Steel balls in touch push twice: the label stands at the higher one. None covers another."""
    path = live_path
    if not live:
        path = tmp_path / "run.html"
        values = nc.preset(preset)
        nc.resolved(fmu, values, stop=1.2, record=["x", "v", "F"]).page(path)
    browser.open_cradle(path, f"#preset={preset}&lift=2" * live, size=size)
    browser.js(INSIDE)
    browser.wait("cradle.clock.inside && source.shownClick.sampled")
    found, labels, pulses = browser.js(DRAWN)
    recipe, row = browser.js("return source.setup.recipe()"), found["force"]
    pulses = [pulse for pulse in pulses if row["left"] < pulse["onset"] < row["right"]]
    wanted = []
    for pulse in pulses:
        times = np.linspace(pulse["onset"], pulse["release"], 1001)
        force = [forces[pulse["contact"]] for _, forces in browser.js(COMPUTED, recipe, times.tolist())]
        assert max(force) == pytest.approx(pulse["peak"], rel=1e-4)
        peak = times[np.argmax(force)]
        wanted.append((row["x"] + row["scale"] * (peak - row["left"]), row["y"] + row["rise"] * pulse["peak"]))
    named = [(name, x, y) for text, x, y in labels for name in text.split(", ")]
    assert len(named) == len(pulses) > 3
    for pulse, (x, y) in zip(pulses, wanted, strict=True):
        contact = pulse["contact"] + 1
        away = [abs(at - x) for name, at, high in named if name == f"{contact}\u2013{contact + 1}" and high < y]
        assert min(away) < 3, (contact, away)
    boxes = [(x - 3.2 * len(text), x + 3.2 * len(text), y - 10, y) for text, x, y in labels]
    for k, a in enumerate(boxes):
        for b in boxes[:k]:
            assert min(a[1], b[1]) <= max(a[0], b[0]) or min(a[3], b[3]) <= max(a[2], b[2]), (labels, k)


#: Of the first label of a single pulse, where time stands at the peak: how many pixels below it have the time line's
#: colour, of all within the label's height there.
STRUCK = """
const {strips: {graph}} = cradle.stages[0], {canvas, small, labels} = graph, ratio = canvas.width / canvas.clientWidth;
const {contacts: [contact]} = labels.find(({contacts}) => contacts.length === 1);
const {click} = source, pulse = click.pulses.find((pulse) => pulse.contact === contact);
cradle.seek(click.samples.peakTime(pulse));
cradle.stages[0].draw(cradle.theme);
const {x, y} = graph.labels.find(({contacts}) => String(contacts) === String(contact));
const parts = (text) => text.match(/[0-9a-f]{2}/g).map((two) => parseInt(two, 16));
const ink = parts(cradle.theme.ink), height = Math.round(small * ratio);
const {data} = canvas.getContext("2d").getImageData(Math.round(x * ratio), Math.round((y - small) * ratio), 1, height);
const struck = Array.from({length: height}, (_, k) =>
  ink.every((part, i) => Math.abs(data[4 * k + i] - part) < 30) && data[4 * k + 3] > 200);
return [struck.filter(Boolean).length, height]"""


def test_labels_of_forces_are_not_struck_by_the_time_line(page):
    page.js("cradle.choose('figure5')")
    page.js(INSIDE)
    page.wait("cradle.clock.inside && source.shownClick.sampled")
    page.drawn()
    struck, height = page.js(STRUCK)
    assert struck == 0 < height


@pytest.mark.parametrize(("preset", "below"), [("figure5", 0), ("steel", 0.25)])
def test_curves_inside_a_click_fill_their_row(page, preset, below):
    """The scale of velocities goes below 0 as far as balls move to the left; outside, as far as above."""
    ends = """const [stage] = cradle.stages, {graph} = stage.strips, {drawAxes} = graph, found = {};
      graph.drawAxes = (kind, {level}) => { found[kind] = level.least / level.most; };
      cradle.set('velocity', true);
      stage.draw(cradle.theme);
      delete graph.drawAxes;
      return found.velocity"""
    page.js("cradle.choose(arguments[0]); cradle.lift(2); cradle.setRunning(false)", preset)
    assert page.js(ends) == -1
    page.js(INSIDE)
    page.wait("cradle.clock.inside && source.shownClick.sampled")
    assert page.js(ends) == pytest.approx(-below)


def test_curves_beside_each_other_have_one_scale(page):
    """Arrows and strips, of velocities that differ."""
    page.js("cradle.choose('textbook'); cradle.lift(2); cradle.compare('hertz'); cradle.set('velocity', true)")
    page.wait("source.run.time > 0.7")
    page.js("cradle.setRunning(false)")
    page.drawn()
    most = page.js("return cradle.sources.map(({track}) => track.most.velocity)")
    assert most[1] > 1.05 * most[0]
    rise = """const ends = [];
      for (const stage of cradle.stages) {
        const {scene, strips: {graph}} = stage, {drawAxes} = graph, {drawArrows} = scene;
        graph.drawAxes = function (kind, view) { ends.push([view.level.most, view.level(0)]);
          drawAxes.call(this, kind, view); };
        scene.drawArrows = function (places, state, most, theme) { ends.push(most);
          drawArrows.call(this, places, state, most, theme); };
        stage.draw(cradle.theme);
        delete graph.drawAxes;
        delete scene.drawArrows;
      }
      return ends"""
    arrows, strip, *others = page.js(rise)
    assert others == [arrows, strip] and arrows == pytest.approx(most[1]) and strip[0] >= most[1]


@pytest.mark.parametrize(("size", "least"), [("small", 11), ("desktop", 13), ("projector", 16)])
def test_letters_of_strips_can_be_read(page, size, least):
    """On a phone, a desk and a projector (px); names and values are set apart, and each unit stands once."""
    page.set_screen(size)
    page.js("cradle.choose('desk'); cradle.lift(1)")
    page.js("for (const kind of ['velocity', 'force', 'energy', 'momentum']) cradle.set(kind, true)")
    page.wait("source.run.time > 0.3")
    page.drawn()
    letters = "const size = (name) => parseFloat(getComputedStyle(document.querySelector(name)).fontSize);"
    small = "cradle.stages[0].strips.graph.small"
    sizes = page.js(f"{letters} return [{small}, size('.titles p'), size('.more')]")
    assert min(sizes) >= least
    titles = page.js("return [...document.querySelectorAll('.titles p')].map((row) => row.textContent)")
    for title in titles[:2]:
        assert len(re.findall(r"\bk?N\b|m?m/s", title)) == 1 and len(re.findall(r"\d: [\u2212\d]", title)) > 3, title
