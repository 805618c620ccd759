"""The live page in three dimensions: what WebGL draws, seen from all sides, and hands on it."""

import numpy as np
import pytest
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.all

# A picture of the balls alone: where it covers what is behind it, row by row, and how large it is.
COVER = """
const {scene} = cradle.stages[0], {painter} = scene, {add} = painter, done = arguments[0];
painter.add = (...thing) => { if (thing[0] === "BALL") add.apply(painter, thing); };
requestAnimationFrame(() => requestAnimationFrame(() => {
  const [{width, height}] = scene.layers, copy = new OffscreenCanvas(width, height).getContext("2d");
  copy.drawImage(scene.layers[0], 0, 0);
  painter.add = add;
  const alpha = copy.getImageData(0, 0, width, height).data.filter((_, k) => k % 4 === 3);
  const {source} = cradle.stages[0], places = Array.from(source.state.x, (x, i) => scene.place(i, x));
  done([Array.from(alpha), width, height, places.map(({x, y, unit}, i) => [x, y, unit * scene.sizes[i]])]);
}));"""


@pytest.fixture
def space(page):
    """The page in 3D, without gentle motion."""
    page.set_screen(dark=True, still=True)
    page.js("cradle.still = true; cradle.set('space', true)")
    return page


def look(page, view: str) -> None:
    page.js("cradle.eye.look(arguments[0])", view)
    page.wait(f"cradle.eye.view === '{view}' && cradle.eye.azimuth === cradle.eye.wanted.azimuth")


def test_view_3d_draws_balls_where_hands_look_for_them(space):
    """Balls of different sizes, one lifted: each pixel is covered where the places of the balls say so."""
    space.js("cradle.change({'ball.massRatio': [1, 1, 4, 1, 0.5]})")
    space.js("cradle.setRunning(false); cradle.take('test', 4, 0.2); cradle.move('test', 4, 0.2)")
    for view in ("front", "side", "top"):
        look(space, view)
        cover, width, height, places = space.execute_async_script(COVER)
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        # How deep in a ball; negative outside all.
        depth = np.max([r - np.hypot(x - at, y - high) for at, high, r in places], axis=0)
        covered = np.array(cover).reshape(height, width) / 255
        assert np.all(covered[depth > 3] > 0.99) and np.all(covered[depth < -3] < 0.01), view
        assert 0.2 < covered[(depth > -1) & (depth < 1)].mean() < 0.8, view


def test_view_3d_ball_follows_the_pointer(space):
    """It is lifted, those to its left come along."""
    for view, ball in (("front", 1), ("side", 0), ("top", 1)):
        space.js("cradle.stopAll()")
        look(space, view)
        x, y = space.place(ball)
        space.drag(ball, -90, release=False)
        lifted = space.js("return source.state.x[arguments[0]]", ball)
        assert lifted < -0.02, view
        if view != "side":
            assert space.place(ball) == pytest.approx((x - 90, y), abs=14), view
        space.let_go()
        wanted = [lifted] * (ball + 1) + [0] * (4 - ball)
        assert space.js("return source.setup.values.x_start") == pytest.approx(wanted, abs=1e-4), view


def test_view_3d_turns(space):
    """By the button, the key, a pointer or two fingers beside the balls, and the right button anywhere; never below
    the floor."""
    angles = "return [cradle.eye.azimuth, cradle.eye.height]"
    button = space.find("#view")
    assert button.text == "See it from the side"
    button.click()
    space.wait("cradle.eye.view === 'side' && cradle.controls.view.textContent === 'See it from above'")
    space.find("body").send_keys("v")
    space.wait("cradle.eye.view === 'top' && cradle.controls.view.textContent === 'See it from the front'")
    look(space, "front")
    azimuth, height = space.js(angles)
    x, y = space.place(0)
    space.gesture([(80, y), (130, y + 20)])
    turned = space.js(angles)
    assert turned[0] < azimuth - 0.1 and turned[1] > height + 0.05
    space.wait("cradle.eye.view === 'free' && cradle.controls.view.textContent === 'See it from the front'")
    azimuth, _ = turned
    space.gesture([(60, 300), (160, 300)], [(60, 450), (160, 450)], kind="touch")
    assert space.js(angles)[0] == pytest.approx(azimuth - 0.6, abs=0.01)
    x, y = space.place(0)
    space.gesture([(x, y), (x, 100)], button=2)
    assert space.js("return [source.holds.size, source.state.x[0]]") == [0, 0]
    space.gesture([(80, 600), (80, 100)], kind="touch")
    assert space.js("return cradle.stages[0].scene.lens.eye[1] > cradle.stages[0].scene.floor")
    assert space.js(angles)[1] < 0.1


#: How bright the middle of each ball is, 0 to 255, of what is drawn on the layer behind.
BRIGHT = """const {scene, source} = cradle.stages[0], [{width, height}] = scene.layers, done = arguments[0];
const copy = new OffscreenCanvas(width, height).getContext("2d", {willReadFrequently: true});
const ratio = width / scene.canvas.clientWidth;
copy.drawImage(scene.layers[0], 0, 0);
done(Array.from(source.state.x, (x, i) => {
  const {x: left, y: top, unit} = scene.place(i, x), r = 0.5 * ratio * unit * scene.sizes[i];
  const {data} = copy.getImageData(ratio * left - r, ratio * top - r, 2 * r, 2 * r);
  return data.reduce((sum, part, k) => sum + (k % 4 < 3 ? part : 0), 0) / (0.75 * data.length); }))"""


@pytest.mark.parametrize("dimensions", [2, 3])
def test_view_3d_draws_unlike_balls_as_they_are(space, dimensions):
    """Their sizes are those of their radii; one of lead is darker than those of steel."""
    space.js("cradle.set('space', arguments[0]); cradle.choose('tapered'); cradle.setRunning(false)", dimensions == 3)
    space.drawn()
    sizes, radii = space.js("return [cradle.stages[0].scene.sizes, source.setup.get('ball.radiusRatio')]")
    assert sizes == pytest.approx(np.clip(radii, 0.35, None)) and len(set(sizes)) == 5
    space.js("cradle.choose('unlike'); cradle.setRunning(false)")
    space.drawn()
    bright = space.execute_async_script(BRIGHT)
    assert bright[2] < 0.8 * min(bright[1], bright[3]) and max(bright) > 80
    # What counts is the modulus itself: the same ratios of another common one.
    tints = "cradle.change({'ball.youngModulus': arguments[0]}); return source.setup.drawing.moduli"
    assert space.js(tints, 1.05e11) == pytest.approx([0.5, 0.5, 0.0432581, 0.5, 0.5])


@pytest.mark.parametrize("size", ["desktop", "phone"])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_view_3d_keeps_a_held_ball_in_the_picture(space, size, dimensions):
    """With those that it takes along and, in 3D, its shadow, however far it is pulled to either side."""
    space.set_screen(size, still=True)
    space.js("cradle.set('space', arguments[0])", dimensions == 3)
    for ball, to in ((1, -1), (4, -1), (0, 1)):
        space.js("cradle.stopAll()")
        space.drawn()
        x, y = space.place(ball)
        width = space.js("return cradle.stages[0].canvas.clientWidth")
        edge = round(0.5 * width * (1 + 0.97 * to))
        space.gesture([(x + k * (edge - x) // 8, y) for k in range(9)], hold=1.0, release=False)
        assert abs(space.js("return source.state.x[arguments[0]] / source.drawing.length", ball)) > 0.2
        places = space.js(
            """const {scene, canvas: {clientWidth: wide, clientHeight: high}} = cradle.stages[0];
            return Array.from(source.state.x, (x, i) => {
              const {at, x: left, y: top, unit} = scene.place(i, x), r = scene.sizes[i] * unit;
              const shadow = scene.lens.place([at[0], scene.floor, 0]);
              return [Math.min(left - r, shadow.x - r), wide - Math.max(left, shadow.x) - r, top - r,
                high - Math.max(top + r, shadow.y)]; })"""
        )
        assert np.min(places) > -3, (ball, places)
        space.let_go()


def test_view_3d_is_offered_where_it_is_fast_and_remembered(page, live_path):
    """Elsewhere the key and the panel offer it."""
    button = page.find("#space")
    assert not button.is_displayed()
    page.js("window.name = 'keeps'")
    page.load(live_path.as_uri() + "#preset=textbook")
    page.js("localStorage.setItem('cradle', JSON.stringify({picture: 12}))")
    for text, shown in (("3D", False), ("Flat", True), ("Flat", True)):
        page.load(live_path.as_uri() + "#preset=textbook")
        button = page.find("#space")
        assert (button.text, page.js("return cradle.space")) == (text, shown)
        if not shown:
            button.click()
            assert button.text == "Flat"
    # What a picture takes is measured where that is not known.
    page.js("localStorage.clear()")
    page.load(live_path.as_uri() + "#preset=textbook")
    page.wait("cradle.spaceTime > 0")
    assert page.js("return JSON.parse(localStorage.cradle).picture === cradle.spaceTime")
    assert page.js("return [cradle.space, document.querySelectorAll('.space').length]") == [False, 0]
    page.js("localStorage.clear(); window.name = ''")


def test_view_3d_draws_once_what_stands_still(space):
    space.wait("cradle.stages[0].scene.painter.drawn")
    drawn = """const {gl} = cradle.stages[0].scene.painter, done = arguments[0];
    let count = 0, frames = 0;
    gl.clear = (...given) => { count++; Object.getPrototypeOf(gl).clear.apply(gl, given); };
    const frame = () => {
      if (++frames < 12) return void requestAnimationFrame(frame);
      delete gl.clear;
      done(count);
    };
    requestAnimationFrame(frame)"""
    assert space.execute_async_script(drawn) <= 2
    space.js("cradle.lift(1)")
    assert space.execute_async_script(drawn) >= 8


def test_view_3d_without_webgl_is_flat(space):
    """Where it is lost, until it is asked for again; and where there is none."""
    space.js("cradle.compare('hertz')")
    space.js("cradle.stages[1].scene.painter.gl.getExtension('WEBGL_lose_context').loseContext()")
    space.wait("!cradle.space && cradle.controls.status.textContent.includes('WebGL')")
    flat = "return [cradle.space, cradle.controls.view.hidden, document.querySelectorAll('.space').length]"
    assert space.js(flat) == [False, True, 0]
    space.js("cradle.set('space', true)")
    assert space.js(flat) == [True, False, 2]
    space.js("""cradle.compare('stop'); cradle.set('space', false); cradle.tell('');
      const {getContext} = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more); }""")  # fmt: skip
    space.find("body").send_keys("s")
    choice = space.find("[data-key$=space]")
    choice.send_keys(Keys.SPACE)
    assert "WebGL" in space.find("#status").text
    assert not space.find("[data-key$=space]").is_selected()
    assert space.js(flat) == [False, True, 0]
    space.drag(0, -60)
    assert space.js("return source.setup.values.x_start[0]") < -0.02
    # Neither is it offered later, by what is kept of this visit.
    space.js(
        "let kept = '{}'; Object.assign(Storage.prototype, {getItem: () => kept, setItem(_, text) { kept = text; }})"
    )
    for _ in range(2):
        space.js("cradle.offerSpace()")
        assert not space.js("return cradle.offersSpace")
        space.wait("cradle.spaceTime === Infinity")
        assert not space.js("return cradle.offersSpace")
