// Time: playing, scrubbing, and how fast. The strips show as much time as passes in some seconds of the viewer's.

const SHOWN = 8;       // s on the viewer's clock that the strips are wide
const IMPACT = 4;      // s on the viewer's clock that an impact takes when the player slows down for it
const APPROACH = 3;    // 1/s: nearing an impact, the distance to it shrinks at this rate
const AFTERGLOW = 0.6; // s on the viewer's clock that a contact shines after its pulse

class Player {
  constructor(run) {
    this.run = run;
    this.scene = new Scene(document.getElementById("stage"), run);
    this.strips = new Strips(document.getElementById("strips"), document.getElementById("whole"), run);
    this.t = run.start;
    this.base = 1;
    this.slowest = Number.isFinite(run.shortest) ? Math.min(1, 10 ** Math.floor(Math.log10(run.shortest / 2))) : 1e-3;
    this.playing = false;
    this.dirty = true;
    this.intervals = [];
    this.controls = Object.fromEntries([...document.querySelectorAll("#controls [id], #clock [id]")].map((item) => [item.id, item]));
    document.getElementById("subtitle").textContent = [run.title, ...this.scene.notes].join(" · ");
    this.describe();
    this.listen();
    this.showSpeed();
    requestAnimationFrame((now) => this.frame(now));
    addEventListener("resize", () => { this.dirty = true; });
  }

  /** What the colours of the energies mean. */
  describe() {
    for (const name of Object.keys(this.run.energy)) {
      const item = document.createElement("span"), patch = document.createElement("i");
      patch.style.background = ENERGY_COLOURS[name];
      item.append(patch, `${name} energy`);
      this.controls.legend.append(item);
    }
  }

  /** Seconds of the run per second of the viewer's at time t. */
  speed(t = this.t) {
    if (!this.controls.slow.checked) return this.base;
    const { distance, length } = this.run.nearest(t);
    return Math.min(this.base, Math.max(length / IMPACT, APPROACH * distance, this.slowest));
  }

  seek(t) {
    this.t = Math.min(Math.max(t, this.run.start), this.run.stop);
    this.dirty = true;
  }

  /** Stops at the impact after or before the time shown. */
  jump(direction) {
    const impact = this.run.neighbour(this.t, direction);
    if (impact) this.seek(impact.begin);
  }

  play(on = !this.playing) {
    if (on && this.t >= this.run.stop) this.seek(this.run.start);
    this.playing = on;
    this.intervals = [];
    this.controls.play.textContent = on ? "Pause" : "Play";
    this.dirty = true;
  }

  /** Sets the speed away from impacts. */
  setSpeed(speed) {
    this.base = Math.min(1, Math.max(this.slowest, speed));
    this.showSpeed();
    this.dirty = true;
  }

  showSpeed() {
    this.controls.speed.value = 1 - Math.log(this.base) / Math.log(this.slowest);
    this.controls.factor.textContent = this.base === 1 ? "real time" : `1 s shows ${withPrefix(this.base, "s", 2)}`;
  }

  listen() {
    const { play, next, previous, speed, slow } = this.controls, { canvas, whole } = this.strips;
    play.addEventListener("click", () => this.play());
    next.addEventListener("click", () => this.jump(1));
    previous.addEventListener("click", () => this.jump(-1));
    speed.addEventListener("input", () => this.setSpeed(this.slowest ** (1 - Number(speed.value))));
    slow.addEventListener("change", () => { this.dirty = true; });
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.setSpeed(this.speed() * Math.exp(0.002 * event.deltaY)); }, { passive: false });
    this.drag(canvas, (event, grip) => this.seek(grip.t - (event.offsetX - grip.x) * grip.span / canvas.clientWidth));
    this.drag(whole, (event) => this.seek(this.run.start + (this.run.stop - this.run.start) * event.offsetX / whole.clientWidth));
    addEventListener("keydown", (event) => {
      const keys = { " ": () => this.play(), "]": () => this.jump(1), "[": () => this.jump(-1),
        ArrowRight: () => this.seek(this.t + 0.02 * SHOWN * this.speed()), ArrowLeft: () => this.seek(this.t - 0.02 * SHOWN * this.speed()) };
      if (event.target.matches("input, button") || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
  }

  /** Calls `move(event, grip)` while the pointer is held down; `grip` is where and when it was taken. */
  drag(canvas, move) {
    let grip = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      grip = { x: event.offsetX, t: this.t, span: SHOWN * this.speed(), played: this.playing };
      this.frozen = grip.span;
      this.play(false);
      move(event, grip);
    });
    canvas.addEventListener("pointermove", (event) => { if (grip) move(event, grip); });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, () => {
        if (grip?.played) this.play(true);
        grip = this.frozen = null;
        this.dirty = true;
      });
    }
  }

  frame(now) {
    const passed = now - (this.last ?? now);
    this.last = now;
    if (this.playing) this.advance(Math.min(passed, 100) / 1000, passed);
    if (this.dirty || this.scene.changed) this.draw();
    requestAnimationFrame((later) => this.frame(later));
  }

  /** Moves on by `seconds` of the viewer's, in small steps while the speed changes. */
  advance(seconds, passed) {
    for (let k = 0; k < 8; k++) this.seek(this.t + this.speed() * seconds / 8);
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
    const { run, t } = this, place = run.place(t), speed = this.speed();
    return {
      time: t,
      speed,
      x: run.x.map((_, i) => run.position(i, place)),
      v: run.v.map((column) => run.linear(column, place)),
      F: run.F.map((column) => run.linear(column, place)),
      glow: run.F.map((_, i) => run.glow(i, t, AFTERGLOW * speed, place)),
    };
  }

  draw() {
    this.dirty = this.scene.changed = false;
    const state = this.state(), span = this.frozen ?? SHOWN * state.speed;
    this.scene.update(state);
    this.scene.draw();
    this.strips.draw(this.t, span);
    const digits = Math.min(12, Math.max(3, 2 - Math.floor(Math.log10(span))));
    this.controls.time.textContent = `${this.t.toFixed(digits)} s`;
    this.controls.pace.textContent = state.speed === 1 ? "real time" : `1 s shows ${withPrefix(state.speed, "s", 2)}`;
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
