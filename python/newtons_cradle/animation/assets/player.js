// Time: playing, scrubbing, and how fast. The first click is shown slowly, later ones when they are looked into.

const SHOWN = 8;       // s on the viewer's clock that the curves are wide
const AFTERGLOW = 0.6; // s on the viewer's clock that a contact shines after its pulse
const LINGER = 1.5;    // s on the viewer's clock before the first and after the last stage of a click

class Player {
  constructor(run) {
    Object.assign(this, { run, t: run.start, base: 1, playing: false, dirty: true, intervals: [] });
    this.scene = new Scene(document.getElementById("stage"), run);
    this.strips = new Strips(run);
    this.slowest = Number.isFinite(run.shortest) ? Math.min(1, 10 ** Math.floor(Math.log10(run.shortest / 2))) : 1e-3;
    // the click that is looked into, or that time slows down for
    this.opened = run.clicks[0]?.closed === "" ? run.clicks[0] : null;
    this.controls = new Controls(this);
    requestAnimationFrame((now) => this.frame(now));
    addEventListener("resize", () => { this.dirty = true; });
    DARK.addEventListener("change", () => {
      this.scene.paint();
      this.strips.paint();
    });
  }

  /** Seconds of the run per second of the viewer's at time t. */
  speed(t = this.t) {
    return this.opened ? this.opened.speed(t, this.base) : this.base;
  }

  /** Whether time is slow because of a click. */
  get inside() { return this.opened !== null && this.speed() < 0.02 * this.base; }

  /** The click that is looked into, else the one that began last, else the first. */
  get click() {
    return this.opened ?? this.run.lastClick(this.t) ?? this.run.clicks[0];
  }

  seek(t) {
    this.t = Math.min(Math.max(t, this.run.start), this.run.stop);
    this.dirty = true;
  }

  /** Moves as the viewer asks; a click that is left behind closes. */
  go(t) {
    this.seek(t);
    if (this.opened && !this.inside && (this.opened !== this.run.clicks[0] || this.t > this.opened.end))
      this.opened = null;
  }

  /** Looks inside a click, from just before it; stays at its first stage where motion is to be reduced. */
  open(click = this.click) {
    if (!click || click.closed) return;
    this.opened = click;
    const [first] = click.stages;
    if (STILL.matches) {
      this.play(false);
      this.seek(0.5 * (first.from + first.to));
    } else {
      this.seek(click.begin - LINGER * click.speed(click.begin, 1) * 0.5);
      this.play(true);
    }
  }

  /** Back to real time, after the click. */
  leave() {
    const { end } = this.opened;
    this.opened = null;
    this.seek(Math.max(this.t, end));
  }

  /** The click after or before the time shown; inside a click, the middle of the stage after or before. */
  jump(direction) {
    if (this.inside) return this.stage(direction);
    const { clicks } = this.run, click = direction > 0 ? clicks.find(({ begin }) => begin > this.t)
      : clicks.findLast(({ begin }) => begin < this.t);
    if (!click) return;
    this.opened = null;
    this.seek(click.begin);
  }

  stage(direction) {
    const { stages, begin, end } = this.opened;
    const place = Math.min(stages.length, Math.max(-1, this.opened.stageAt(this.t) + direction));
    const pause = 0.2 * this.opened.speed(begin, 1);
    this.play(false);
    if (place < 0) this.seek(begin - pause);
    else this.seek(place < stages.length ? 0.5 * (stages[place].from + stages[place].to) : end + pause);
  }

  play(on = !this.playing) {
    if (on && this.t >= this.run.stop) this.seek(this.run.start);
    this.playing = on;
    this.intervals = [];
    this.dirty = true;
  }

  /** Sets the speed outside of clicks that are looked into. */
  setSpeed(speed) {
    this.base = Math.min(1, Math.max(this.slowest, speed));
    this.dirty = true;
  }

  frame(now) {
    const passed = now - (this.last ?? now), seconds = Math.min(passed, 100) / 1000;
    this.last = now;
    if (this.playing) this.advance(seconds, passed);
    this.scene.eye.glide(this.inside ? 1 : 0, seconds);
    if (this.dirty || this.scene.eye.changed) this.draw();
    requestAnimationFrame((later) => this.frame(later));
  }

  /** Moves on by `seconds` of the viewer's, in small steps while the speed changes. */
  advance(seconds, passed) {
    for (let k = 0; k < 8; k++) this.seek(this.t + this.speed() * seconds / 8);
    if (this.opened && this.t > this.opened.end && this.speed() > 0.5 * this.base) this.opened = null;
    if (this.t >= this.run.stop) this.play(false);
    this.intervals.push(passed);
    if (this.intervals.length === 40) {
      const mean = this.intervals.slice(10).reduce((a, b) => a + b) / 30;
      if (mean > 20 && this.scene.resolution > 0.7) this.scene.resolution *= 0.84; // too slow: fewer pixels
      this.intervals = [];
    }
  }

  /** Everything at the time shown: {time, speed, x, v, F, glow}, SI units. */
  state() {
    const { run, t: time } = this, place = run.place(time), speed = this.speed();
    const fade = STILL.matches ? 1e-30 : AFTERGLOW * speed;
    const [v, F] = [run.v, run.F].map((columns) => columns.map((column) => linear(column, place)));
    return { time, speed, x: run.x.map((x, i) => cubic(x, run.v[i], place)), v, F,
      glow: F.map((_, i) => run.glow(i, time, fade, place)) };
  }

  /** What is to be seen, in words. */
  caption() {
    const { run, opened } = this, { clicks } = run, last = run.lastClick(this.t);
    if (!clicks.length) return run.balls > 1 ? "No balls touch in this run." : "A single ball.";
    if (opened && this.inside) return opened.caption(this.t);
    if (last) return `Click ${last.number + 1} of ${clicks.length}. ${last.closed}`.trim();
    return opened ? "The first click is shown slowly, stage by stage." : clicks[0].closed || `${clicks.length} clicks.`;
  }

  draw() {
    this.dirty = this.scene.eye.changed = false;
    const state = this.state(), span = this.frozen ?? SHOWN * state.speed;
    this.scene.update(state);
    this.scene.draw();
    this.strips.draw(this.t, span);
    this.controls.show(state.speed, span);
  }
}

/** The player, once the page's data are unpacked. */
const ready = (async () => {
  try {
    const run = await Run.load(JSON.parse(document.getElementById("data").textContent));
    return (window.cradle = new Player(run));
  } catch (problem) {
    const failure = document.getElementById("failure");
    failure.textContent = `This browser cannot show the animation: ${problem.message}`;
    failure.hidden = false;
    throw problem;
  }
})();
