"""The live page in three dimensions: what WebGL draws, seen from all sides, and hands on it."""

import numpy as np
import pytest
from browser import set_screen
from live_page import drag, gesture, js, let_go, place, wait
from selenium.webdriver.common.by import By
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
    set_screen(page, dark=True, still=True)
    js(page, "cradle.still = true; cradle.set('space', true)")
    return page


def look(page, view: str) -> None:
    js(page, "cradle.eye.look(arguments[0])", view)
    wait(page, f"cradle.controls.view.textContent === 'View: {view}'")


def test_balls_are_drawn_where_hands_look_for_them(space):
    """Balls of different sizes, one lifted: each pixel is covered where the places of the balls say so."""
    js(space, "cradle.change({'ball.massRatio': [1, 1, 4, 1, 0.5]})")
    js(space, "cradle.setRunning(false); cradle.take('test', 4, 0.2); cradle.move('test', 4, 0.2)")
    for view in ("front", "side", "top"):
        look(space, view)
        cover, width, height, places = space.execute_async_script(COVER)
        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        # How deep in a ball; negative outside all.
        depth = np.max([r - np.hypot(x - at, y - high) for at, high, r in places], axis=0)
        covered = np.array(cover).reshape(height, width) / 255
        assert np.all(covered[depth > 3] > 0.99) and np.all(covered[depth < -3] < 0.01), view
        assert 0.2 < covered[(depth > -1) & (depth < 1)].mean() < 0.8, view


def test_a_ball_goes_with_the_pointer(space):
    """It is lifted, those to its left come along."""
    for view, ball in (("front", 1), ("side", 0), ("top", 1)):
        js(space, "cradle.stopAll()")
        look(space, view)
        x, y = place(space, ball)
        drag(space, ball, -90, release=False)
        lifted = js(space, "return source.state.x[arguments[0]]", ball)
        assert lifted < -0.02, view
        if view != "side":
            assert place(space, ball) == pytest.approx((x - 90, y), abs=14), view
        let_go(space)
        wanted = [lifted] * (ball + 1) + [0] * (4 - ball)
        assert js(space, "return source.setup.values.x_start") == pytest.approx(wanted, abs=1e-4), view


def test_the_view_turns(space):
    """By the button, the key, a pointer or two fingers beside the balls, and the right button anywhere; never below
    the floor."""
    angles = "return [cradle.eye.azimuth, cradle.eye.height]"
    button = space.find_element(By.ID, "view")
    assert button.text == "View: front"
    button.click()
    wait(space, "cradle.controls.view.textContent === 'View: side'")
    space.find_element(By.TAG_NAME, "body").send_keys("v")
    wait(space, "cradle.controls.view.textContent === 'View: top'")
    look(space, "front")
    azimuth, height = js(space, angles)
    x, y = place(space, 0)
    gesture(space, [(80, y), (130, y + 20)])
    turned = js(space, angles)
    assert turned[0] < azimuth - 0.1 and turned[1] > height + 0.05
    wait(space, "cradle.controls.view.textContent === 'View: turned'")
    azimuth, _ = turned
    gesture(space, [(60, 300), (160, 300)], [(60, 450), (160, 450)], kind="touch")
    assert js(space, angles)[0] == pytest.approx(azimuth - 0.6, abs=0.01)
    x, y = place(space, 0)
    gesture(space, [(x, y), (x, 100)], button=2)
    assert js(space, "return [source.holds.size, source.state.x[0]]") == [0, 0]
    gesture(space, [(80, 600), (80, 100)], kind="touch")
    assert js(space, "return cradle.stages[0].scene.lens.eye[1] > cradle.stages[0].scene.floor")
    assert js(space, angles)[1] < 0.1


def test_what_stands_still_is_drawn_once(space):
    wait(space, "cradle.stages[0].scene.painter.drawn")
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
    js(space, "cradle.lift(1)")
    assert space.execute_async_script(drawn) >= 8


def test_without_webgl_it_is_flat(space):
    """Where it is lost, until it is asked for again; and where there is none."""
    js(space, "cradle.compare('hertz')")
    js(space, "cradle.stages[1].scene.painter.gl.getExtension('WEBGL_lose_context').loseContext()")
    wait(space, "!cradle.space && cradle.controls.status.textContent.includes('WebGL')")
    flat = "return [cradle.space, cradle.controls.view.hidden, document.querySelectorAll('.space').length]"
    assert js(space, flat) == [False, True, 0]
    js(space, "cradle.set('space', true)")
    assert js(space, flat) == [True, False, 2]
    js(space, """cradle.compare('stop'); cradle.set('space', false); cradle.tell('');
      const {getContext} = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more); }""")  # fmt: skip
    space.find_element(By.TAG_NAME, "body").send_keys("s")
    choice = space.find_element(By.CSS_SELECTOR, "[data-key$=space]")
    choice.send_keys(Keys.SPACE)
    assert "WebGL" in space.find_element(By.ID, "status").text
    assert not space.find_element(By.CSS_SELECTOR, "[data-key$=space]").is_selected()
    assert js(space, flat) == [False, True, 0]
    drag(space, 0, -60)
    assert js(space, "return source.setup.values.x_start[0]") < -0.02
