// The cradle in space: the scene of scene.js, seen by an eye that goes around it.

import { dot, Lens, minus, plus } from "#view/eye.js";
import { LARGEST, Scene } from "#view/scene.js";
import { Painter } from "#view/painter.js";

const BAR = 0.13, BEND = 0.8, BEND_PIECES = 7; // of the frame's round bars: radius, and their bent corners, in radii
const EYELET = 0.16, STRING = 0.016;           // radii
const BASE = 0.42, BEYOND = 1.1;               // how thick the base is, and how far it reaches beyond the bars
const STEEPEST = 1.4;                          // rad by which a hand can lift a ball
const STEEP = 0.75;                            // sine of the angle from above which the base mirrors nothing to be seen
const SLOW = 26;                               // ms between pictures after which they get fewer pixels

export class Scene3D extends Scene {
  /** A scene on the canvas seen by the eye; null where there is no WebGL. `lost` is called when it goes away. */
  static open(canvas, eye, lost) {
    const back = document.createElement("canvas"), painter = Painter.open(back);
    if (!painter) return null;
    Object.assign(back, { className: "space", ariaHidden: "true" });
    canvas.before(back);
    back.addEventListener("webglcontextlost", () => { if (back.isConnected) lost(); });
    return Object.assign(new Scene3D(canvas), { back, painter, eye, sharp: 1, pace: 0 });
  }

  get layers() { return [this.back, this.canvas]; }

  close() {
    this.back.remove();
    this.painter.close();
  }

  layout(drawing, near = 0, swingAngle = 0.56) {
    super.layout(drawing, near, swingAngle);
    // From here on in radii: what the flat scene has decided in pixels.
    const { unit, sizes, width, height } = this;
    const half = sizes.reduce((sum, size) => sum + size, 0), largest = Math.max(...sizes), long = this.string / unit;
    const rests = this.positions.map((x) => (x - 0.5 * width) / unit);
    const wide = half + 0.9, deep = Math.max(2.5, largest + 0.9), floor = -1.75 * largest;
    Object.assign(this, { rests, long, frame: { wide, deep, floor, top: long } });
    const reach = half + long * Math.sin(swingAngle), rise = long * (1 - Math.cos(swingAngle));
    const all = [...box(wide, floor, long, deep), ...box(reach, rise - largest, rise + largest, largest),
      ...box(wide + BEYOND + 1.5, floor - BASE, floor, deep + BEYOND + 1.5)];
    const distance = 2.7 * Math.max(...all.map((point) => Math.hypot(...point)));
    const lens = () => new Lens(this.eye.axes, distance), far = lens().fit(all, width, height, 12, LARGEST);
    const close = lens().fit(box(half + 1.2, -2.1 * largest, 4.9 * largest, 0), width, height, 0, LARGEST);
    this.lens = far.towards(close.focal > far.focal ? close : far, near);
    this.unit = this.lens.focal / distance;
    return this;
  }

  /** Where ball `i` is in space. */
  at(i, x) {
    const angle = x / this.length;
    return [this.rests[i] + this.long * Math.sin(angle), this.long * (1 - Math.cos(angle)), 0];
  }

  place(i, x) {
    const at = this.at(i, x);
    return { at, ...this.lens.place(at) };
  }

  displacement(i, { x, y }) {
    const { lens, eye } = this, rest = lens.place(this.at(i, 0)), axes = eye.axesAside;
    const start = lens.place(this.at(i, 0), axes);
    const away = (angle) => {
      const place = lens.place(this.at(i, angle * this.length), axes);
      return Math.hypot(place.x - start.x - (x - rest.x), place.y - start.y - (y - rest.y));
    };
    return this.length * lowest(away, -STEEPEST, STEEPEST);
  }

  ahead({ at, x, y }, radii) {
    const end = this.lens.place([at[0] + radii, at[1], at[2]]);
    return { x: end.x - x, y: end.y - y };
  }

  contact(i, a, b) {
    const from = this.sizes[i], reach = from + this.sizes[i + 1], part = from / reach;
    const way = minus(b.at, a.at), at = plus(a.at, way, part);
    return { at, away: Math.hypot(...way) / reach - 1, ...this.lens.place(at) };
  }

  /** Numbers only of balls of which others do not hide the middle. */
  drawLabels(places, theme) {
    const hidden = ({ x, y, unit }) => places.some((other, i) => other.unit > 1.001 * unit
      && Math.hypot(other.x - x, other.y - y) < 0.9 * this.sizes[i] * other.unit);
    const { context: c } = this, shown = places.map((place) => (hidden(place) ? { ...place, x: -1e4 } : place));
    Object.assign(c, { shadowColor: theme.halo, shadowBlur: 8 });
    for (let k = 0; k < 2; k++) super.drawLabels(shown, theme);
    c.shadowBlur = 0;
  }

  drawCradle(places, { space }) {
    const { canvas, back, lens, frame: { wide, deep, floor, top }, painter, ratio } = this;
    const { offsetLeft, offsetTop, clientWidth, clientHeight } = canvas;
    const box = `left:${offsetLeft}px;top:${offsetTop}px;width:${clientWidth}px;height:${clientHeight}px`;
    if (this.box !== box) back.style.cssText = this.box = box;
    painter.begin();
    this.addStand(clientHeight);
    this.addShadows(places);
    if (lens.axes[2][1] < STEEP) this.addAll(places, 1);
    this.addAll(places, 0);
    const moving = painter.finish([...lens.axes.map((axis) => [...axis, 0]), [...lens.eye, 0],
      [lens.focal, lens.x, clientHeight - lens.y, 0], [wide, deep, floor, top], [BEYOND, BASE, 0, 0], ...space]);
    const wanted = moving ? ratio * this.sharpness() : ratio, size = [clientWidth, clientHeight, wanted].join();
    if (moving || this.size !== size) painter.paint(clientWidth, clientHeight, wanted);
    this.size = size;
  }

  /** How much of its pixels a moving picture gets, so that it can be drawn in time. */
  sharpness() {
    const now = performance.now(), passed = now - this.last;
    this.last = now;
    if (passed < 200) this.pace += 0.08 * (passed - this.pace);
    if (this.pace > SLOW && this.sharp > 0.5) Object.assign(this, { sharp: Math.max(0.5, 0.8 * this.sharp), pace: 0 });
    return this.sharp;
  }

  /** The base, within the part of the picture that it and its shadow take. */
  addStand(height) {
    const { painter, lens, frame: { wide, deep, floor } } = this;
    const places = [...box(wide + BEYOND + 2.5, floor - BASE, floor - BASE, deep + BEYOND + 2.5),
      ...box(wide + BEYOND, floor, floor, deep + BEYOND)].map((point) => lens.place(point));
    const range = (axis, reach) => reach(...places.map((place) => place[axis]));
    painter.add("STAND", [range("x", Math.min), height - range("y", Math.max), range("x", Math.max),
      height - range("y", Math.min)]);
  }

  /** What darkens the base below it: balls, and the feet of the bars. */
  addShadows(places) {
    const { painter, frame: { wide, deep, floor } } = this;
    places.forEach(({ at }, i) => painter.add("SHADOW", [...at, this.sizes[i]]));
    for (const x of [-wide, wide])
      for (const z of [-deep, deep]) painter.add("SHADOW", [x, floor + 0.2, z, 1.4 * BAR]);
  }

  /** Frame, balls with their strings, and glow; what is farther from the eye comes first, so that what is nearer covers
   *  it. `mirrored`: as the base reflects them. */
  addAll(places, mirrored) {
    const { lens: { eye }, frame } = this, { deep } = frame;
    const sides = [-deep, deep].sort((a, b) => Math.abs(eye[2] - b) - Math.abs(eye[2] - a));
    this.addBar(sides[0], eye, mirrored);
    // From the end of the row, both bars are behind the balls, or beside them.
    if (Math.abs(eye[2]) <= deep) this.addBar(sides[1], eye, mirrored);
    const order = [...places.keys()].sort((i, j) =>
      Math.abs(places[j].at[0] - eye[0]) - Math.abs(places[i].at[0] - eye[0]));
    const done = new Set();
    for (const i of order) {
      this.addBall(i, places, eye, mirrored);
      for (const contact of [i - 1, i])
        if (done.has(contact === i ? i + 1 : i - 1)) this.addGlow(contact, places, eye, mirrored);
      done.add(i);
    }
    if (Math.abs(eye[2]) > deep) this.addBar(sides[1], eye, mirrored);
  }

  /** A bar on two posts, bent from one piece. */
  addBar(z, eye, mirrored) {
    const { wide, floor, top } = this.frame, points = [[-wide, floor, z]];
    for (const side of [-1, 1])
      for (let k = 0; k <= BEND_PIECES; k++) {
        const angle = (0.5 * Math.PI * (side < 0 ? k : BEND_PIECES - k)) / BEND_PIECES;
        points.push([side * (wide - BEND * (1 - Math.cos(angle))), top - BEND * (1 - Math.sin(angle)), z]);
      }
    points.push([wide, floor, z]);
    const middle = wide - BEND, high = top - BEND, straight = [0, BEND_PIECES + 1, 2 * BEND_PIECES + 2];
    const pieces = points.slice(1).map((to, k) => ({ from: points[k], to,
      bend: straight.includes(k) ? [] : [0, k <= BEND_PIECES ? -middle : middle, high, BEND] }));
    const away = ({ from, to }) => Math.hypot(...minus(plus(from, minus(to, from), 0.5), eye));
    pieces.sort((a, b) => away(b) - away(a));
    for (const { from, to, bend } of pieces)
      this.painter.add("ROD", [...from, BAR], to, bend, mirrored);
  }

  /** A ball on its strings. */
  addBall(i, places, eye, mirrored) {
    const { painter, sizes, rests, long, frame: { deep } } = this, { at } = places[i], size = sizes[i];
    const beside = (k, contact) =>
      (places[k] ? [places[k].at[0], places[k].at[1], sizes[k], this.shining(contact, places)] : [0, 0, 0, 0]);
    const up = [(rests[i] - at[0]) / long, (long - at[1]) / long, 0];
    const hook = plus(at, up, size + EYELET);
    const string = () => {
      if (mirrored) return;
      painter.add("ROD", [...plus(at, up, 0.96 * size), 0.055], hook);
      for (const z of [-deep, deep])
        painter.add("ROD", [...hook, STRING], [rests[i], long - 0.9 * BAR, z], [1]);
    };
    const behind = dot(up, minus(eye, hook)) < 0;
    if (behind) string();
    painter.add("BALL", [...at, size], beside(i - 1, i - 1), beside(i + 1, i), mirrored);
    if (!behind) string();
  }

  /** How much a contact shines; what has parted does not any more. */
  shining(i, places) {
    const glow = this.glow[i] ?? 0;
    if (glow < 0.004 || !places[i] || !places[i + 1]) return 0;
    return Math.sqrt(glow) * Math.max(0, 1 - 4 * this.contact(i, places[i], places[i + 1]).away);
  }

  /** Light around a contact. The balls themselves hide it from who looks along the row. */
  addGlow(i, places, eye, mirrored) {
    const strength = this.shining(i, places);
    if (strength <= 0.05) return;
    const { at } = this.contact(i, places[i], places[i + 1]), view = minus(eye, at);
    const row = minus(places[i + 1].at, places[i].at);
    const along = dot(view, row) / (Math.hypot(...view) * Math.hypot(...row));
    const seen = strength * Math.sqrt(Math.max(0, 1 - along * along));
    this.painter.add("GLOW", [...at, 0.4 + 1.3 * strength], [], [seen], mirrored);
  }
}

/** The corners of a box around the origin's height. */
function box(x, low, high, z) {
  return [-x, x].flatMap((a) => [low, high].flatMap((b) => [-z, z].map((c) => [a, b, c])));
}

/** Where a function is lowest, of which the lowest of 48 samples is close. */
function lowest(f, from, to) {
  const samples = 48, step = (to - from) / samples;
  let best = from;
  for (let k = 1; k <= samples; k++) if (f(from + k * step) < f(best)) best = from + k * step;
  let [low, high] = [Math.max(from, best - step), Math.min(to, best + step)];
  for (let k = 0; k < 40; k++) {
    const third = (high - low) / 3;
    if (f(low + third) < f(high - third)) high -= third; else low += third;
  }
  return 0.5 * (low + high);
}
