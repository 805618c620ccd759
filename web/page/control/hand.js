// Hands: pointers that take balls, several at once, and the keyboard's sliders that do the same.

import { aria, element } from "#view/elements.js";
import { say } from "#view/texts.js";

const REACH = 22;         // px beside a ball that still take it, for fingers
const TURN = 0.006;       // rad by which the view turns for a px
const STILL = 70;         // ms without a move after which a hand is at rest
const MEMORY = 90;        // ms of a hand's way that say how fast it throws
const FASTEST_THROW = 4;  // m/s

export class Hand {
  /** `stage`: where; `app`: who is told: `take`, `move`, `drop`. */
  constructor(stage, app) {
    Object.assign(this, { stage, app, ways: new Map(), turns: new Map() });
    const { canvas } = stage;
    canvas.onpointerdown = (event) => this.down(event);
    canvas.onpointermove = (event) => this.move(event);
    canvas.oncontextmenu = (event) => { if (app.space) event.preventDefault(); };
    canvas.onpointerup = canvas.onpointercancel = (event) => this.up(event);
  }

  down(event) {
    const { scene, source, canvas } = this.stage, point = { x: event.offsetX, y: event.offsetY };
    const reach = event.pointerType === "mouse" ? 6 : REACH, other = event.button > 0 || event.shiftKey;
    const ball = source.live && !other ? scene.ballAt(point, source.state, reach) : -1;
    if (ball < 0 && !this.app.space) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    if (ball < 0) return void this.turns.set(event.pointerId, point);
    const x = source.state.x[ball], grip = x - scene.displacement(ball, point);
    this.ways.set(event.pointerId, { ball, grip, way: [{ time: event.timeStamp, x }] });
    this.app.take(event.pointerId, ball, x);
  }

  move(event) {
    const { scene, source, canvas } = this.stage, point = { x: event.offsetX, y: event.offsetY };
    const hold = this.ways.get(event.pointerId), before = this.turns.get(event.pointerId);
    if (before) {
      const part = TURN / this.turns.size; // several fingers turn it together
      this.app.eye.turn(part * (point.x - before.x), part * (point.y - before.y));
      return void this.turns.set(event.pointerId, point);
    }
    if (!hold) {
      if (source.live) canvas.style.cursor = scene.ballAt(point, source.state, 6) >= 0 ? "grab" : "";
      return;
    }
    canvas.style.cursor = "grabbing";
    const x = scene.displacement(hold.ball, point) + hold.grip;
    hold.way.push({ time: event.timeStamp, x });
    while (hold.way.length > 2 && event.timeStamp - hold.way[0].time > MEMORY) hold.way.shift();
    this.app.move(event.pointerId, hold.ball, x);
  }

  up(event) {
    this.turns.delete(event.pointerId);
    const hold = this.ways.get(event.pointerId);
    if (!hold) return;
    this.ways.delete(event.pointerId);
    this.stage.canvas.style.cursor = "";
    const first = hold.way[0], last = hold.way.at(-1);
    const still = event.timeStamp - last.time > STILL || last.time - first.time < 8;
    const speed = still ? 0 : (1000 * (last.x - first.x)) / (last.time - first.time);
    this.app.drop(event.pointerId, Math.abs(speed) < 0.02 ? 0
      : Math.max(-FASTEST_THROW, Math.min(FASTEST_THROW, speed)));
  }
}

/** A slider for each ball, for the keyboard and for screen readers; seen are only the balls. */
export class Sliders {
  constructor(stage, app) {
    Object.assign(this, { stage, app, inputs: [], box: element(stage.figure, "div", { className: "sliders" }) });
  }

  /** As many as there are balls. */
  fit() {
    const { source } = this.stage, { balls } = source.drawing;
    while (this.inputs.length > balls) this.inputs.pop().remove();
    while (this.inputs.length < balls) this.add(this.inputs.length);
    for (const input of this.inputs) input.disabled = !source.live;
  }

  add(ball) {
    const who = `keys ${ball}`, input = element(this.box, "input", { type: "range", min: -120, max: 120, step: "any" });
    aria(input, { label: say("ball", { ball: ball + 1 }) });
    input.onkeydown = (event) => {
      const { source } = this.stage, step = 0.025 * source.drawing.length * (event.shiftKey ? 0.2 : 1);
      const direction = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (direction) {
        const x = (source.holds.get(who)?.x ?? source.state.x[ball]) + direction * step;
        this.app.take(who, ball, x);
        this.app.move(who, ball, x);
      } else if (["Enter", "Escape"].includes(event.key)) this.app.drop(who, 0);
      else return;
      event.preventDefault();
      event.stopPropagation();
      this.tell();
    };
    input.onblur = () => { if (this.stage.source.holds?.has(who)) this.app.drop(who, 0); };
    this.inputs.push(input);
  }

  /** The ball that has the keyboard, from 0; -1 for none. */
  get chosen() { return this.inputs.indexOf(document.activeElement); }

  /** Says where the chosen ball is. */
  tell() {
    const { source } = this.stage, ball = this.chosen;
    if (ball < 0) return;
    const hold = source.holds?.get(`keys ${ball}`), x = hold?.x ?? source.state.x[ball];
    this.inputs[ball].value = (100 * x) / source.drawing.length;
    const distance = `${Math.abs(100 * x).toFixed(1)} cm`, way = x < 0 ? "toTheLeft" : "toTheRight";
    const place = distance === "0.0 cm" ? say("hangs") : say(way, { distance });
    aria(this.inputs[ball], { valuetext: hold ? say("held", { place }) : place });
  }
}
