"""The page in which the engine runs live: dragged, changed, looked into, in a headless Chromium."""

import json

import newtons_cradle as nc
import numpy as np
import pytest
from browser import FOLLOW, GRID, colours, same_run

pytestmark = pytest.mark.all

SET_UPS = {
    "default": {},
    "figure5": nc.figure5(),
    "touching": nc.figure5(0.0),
    "steel": nc.steel(2) | {"contact.model": "hertz"},
    "rigid": {"contact.model": "rigid", "contact.restitution": 0.9},
    "lossy": {"contact.exponent": 2, "contact.damping": 2e3, "pendulum.drag": 0.02, "ball.massRatio[3]": 2},
}


@pytest.mark.parametrize("name", SET_UPS)
def test_live_engine_gives_the_native_bits(page, fmu, name):
    """A minute of each, sampled at 3841 instants: sums, positions, velocities, pulses."""
    page.assert_native(fmu, {"balls": 5, "start": SET_UPS[name]}, GRID)


# What is said of a set-up's first click, from 21 us before it to its end, and what goes with the end.
SAID = """
const [preset, x_start] = arguments, said = new Set();
const source = new Live(cradle.engine, PRESETS[preset].setup().with({x_start}));
while (!source.click?.sampled) source.advance(source.time + 0.9 * source.ahead(Infinity).distance);
const {click} = source;
for (const time of [-21e-6, ...Array.from({length: 200}, (_, k) => k / 199 * click.length)]) {
  source.seek(click.begin + time);
  source.caption = captionOf(click, click.begin + time, source.state);
  said.add(source.caption.text);
}
return [...said, source.caption.detail];
"""
CAPTIONS = {
    ("textbook", 2): [
        "Balls 2 and 3 meet in 21 µs.",
        "Ball 2 touches ball 3.",
        "Balls 2 and 3 part. Nothing touches.",
        "Ball 1 touches ball 2. Ball 3 touches ball 4.",
        "Balls 1 and 2 part. Balls 3 and 4 part. Nothing touches.",
        "Ball 2 touches ball 3. Ball 4 touches ball 5.",
        "Balls 2 and 3 part. Balls 4 and 5 part. Nothing touches.",
        "Ball 3 touches ball 4.",
        "The click took 176 µs: 6 pushes.",
        "Compared with the incoming speed: ball 4 at 100 %, ball 5 at 100 %.",
    ],
    ("steel", 2): [
        "Balls 2 and 3 meet in 21 µs.",
        "All four contacts press at once.",
        "Ball 2 still touches ball 3 when ball 1 leaves.",
        "Ball 3 still touches ball 4 when ball 5 leaves.",
        "Ball 3 still touches ball 4 when ball 2 leaves.",
        "The click took 586 µs: 4 pushes.",
        "Compared with the incoming speed: "
        "ball 1 at \N{MINUS SIGN}11 %, ball 2 at \N{MINUS SIGN}4 %, ball 3 at 21 %, ball 4 at 80 %, ball 5 at 114 %.",
    ],
    ("rigid", 1): [
        "Balls 1 and 2 meet in 21 µs.",
        "Rigid balls: 4 impacts in no time at all. There is no inside to look at.",
        "Compared with the incoming speed: ball 5 at 100 %.",
    ],
}


@pytest.mark.parametrize("preset, lifted", CAPTIONS)
def test_live_captions_tell_what_happens(page, preset, lifted):
    assert page.execute_script(SAID, preset, [-0.1] * lifted) == CAPTIONS[preset, lifted]


def test_live_balls_are_dragged_and_let_go(page, fmu):
    """Ball 2 is lifted, ball 1 comes along. From the release on, for a minute the run is the native one."""
    page.drag(1, -120)
    recipe = page.js("return source.setup.recipe()")
    x = [recipe["start"][f"x_start[{i}]"] for i in range(1, 6)]
    assert x[0] == x[1] < -0.03 and x[2:] == [0, 0, 0]
    assert [recipe["start"][f"v_start[{i}]"] for i in range(1, 6)] == [0] * 5
    # Two seconds as the page moves on by itself, picture by picture; then the same without waiting for the clock.
    page.wait("source.run.time > 2")
    reached = page.js("cradle.setRunning(false); return source.run.time")
    later = [time for time in GRID if time > reached]
    pulses = page.js("return source.pulses")
    rows, more = page.js(f"return ({FOLLOW})(source.run, arguments[0])", later)
    assert same_run(fmu, recipe, rows, pulses + more, [0.0, *later]) and len(more) > 100


#: The pointer that has taken a ball moves 170 px to the right in 60 ms, however busy the machine is, and lets go.
THROW = """const [clientX, clientY] = arguments, {canvas, hand} = cradle.stages[0], [pointerId] = hand.ways.keys();
const begin = performance.now(), tell = (kind, by) => canvas.dispatchEvent(
  new PointerEvent(kind, {pointerId, clientX: clientX + by, clientY}));
for (const [later, by] of [[20, 30], [40, 90], [60, 170]]) {
  while (performance.now() < begin + later);
  tell("pointermove", by);
}
tell("pointerup", 170);
return source.setup.values.v_start[4]"""


def test_live_ball_is_thrown_stopped_and_pushed(page):
    # Slowly at first, so that balls are where they were when a hand has reached them.
    page.js("cradle.setPace(1e-3); cradle.lift(1)")
    page.wait("source.run.time > 0")
    x, y = page.place(4)
    page.gesture([(x, y)], release=False)
    page.wait("source.holds.size === 1")
    assert page.js(THROW, x, y) > 0.3  # m/s, to the right
    page.let_go()
    page.js("cradle.setPace(1)")
    page.wait("source.pulses.length > 3")
    # Held, it is where the hand is, whatever bounces off it.
    page.wait("Math.abs(source.state.x[4]) < 0.02")
    page.js("cradle.setPace(1e-3)")
    page.drag(4, 60, release=False)
    held, count, time = page.js("return [source.state.x[4], source.holds.size, source.time]")
    assert count == 1
    # No run is started for that, until it is let go.
    page.js("""window.started = 0; const {start} = cradle.engine;
      cradle.engine.start = function (...given) { started++; return start.apply(this, given); }""")  # fmt: skip
    page.js("cradle.setPace(1)")
    page.wait(f"source.time > {time} + 0.5")
    assert page.js("return source.state.x[4]") == pytest.approx(held, abs=1e-3)
    assert page.js("return started") == 0
    page.let_go()
    assert page.js("return started") == 1
    assert page.js("return source.holds.size") == 0
    # Pushed into the row, a ball takes the others along.
    page.js("cradle.stopAll()")
    page.drag(0, 60)
    impulses = "source.pulses.map(({impulse}) => impulse)"
    assert page.js(f"return Math.max(...{impulses}, 0) + source.state.x[4]") > 0


#: A hand moves a ball of a cradle that buzzes: how often the engine is called for half a second of it in one go, what
#: becomes of the balls, and where the held one is seen when the first call ends.
HELD = """const [effort] = arguments, live = new Live(cradle.engine, PRESETS.buzzing.setup()), seen = [];
live.hold("test", 4, 0);
live.hold("test", 4, 0.03);
for (; live.time < 0.5; seen.push(live.state.x[4])) live.advance(0.5, effort);
return [seen.length, ...live.motion(), seen[0]]"""


def test_live_picture_does_not_wait_for_the_engine_while_a_ball_is_held(page):
    """The engine works on it in short calls, which change nothing; the hand is followed meanwhile."""
    page.js("cradle.setRunning(false)")
    count, x, v, _ = page.js(HELD, 1e12)
    assert count == 1
    some, *parts, first = page.js(HELD, 1500)
    assert some > 3 and parts == [x, v] and first == 0.03


def test_live_throw_stays_on_the_arc(page):
    """However fast the hand, the ball swings to 1.4 rad at most; to which angle, the run says at its start."""
    page.js("cradle.setRunning(false)")
    throw = """source.hold('test', 4, arguments[0]); source.release('test', arguments[1]);
      return [source.drawing.reach, source.setup.values.v_start[4]]"""
    assert page.js(throw, 0.2, 0) == [pytest.approx(np.arcsin(0.5)), 0]
    reach, speed = page.js(throw, 0.1, 100)
    angle = np.arcsin(0.25)
    assert reach == pytest.approx(1.4)
    assert speed == pytest.approx(np.cos(angle) * np.sqrt(2 * 9.81 * 0.4 * (np.cos(angle) - np.cos(1.4))))
    page.js("cradle.setRunning(true)")
    page.wait("source.run.time > 0.5")  # the engine follows it there


def test_live_hand_goes_as_far_as_the_shortest_pendulum_lets_it(page):
    """To 1.2 rad, on an arc or a line; the sliders end there."""
    page.js("cradle.setRunning(false)")
    farthest = """const [circular] = arguments, model = circular ? "circular" : "linear";
      cradle.begin(new Setup(3, {"pendulum.model": model, "pendulum.length": 0.4, "pendulum.lengthRatio": [1, 0.5, 1]}));
      cradle.take("test", 0, -9);
      return [cradle.sources[0].held.get(0), -document.querySelector(".sliders input").min]"""
    for circular, most in ((True, 0.2 * np.sin(1.2)), (False, 0.24)):
        assert page.js(farthest, circular) == [pytest.approx(-most), np.ceil(1e3 * most)]


def test_live_fingers_hold_two_balls(page):
    """Both are lifted at once, to either side, and let go in the same instant."""
    paths = []
    for ball, by in ((0, -50), (4, 50)):
        x, y = page.place(ball)
        paths.append([(x, y), (x + by, y), (x + 2 * by, y)])
    page.gesture(*paths, kind="touch", hold=0.3)
    x = page.js("return source.setup.values.x_start")
    assert x[0] < -0.03 < 0.03 < x[4] and x[1:4] == pytest.approx([0, 0, 0], abs=1e-4)
    assert page.js("return source.holds.size") == 0


def test_live_any_number_of_balls(page):
    """They are heard, too: sounds are counted, as nobody listens."""
    page.press("rest")  # browsers let a page sound after it was touched
    page.js("cradle.set('sound', true)")
    for balls in (1, 2, 20):
        page.js("cradle.resize(arguments[0]); cradle.lift(1)", balls)
        page.wait("source.run.time > 1")
        shown = page.js("return [source.state.balls, source.state.residual / source.state.energy]")
        assert shown[0] == balls and abs(shown[1]) < 1e-12
        assert len(page.find_all(".sliders input")) == balls
    page.wait("cradle.sound.played > 1")


#: What becomes of the set-up, one after the other; where a slider does it: its title, its place, and what it then says.
CHANGES = [
    ("contact.exponent", 1),
    ("contact.exponent", 2),
    ("contact.exponent", 3),
    ("contact.deadBand", 0),
    ("contact.deadBand", 1e-4, "Gap between the balls", 10, "100 µm"),
    ("contact.stiffness", 1e8, "Stiffness", 8, "100 MN/m"),
    ("contact.huntCrossley", 0.3, "Loss in contacts", 0.3, "0.3 s/m"),
    ("pendulum.drag", 0.1, "Air drag", 0.1, "0.1 kg/s"),
    ("contact.model", "hertz"),
    ("pendulum.model", "linear"),
    ("contact.model", "rigid"),
    ("contact.restitution", 0.9, "Speed kept in an impact", 0.9, "90 %"),
    ("ball.massRatio", [1, 1, 4, 1, 1], "Its mass", 7, "\N{MULTIPLICATION SIGN} 4"),
    ("pendulum.length", 0.2, "Strings", 0.2, "200 mm"),
    ("gravity", 1.62),
]
SLIDE = """const [title, place] = arguments, fields = [...document.querySelectorAll(".field")];
const field = fields.find((field) => field.innerText.includes(title)), input = field.querySelector("input");
input.value = place;
for (const kind of ["input", "change"]) input.dispatchEvent(new Event(kind));
return [field.querySelector("output").textContent, input.ariaValueText]"""


# Leaves the part of the energy that a new run begins with.
WATCH = """const { restart } = Object.getPrototypeOf(source);
source.restart = function (...given) {
  const before = this.state.energy;
  restart.apply(this, given);
  window.kept = this.state.energy / before;
};"""


def test_live_contact_changes_while_it_swings(page, fmu):
    """Each change is a new run from where the balls are when none touch; what follows is the native run."""
    page.js("cradle.lift(2); cradle.panels.toggle('change')")
    page.js(WATCH)
    for name, value, *slider in CHANGES:
        page.wait("source.run.time > 0.05")
        page.js("window.kept = null")
        if slider:
            title, at, said = slider
            assert page.js(SLIDE, title, at) == [said, said], name
        else:
            page.js("cradle.change({[arguments[0]]: arguments[1]})", name, value)
        page.wait("!source.pending && window.kept")
        assert page.js("return source.setup.get(arguments[0])", name) == pytest.approx(value), name
        if name not in ("ball.massRatio", "pendulum.length", "gravity"):
            assert 0.97 < page.js("return window.kept") < 1.03, name
    page.assert_native(fmu)


def test_live_refused_change_changes_nothing(page):
    """What it takes but is hardly meant is told, too."""
    page.js("cradle.lift(1); cradle.change({'ball.mass': -1})")
    status = "cradle.controls.status.textContent"
    assert page.js(f"return {status}") == "ball.mass = -1 kg is refused; allowed: finite and > 0 kg"
    assert page.js("return source.setup.get('ball.mass')") == 1
    for link, said in (
        ("balls=50", "balls = 50 is refused; allowed: 1 to 20"),
        ("lift=two", "lift = two is refused; allowed: 1 to 5"),
        ("balls=3&lift=4", "lift = 4 is refused; allowed: 1 to 3"),
        ("balls=5&x_start=0.1", "Is this meant? x_start[1] = 0.1 m and x_start[2]"),
    ):
        page.js("location.hash = arguments[0]", link)
        page.wait(f"{status}.includes({json.dumps(said)})")
    page.js("cradle.tell(''); location.hash = '#preset=figure5'")
    page.wait("cradle.preset === 'figure5'")
    assert page.js(f"return {status}") == ""


KEPT, LOSS = "Speed kept in an impact", "Loss in contacts"
OWN = "balls=3&contact.dampingLaw="
TOLD = [  # of the losses of a set-up, and the sliders that change these
    ("preset=textbook", "", [LOSS]),
    ("preset=clay", f"{KEPT}: 98 % : 98 % : 4.83 % : 98 %", [KEPT]),
    ("preset=rigid&contact.restitution=0.9", f"{KEPT}: 90 %", [KEPT]),
    (f"{OWN}constantRestitution&contact.restitution=0.9", f"{KEPT}: 90 %", [KEPT]),
    (f"{OWN}kelvinVoigt&contact.damping=2000", f"{LOSS}: 2000 N s/m", [LOSS]),
    (f"{OWN}kelvinVoigtNoPull&contact.damping=2000", f"{LOSS}: 2000 N s/m", [LOSS]),
    (f"{OWN}viscoelastic&contact.relaxationTime=2e-6", f"{LOSS}: 2 µs", [LOSS]),
    (f"{OWN}huntCrossley&contact.huntCrossley=0.3&contact.lossRatio=1,2", f"{LOSS}: 0.3 s/m : 0.6 s/m", [LOSS]),
]


#: The damping law, the parameter of its losses, and that.
NOW = """const {setup} = cradle.sources[0], {lossName} = setup;
return [setup.get("contact.dampingLaw"), lossName, setup.get(lossName)]"""


@pytest.mark.parametrize(("link", "told", "sliders"), TOLD)
def test_live_losses_are_told_by_every_law(page, link, told, sliders):
    """A slider changes the law's own parameter; only where nothing is lost, the law as well."""
    page.js("location.hash = arguments[0]", link)
    page.wait(f"source.setup.alike(Setup.fromLink({json.dumps(link)}).setup)")
    parts = page.js("return cradle.stages[0].named").split(" · ")
    assert [part for part in parts if KEPT in part or LOSS in part] == ([told] if told else [])
    page.js("cradle.panels.toggle('change')")
    assert [title for title in (KEPT, LOSS) if title in page.text("#panelbody")] == sliders
    law, name, before = page.js(f"cradle.stopAll(); {NOW}")
    listed = {"contact.damping": 200, "contact.relaxationTime": 2e-8} if told else {}  # in the fifth place
    page.js(SLIDE, sliders[0], 5 if name in listed else 0.5)
    page.wait("!source.pending")
    own = [law, name] if told else ["huntCrossley", "contact.huntCrossley"]
    assert page.js(NOW) == [*own, listed.get(name, 0.5)] != [law, name, before]


#: At instants of a click: forces as parts of its largest one, and how much the contacts glow.
GLOW = """return Array.from({length: 41}, (_, k) => {
  const {click} = source, [stage] = cradle.stages;
  cradle.seek(click.begin + (k / 40) * click.length);
  stage.follow(0);
  return [Array.from(source.state.F, (force) => Math.max(0, force) / click.most.force), Array.from(stage.scene.glow)];
})"""


#: After the first click in real time: how the contacts glow at once, how much of that is seen when the run has gone on
#: for a tenth of a second, and how they glow where time stands still.
FLASH = """const [stage] = cradle.stages, {scene} = stage;
cradle.clock.slowAt("no");
cradle.letGo(cradle.lifted);
while (!source.pulses.length || source.touches) source.advance(source.time + 1e-3);
stage.follow(0.02);
const flash = [...scene.glow];
source.advance(source.time + 0.1);
stage.follow(0.02);
const seen = scene.contacts(scene.places(source.state)).map(({strength}) => strength);
stage.follow(0);
return [flash, seen, [...scene.glow]]"""


def test_live_contacts_glow_by_their_force(page):
    """In slow motion; in real time they flash, but not across a gap that is seen, and not while time stands still."""
    page.js("cradle.choose('desk'); cradle.lift(1); cradle.setRunning(false); cradle.clock.slowAt('always')")
    page.js("while (!source.click?.sampled) source.advance(source.time + 0.9 * source.ahead(Infinity).distance)")
    forces, glow = np.swapaxes(page.js(GLOW), 0, 1)
    assert glow == pytest.approx(forces) and glow.max() > 0.9 and (glow == 0).any()
    flash, seen, still = page.js(FLASH)
    assert flash[3] > 0.5 and seen[3] == 0 and still == [0] * 4


def test_live_inside_a_click(page):
    """Time slows down by itself; then it is ordinary time again."""
    page.js("cradle.choose('steel'); cradle.lift(2); cradle.inside()")
    page.wait("cradle.clock.inside && source.shownClick?.sampled && cradle.clock.rate < 1e-4")
    assert colours(page.find("canvas.cradle")) > 500
    page.js("cradle.seek(source.shownClick.end); cradle.setRunning(true)")
    page.wait("cradle.clock.slow === 'no'")
    assert page.js("return cradle.clock.rate") == 1


def test_live_two_side_by_side(page):
    page.js("cradle.choose('textbook'); cradle.lift(2); cradle.compare('hertz')")
    page.wait("cradle.stages.length === 2 && source.run.time > 1.5")
    shown = "({source}) => [source.setup.recipe().start, source.run.time, Array.from(source.state.x)]"
    first, second = page.execute_script(f"return cradle.stages.map({shown})")
    different = {key for key in second[0] if second[0][key] != first[0].get(key)}
    assert different == {"contact.model", "contact.deadBand"}
    assert first[1] == pytest.approx(second[1], abs=1e-12)
    assert max(abs(a - b) for a, b in zip(first[2], second[2], strict=True)) > 1e-4
    # A hand moves both.
    page.drag(0, -60)
    starts = page.execute_script("return cradle.stages.map(({source}) => source.setup.values.x_start[0])")
    assert starts[0] == starts[1] < 0


def test_live_clock_slows_before_the_page_does(page):
    # Swings that take 0.4 ms: a second of them is work for several, whatever the machine.
    page.js("cradle.begin(PRESETS.buzzing.setup().with({gravity: 1e8}), null); window.spent = []")
    page.js("(function note() { spent.push(cradle.clock.spent); requestAnimationFrame(note); })()")
    page.wait("cradle.controls.status.textContent.includes('the clock runs')")
    assert np.median(page.js("return spent")) < 20
    page.press("rest")
    page.wait("source.run.time > 0")
