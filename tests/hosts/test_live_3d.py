"""The live page in three dimensions: what WebGL draws, seen from all sides, and hands on it."""

import numpy as np
import pytest
from browser import serious, set_screen
from live_page import GRID, Pointer, drag, js, place, same_run, wait
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.all

VIEWS = ("front", "side", "top")
# A picture of the balls alone: where it covers what is behind it, row by row, and how large it is.
COVER = """
const {scene} = cradle.stages[0], {painter} = scene, {add} = painter, done = arguments[0];
painter.add = (...thing) => { if (thing[0] === "BALL" && !thing[4]) add.apply(painter, thing); };
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
    js(page, "cradle.still = true; cradle.setOther('space', true)")
    return page


def look(page, view: str) -> None:
    js(page, "cradle.eye.look(arguments[0])", view)
    wait(page, f"cradle.controls.view.textContent === 'View: {view}'")


@pytest.mark.parametrize("view", VIEWS)
def test_balls_are_drawn_where_hands_look_for_them(space, view):
    """Balls of different sizes, one lifted: each pixel is covered where the places of the balls say so."""
    look(space, view)
    js(space, "cradle.change({'ball.massRatio': [1, 1, 4, 1, 0.5]})")
    js(space, "cradle.setRunning(false); cradle.take('test', 4, 0.2); cradle.move('test', 4, 0.2)")
    cover, width, height, places = space.execute_async_script(COVER)
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    # How deep in a ball; negative outside all.
    depth = np.max([r - np.hypot(x - at, y - high) for at, high, r in places], axis=0)
    covered = np.array(cover).reshape(height, width) / 255
    assert np.all(covered[depth > 3] > 0.99) and np.all(covered[depth < -3] < 0.01)
    assert 0.2 < covered[(depth > -1) & (depth < 1)].mean() < 0.8


@pytest.mark.parametrize("view, ball", [("front", 1), ("side", 0), ("top", 1)])
def test_a_ball_goes_with_the_pointer(space, fmu, view, ball):
    """It is lifted, those to its left come along; then it is the run of the engine, to the last bit."""
    look(space, view)
    x, y = place(space, ball)
    drag(space, ball, -90, release=False)
    lifted = js(space, "return source.state.x[arguments[0]]", ball)
    assert lifted < -0.02
    if view != "side":
        assert place(space, ball) == pytest.approx((x - 90, y), abs=14)
    Pointer(space, "mouse").pointer_up().perform()
    recipe = js(space, "return source.setup.recipe()")
    for i in range(1, 6):
        assert recipe["start"][f"x_start[{i}]"] == pytest.approx(lifted if i <= ball + 1 else 0, abs=1e-4)
    wait(space, "source.run.time > 0.5")
    rows = js(
        space,
        """cradle.setRunning(false);
        const run = source.engine.start(arguments[0]), pulses = [];
        return [arguments[1].map((time) => {
          run.advance(time);
          pulses.push(...run.takePulses());
          return Array.from(run.look().numbers);
        }), pulses]""",
        recipe,
        GRID[:320],
    )
    assert same_run(fmu, recipe, *rows, GRID[:320])


def test_the_view_turns(space):
    """By the button, the key, a pointer beside the balls, and the right button anywhere; never below the floor."""
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
    Pointer(space, "mouse").move_to_location(80, y).pointer_down().move_to_location(
        130, y + 20
    ).pointer_up().perform()
    turned = js(space, angles)
    assert turned[0] < azimuth - 0.1 and turned[1] > height + 0.05
    wait(space, "cradle.controls.view.textContent === 'View: turned'")
    x, y = place(space, 0)
    hand = Pointer(space, "mouse").move_to_location(x, y).pointer_down(2)
    hand.move_to_location(x, 100).pointer_up(2).perform()
    assert js(space, "return source.holds.size") == 0
    assert js(space, "return source.state.x[0]") == 0
    down = Pointer(space, "touch").move_to_location(80, 600).pointer_down()
    down.move_to_location(80, 100).pointer_up().perform()
    assert js(space, "return cradle.stages[0].scene.lens.eye[1] > cradle.stages[0].scene.frame.floor")
    assert js(space, angles)[1] < 0.1


def test_two_fingers_turn_the_view_as_one_does(space):
    azimuth = js(space, "return cradle.eye.azimuth")
    builder = ActionBuilder(space, mouse=PointerInput("touch", "first"), duration=20)
    for k, finger in enumerate([builder.pointer_action.source, builder.add_pointer_input("touch", "second")]):
        finger.create_pointer_move(duration=0, x=60, y=300 + 150 * k)
        finger.create_pointer_down(button=0)
        finger.create_pointer_move(duration=30, x=160, y=300 + 150 * k)
        finger.create_pointer_up(button=0)
    builder.perform()
    assert js(space, "return cradle.eye.azimuth") == pytest.approx(azimuth - 0.6, abs=0.01)
    assert js(space, "return source.holds.size") == 0


def test_what_stands_still_is_drawn_once(space):
    wait(space, "cradle.stages[0].scene.painter.drawn")
    drawn = """const {painter} = cradle.stages[0].scene, {paint} = painter, done = arguments[0];
    let count = 0, frames = 0;
    painter.paint = (...given) => { count++; paint.apply(painter, given); };
    const frame = () => {
      if (++frames < 12) return void requestAnimationFrame(frame);
      painter.paint = paint;
      done(count);
    };
    requestAnimationFrame(frame)"""
    assert space.execute_async_script(drawn) <= 2
    js(space, "cradle.lift(1)")
    assert space.execute_async_script(drawn) >= 8


def test_a_link_and_a_picture_keep_it(space):
    link = js(space, "return linkTo(cradle)")
    assert link.endswith("&view=3d")
    js(space, "cradle.setOther('space', false); cradle.open(new URL(arguments[0]).hash)", link)
    assert js(space, "return cradle.space")
    wait(space, "cradle.stages[0].scene.painter.drawn")
    colours = space.execute_async_script(
        """const done = arguments[0], {scene, source} = cradle.stages[0];
        URL.createObjectURL = (blob) => {
          createImageBitmap(blob).then((picture) => {
            const copy = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
            copy.drawImage(picture, 0, 0);
            const {x, y, unit} = scene.place(2, source.state.x[2]);
            const {data} = copy.getImageData(2 * (x - unit / 2), 2 * y, 2 * unit, unit);
            done(new Set(new Uint32Array(data.buffer)).size);
          });
          return "#kept"; };
        savePicture(cradle)"""
    )
    assert colours > 300


def test_without_webgl_it_stays_flat(page):
    js(page, """const {getContext} = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more); }""")  # fmt: skip
    page.find_element(By.TAG_NAME, "body").send_keys("s")
    choice = page.find_element(By.CSS_SELECTOR, "[data-key$=space]")
    choice.send_keys(Keys.SPACE)
    assert "WebGL" in page.find_element(By.ID, "status").text
    assert not page.find_element(By.CSS_SELECTOR, "[data-key$=space]").is_selected()
    assert js(
        page, "return [cradle.space, cradle.controls.view.hidden, document.querySelector('.space')]"
    ) == [
        False,
        True,
        None,
    ]
    drag(page, 0, -60)
    assert js(page, "return source.setup.values.x_start[0]") < -0.02


def test_when_webgl_is_lost_it_becomes_flat(space):
    js(space, "cradle.compare('hertz')")
    js(space, "cradle.stages[1].scene.painter.gl.getExtension('WEBGL_lose_context').loseContext()")
    wait(space, "!cradle.space")
    assert "WebGL" in space.find_element(By.ID, "status").text
    assert js(space, "return document.querySelectorAll('.space').length") == 0
    js(space, "cradle.setOther('space', true)")
    assert js(space, "return document.querySelectorAll('.space').length") == 2


def test_axe_finds_nothing_serious(space, axe):
    space.execute_script(axe)
    for light in (False, True):
        js(space, "cradle.setTheme(arguments[0])", light)
        assert serious(space) == [], light
