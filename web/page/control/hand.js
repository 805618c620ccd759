// Hands: pointers that take balls, several at once, and the keyboard's sliders that do the same.

import { aria, element } from "#view/common.js";
import { say } from "#view/texts.js";

const REACH = 22;         // px beside a ball that still take it, for fingers
const TURN = 0.006;       // rad by which the view turns for a px
const STILL = 70;         // ms without a move after which a hand is at rest
const MEMORY = 90;        // ms of a hand's way that say how fast it throws
const FASTEST_THROW = 4;  // m/s

export class Hand {
  /** `ways`: pointers on the canvas; those with a `ball` of -1 turn the view. */
  constructor(stage) {
    const { canvas, app } = stage;
    Object.assign(this, { stage, app, ways: new Map() });
    const acts = { pointerdown: "down", pointermove: "move", pointerup: "up", pointercancel: "up" };
    for (const [kind, act] of Object.entries(acts))
      canvas.addEventListener(kind, (event) => this[act](event, { x: event.offsetX, y: event.offsetY }));
    canvas.oncontextmenu = (event) => { if (app.space) event.preventDefault(); };
  }

  /** The ball at a point, from 0, if it can be taken; else -1. */
  ballAt(point, margin) {
    const { scene, source } = this.stage;
    return source.live ? scene.ballAt(point, source.state, margin) : -1;
  }

  down(event, point) {
    const { stage: { scene, source, canvas }, app } = this, { pointerId, pointerType, timeStamp: time } = event;
    const ball = event.button > 0 || event.shiftKey ? -1 : this.ballAt(point, pointerType === "mouse" ? 6 : REACH);
    if ((ball < 0 && !app.space) || app.lesson.point(ball)) return;
    event.preventDefault();
    canvas.setPointerCapture(pointerId);
    if (ball < 0) return void this.ways.set(pointerId, { ball, point });
    const x = source.state.x[ball], grip = x - scene.displacement(ball, point);
    this.ways.set(pointerId, { ball, grip, way: [{ time, x }] });
    app.take(pointerId, ball, x);
  }

  move({ pointerId, timeStamp: time }, point) {
    const { stage: { scene, canvas }, app } = this, hold = this.ways.get(pointerId), { ball, way } = hold ?? {};
    if (!hold) canvas.style.cursor = this.ballAt(point, 6) >= 0 ? "grab" : "";
    else if (ball < 0) {
      const part = TURN / [...this.ways.values()].filter(({ ball }) => ball < 0).length; // fingers turn it together
      app.eye.turn(part * (point.x - hold.point.x), part * (point.y - hold.point.y));
      hold.point = point;
    } else {
      canvas.style.cursor = "grabbing";
      const x = scene.displacement(ball, point) + hold.grip;
      Object.assign(hold, { point, unit: scene.unit });
      way.push({ time, x });
      while (way.length > 2 && time - way[0].time > MEMORY) way.shift();
      app.move(pointerId, ball, x);
    }
  }

  /** Keeps held balls below their pointers when the picture has changed its scale. */
  follow() {
    const { scene } = this.stage;
    for (const [pointerId, { ball, grip, point, unit }] of this.ways)
      if (ball >= 0 && point && unit !== scene.unit)
        this.app.move(pointerId, ball, scene.displacement(ball, point) + grip);
  }

  up({ pointerId, timeStamp }) {
    const { ball, way } = this.ways.get(pointerId) ?? { ball: -1 };
    this.ways.delete(pointerId);
    if (ball < 0) return;
    this.stage.canvas.style.cursor = "";
    const first = way[0], last = way.at(-1), still = timeStamp - last.time > STILL || last.time - first.time < 8;
    const speed = still ? 0 : (1000 * (last.x - first.x)) / (last.time - first.time);
    const thrown = Math.max(-FASTEST_THROW, Math.min(FASTEST_THROW, speed));
    this.app.drop(pointerId, Math.abs(thrown) < 0.02 ? 0 : thrown);
  }
}

/** An invisible slider for each ball, for the keyboard and for screen readers. */
export class Sliders {
  constructor(stage) {
    const box = element(stage.figure, "div", { className: "sliders" });
    Object.assign(this, { stage, app: stage.app, inputs: [], box });
  }

  fit() {
    const { live, drawing: { balls, farthest } } = this.stage.source, most = Math.ceil(1e3 * farthest);
    while (this.inputs.length > balls) this.inputs.pop().remove();
    while (this.inputs.length < balls) this.add(this.inputs.length);
    for (const input of this.inputs) Object.assign(input, { disabled: !live, min: -most, max: most });
    this.tellAll();
  }

  /** Says where the balls are, except for a chosen ball that swings, which would be told again and again. */
  tellAll() {
    const { app, inputs, chosen } = this;
    for (const ball of inputs.keys()) if (ball !== chosen || !app.clock.running) this.tell(ball);
  }

  add(ball) {
    const { app, stage } = this, who = `keys ${ball}`;
    const input = element(this.box, "input", { type: "range", step: "any" });
    aria(input, { label: say("ball", { ball: ball + 1 }) });
    input.onkeydown = (event) => {
      const { source } = stage, step = 0.025 * source.drawing.length * (event.shiftKey ? 0.2 : 1);
      const direction = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (direction) {
        const x = (source.holds.get(who)?.x ?? source.state.x[ball]) + direction * step;
        app.take(who, ball, x);
        app.move(who, ball, x);
      } else if (["Enter", "Escape"].includes(event.key)) app.drop(who, 0);
      else return;
      event.preventDefault();
      event.stopPropagation();
      this.tell(ball);
    };
    input.onfocus = () => this.tell(ball);
    input.onblur = () => { if (stage.source.holds?.has(who)) app.drop(who, 0); };
    this.inputs.push(input);
  }

  /** The ball with the keyboard focus, from 0; -1 for none. */
  get chosen() { return this.inputs.indexOf(document.activeElement); }

  /** Says where a ball is (mm). */
  tell(ball) {
    const { source } = this.stage, held = source.held?.get(ball), x = held ?? source.state.x[ball];
    const mm = (1e3 * x).toFixed(1), way = x < 0 ? "toTheLeft" : "toTheRight";
    const place = Number(mm) ? say(way, { distance: `${mm.replace("-", "")} mm` }) : say("hangs");
    this.inputs[ball].value = mm;
    aria(this.inputs[ball], { valuetext: held === undefined ? place : say("held", { place }) });
  }
}
