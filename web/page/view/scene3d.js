// The cradle in space: the scene of scene.js, seen by an eye that goes around it.

import { box, minus, plus } from "#view/eye.js";
import { Scene } from "#view/scene.js";
import { Painter } from "#view/painter.js";

const BAR = 0.13, BEND = 0.8, BEND_PIECES = 7; // of the frame's round bars: radius, and their bent corners, in radii
const EYELET = 0.16, STRING = 0.016;           // radii
const BASE = 0.42, BEYOND = 1.1;               // how thick the base is, and how far it reaches beyond the bars
const FAR = 1e3;                               // beyond all that is sorted by its distance, in radii
const STEEL = [0.95, 0.97, 1];                 // what it mirrors of red, green and blue light
const IN_RECTANGLE = [0, 0, 0, 1];             // of a thing that is within a rectangle of the picture

export class Scene3D extends Scene {
  /** A scene on the canvas seen by the eye; null where there is no WebGL. `lost` is called when it goes away. */
  static open(canvas, eye, lost) {
    const back = document.createElement("canvas");
    const gl = back.getContext("webgl2", { antialias: false, depth: false, preserveDrawingBuffer: true });
    const painter = gl && new Painter(gl);
    if (!painter?.works) return null;
    Object.assign(back, { className: "space", ariaHidden: "true" });
    canvas.before(back);
    back.addEventListener("webglcontextlost", () => { if (back.isConnected) lost(); });
    return Object.assign(new Scene3D(canvas), { layers: [back, canvas], back, painter, eye });
  }

  close() {
    this.back.remove();
    this.painter.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  surroundings(swingAngle) {
    const { half, largest, long, reach, floor } = this, rise = long * (1 - Math.cos(swingAngle));
    const { wide, deep } = Object.assign(this, { wide: half + 0.9, deep: Math.max(2.5, largest + 0.9) });
    return [...box(wide, floor, long, deep), ...box(reach, rise - largest, rise + largest, largest),
      ...box(reach, floor - BASE, floor, largest), // shadows
      ...box(wide + BEYOND + 1.5, floor - BASE, floor, deep + BEYOND + 1.5)];
  }

  drawCradle(places, contacts, { space }) {
    const { canvas, back, lens, wide, deep, floor, long, painter, ratio } = this;
    const { offsetLeft, offsetTop, clientWidth, clientHeight } = canvas;
    const room = `left:${offsetLeft}px;top:${offsetTop}px;width:${clientWidth}px;height:${clientHeight}px`;
    if (this.room !== room) back.style.cssText = this.room = room;
    this.addBase(places, clientHeight);
    this.addAll(places, contacts);
    painter.paint([...lens.axes, lens.eye, [lens.focal, lens.x, clientHeight - lens.y], [wide, deep, floor, long],
      [BEYOND, BASE], ...space], clientWidth, clientHeight, ratio);
  }

  /** The base, and what darkens it: balls, and the feet of the bars. */
  addBase(places, height) {
    const { painter, lens, wide, deep, floor } = this;
    const add = (kind, thing, points) => {
      const [left, top, right, bottom] = lens.bounds(points);
      painter.add(kind, 2 * FAR, thing, IN_RECTANGLE, [left, height - bottom, right, height - top]);
    };
    add("STAND", [], box(wide + BEYOND + 2.5, floor - BASE, floor, deep + BEYOND + 2.5));
    const feet = [-wide, wide].flatMap((x) => [-deep, deep].map((z) => [x, floor + 0.2, z, 1.4 * BAR]));
    for (const thing of [...places.map(({ at }, i) => [...at, this.sizes[i]]), ...feet]) {
      const reach = 1.7 * (thing[1] - floor);
      add("SHADOW", thing, box(reach, 0, 0, reach).map((corner) => plus(corner, [thing[0], floor, thing[2]])));
    }
  }

  /** Frame, and balls with their strings, with how far they are from the eye. */
  addAll(places, contacts) {
    const { painter, sizes, rests, long, deep, lens: { eye } } = this;
    const from = (point) => Math.hypot(...minus(point, eye));
    for (const z of [-deep, deep]) {
      // In front of all balls; or behind them or, seen from the end of the row, beside them.
      const shift = eye[2] / z > 1 ? -FAR : FAR;
      for (const [a, b, bend] of this.bar(z))
        painter.add("ROD", shift + from(plus(a, minus(b, a), 0.5)), [...a, BAR], b, bend);
    }
    // A ball is as far as its horizon: an eyelet behind that is covered by it.
    const balls = places.map(({ at }, i) => Math.sqrt(from(at) ** 2 - (sizes[i] + EYELET) ** 2));
    places.forEach(({ at }, i) => {
      const hook = this.onString(i, at, sizes[i] + EYELET);
      const beside = (k, contact) => (places[k] ? [...places[k].at.slice(0, 2), sizes[k], contact.strength] : []);
      const metal = this.tints[i].map((part, k) => part * STEEL[k]);
      const others = [beside(i - 1, contacts[i - 1]), beside(i + 1, contacts[i])];
      painter.add("BALL", balls[i], [...at, sizes[i]], at, ...others, metal);
      painter.add("ROD", from(hook), [...this.onString(i, at, 0.96 * sizes[i]), 0.055], hook);
      for (const z of [-deep, deep])
        painter.add("ROD", from(hook), [...hook, STRING], [rests[i], long - 0.9 * BAR, z], [0, 0, 0, 1]);
    });
  }

  /** A bar on two posts, bent from one piece: from where to where straight pieces of it lead, and how they are bent. */
  bar(z) {
    const { wide, floor, long } = this, middle = wide - BEND, high = long - BEND;
    const bend = (side) => Array.from({ length: BEND_PIECES + 1 }, (_, k) => {
      const angle = (0.5 * Math.PI * k) / BEND_PIECES;
      return [side * (middle + BEND * Math.cos(angle)), high + BEND * Math.sin(angle), z];
    });
    const line = [[-wide, floor, z], ...bend(-1), ...bend(1).reverse(), [wide, floor, z]];
    const bentAt = (k, x) => (k % (BEND_PIECES + 1) ? [Math.sign(x) * middle, high, BEND] : []);
    return line.slice(1).map((to, k) => [line[k], to, bentAt(k, to[0])]);
  }
}
