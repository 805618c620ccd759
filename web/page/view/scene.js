// The cradle, drawn: frame, strings, balls, and the glow of the forces between them.

import { circle, prepared, RIM, rimmed, shaded, through } from "#view/common.js";
import { box, Lens, minus, plus } from "#view/eye.js";
import { FONT } from "#view/texts.js";

const LONGEST_STRING = 4.7, SHORTEST_STRING = 3.2; // lengths as drawn, in diameters of a ball
const MARGIN = 12, CLOSE_MARGIN = 3; // px around what is shown, from afar and close by
const SHORTER = 0.5; // the least factor by which strings are shortened on a wide canvas
const AHEAD = { axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }; // an eye that sees all flat
const FADE = 24; // px at the top in which what is cut off there fades
const LARGEST = 110; // px, the radius of a ball
export const SMALL = 11; // px, the least letters
const SHORTEST_ARROW = 4; // px
const NARROWEST = 0.4; // part of its length in which a row is seen at least by a hand along it
const AFTERGLOW = 0.12; // s on the viewer's clock that a contact shines after its pulse
const SEEN = 2;         // px: a gap as wide as that is seen, and nothing shines across it

/** How balls look by the ratio of their Young's modulus to that of steel: the largest of each metal, and its parts of
 *  red, green and blue: as lead is, brass, steel, and what is stiffer. */
const PLAIN = [1, 1, 1];
const METALS = [[0.3, [0.5, 0.53, 0.62]], [0.8, [1, 0.8, 0.42]], [1.3, PLAIN], [Infinity, [0.68, 0.7, 0.78]]];

/** Distinct colours for up to 20 balls: around the circle, the same lightness. */
export function ballColour(i, balls, dark) {
  return `oklch(${dark ? 0.78 : 0.52} 0.13 ${(25 + (330 * i) / Math.max(balls, 5)) % 360})`;
}

/** Of the contact between balls `i` and `i` + 1: a colour between theirs. */
export function contactColour(i, balls, dark) { return ballColour(i + 0.5, balls, dark); }

export class Scene {
  constructor(canvas) {
    // `layers`: the canvases that it draws on, from the one behind.
    Object.assign(this, { canvas, layers: [canvas], glow: [], eye: AHEAD });
  }

  close() {}

  /** Fits the picture into the canvas: where everything hangs. `near`: 0 for the whole cradle, 1 for the balls
   *  close by; `swingAngle` (rad): how far balls swing. */
  layout({ radius, sizes: radii, moduli, length, swing }, near = 0, swingAngle = 0.56) {
    // At least 60 px, however small the canvas is.
    const width = Math.max(60, this.canvas.clientWidth), height = Math.max(60, this.canvas.clientHeight);
    const sizes = radii.map((size) => Math.min(2.2, Math.max(0.35, size))); // of a radius
    const half = sizes.reduce((sum, size) => sum + size, 0), largest = Math.max(...sizes);
    // On a wide canvas, strings are drawn shorter, so that the balls are larger.
    const long = 2 * Math.min(LONGEST_STRING, Math.max(SHORTEST_STRING, length / (2 * radius)))
      * Math.min(1, Math.max(SHORTER, height / width));
    const reach = half + long * Math.sin(swingAngle), floor = -1.75 * largest;
    let x = -half;
    const rests = sizes.map((size) => (x += 2 * size) - size);
    const tints = sizes.map((_, i) => METALS.find(([stiffest]) => (moduli?.[i] ?? 1) <= stiffest)[1]);
    Object.assign(this, { sizes, tints, half, largest, long, reach, floor, rests, swing, near });
    const all = this.surroundings(swingAngle), distance = 2.7 * Math.max(...all.map((point) => Math.hypot(...point)));
    const lens = new Lens(this.eye.axes, distance), far = lens.bounds(all);
    const close = lens.bounds(box(half + 1.2, floor - 0.45, Math.min(4.9 * largest, long + 0.3), 0));
    const part = far.map((edge, k) => edge + near * (close[k] - edge));
    lens.fit(part, far, width, height, MARGIN - near * (MARGIN - CLOSE_MARGIN), LARGEST);
    return Object.assign(this, { lens, unit: lens.focal / distance });
  }

  /** Points that a view from afar must contain: a swing to both sides, strings, balls and base. */
  surroundings() { return box(this.reach, this.floor - 0.5, this.long + 0.2, 0); }

  /** Place of ball `i` at the displacement x (m), in space (radii: right, up, towards the viewer) and on the canvas. */
  place(i, x) {
    const { rests, long } = this, angle = this.swing.angle(x);
    return this.lens.place([rests[i] + long * Math.sin(angle), long * (1 - Math.cos(angle)), 0]);
  }

  places({ x }) { return Array.from(x, (away, i) => this.place(i, away)); }

  /** The point on the string of ball `i`, which is `at`, this many radii from the ball's middle. */
  onString(i, at, radii) { return plus(at, minus([this.rests[i], this.long, 0], at), radii / this.long); }

  /** The displacement (m) of ball `i` that is nearest to a point on the canvas. A row that is seen end on is pulled
   *  as if somewhat from aside. */
  displacement(i, { x, y }) {
    const { unit, long, lens: { axes: [[along]] } } = this;
    const aside = unit * long * (along < 0 ? -1 : 1) * Math.max(0, NARROWEST - Math.abs(along));
    const away = (angle) => {
      const place = this.place(i, this.swing.deflection(angle));
      return Math.hypot(place.x + aside * angle - x, place.y - y);
    };
    let best = 0;
    for (let step = Math.PI / 4; step > 1e-9; step /= 2)
      for (const angle of [best - step, best + step]) if (away(angle) < away(best)) best = angle;
    return this.swing.deflection(best);
  }

  /** The ball at a point on the canvas, in front of others there, with a margin for fingers (px); -1 for none. */
  ballAt(point, state, margin = 0) {
    const ranks = this.places(state).map(({ x, y, unit }, i) => {
      const away = Math.hypot(x - point.x, y - point.y) - this.sizes[i] * unit;
      return away < 0 ? -unit : away;
    });
    const least = Math.min(...ranks);
    return least < margin ? ranks.indexOf(least) : -1;
  }

  /** Contacts as they are seen, with how far apart the balls are, relative to the distance between
   *  centres at which they touch, and how much the contact shines. */
  contacts(places) {
    return places.slice(1).map((right, i) => {
      const left = places[i].at, way = minus(right.at, left), touching = this.sizes[i] + this.sizes[i + 1];
      const away = Math.hypot(...way) / touching - 1;
      const place = this.lens.place(plus(left, way, this.sizes[i] / touching));
      const closed = Math.min(1, Math.max(0, 1 - (away * touching * place.unit) / SEEN));
      return { ...place, away, strength: Math.sqrt(this.glow[i] ?? 0) * closed };
    });
  }

  /** Lets contacts shine by their force now, as a part of the `strongest`. Where clicks pass too fast to be seen, they
   *  flash: by the last pulses, `passed` s of the viewer's clock after the last picture. 0: forces are seen as they are,
   *  because time stands still or slows at a click. */
  shine(state, pulses, strongest, passed) {
    const fade = passed > 0 ? Math.exp((-3 * passed) / AFTERGLOW) : 0;
    this.glow = Array.from(state.F, (force, i) => Math.max((this.glow[i] ?? 0) * fade, Math.max(0, force) / strongest));
    if (passed > 0) for (const { contact, peak } of pulses)
      this.glow[contact] = Math.max(this.glow[contact], Math.min(1, peak / strongest));
  }

  draw(state, { theme, labels, held, selected, arrows }) {
    Object.assign(this, prepared(this.canvas, 2));
    const places = this.places(state), contacts = this.contacts(places);
    this.drawCradle(places, contacts, theme);
    this.drawGlow(contacts, theme);
    // Added to the cradle: rings around balls that are held or chosen, arrows, numbers.
    const around = (i, gap, colour, width) =>
      circle(this.context, places[i], this.sizes[i] * places[i].unit + gap, colour, width);
    for (const i of held.keys()) around(i, 2.5, theme.accent, 2);
    if (arrows) this.drawArrows(places, state, arrows, theme);
    if (labels) this.drawLabels(places, theme);
    if (places[selected]) around(selected, 5, theme.focus, 3);
  }

  drawCradle(places, contacts, theme) {
    this.drawFrame(theme);
    this.drawShadows(places, theme);
    this.drawStrings(places, theme);
    this.fadeTop();
    places.forEach((place, i) => this.drawBall(place, this.sizes[i] * this.unit, this.tints[i], theme));
  }

  /** A tube, brighter along its middle, on a base. */
  drawFrame(theme) {
    const { context: c, unit, half, long, floor } = this, thick = Math.max(5, 0.2 * unit), deep = 0.42 * unit;
    const { x: left, y: top } = this.lens.place([-half - 0.9, long, 0]);
    const { x: right, y: foot } = this.lens.place([half + 0.9, floor, 0]);
    c.lineJoin = "round";
    theme.rail.forEach((shade, k) => {
      Object.assign(c, { strokeStyle: shade, lineWidth: thick * (1 - 0.36 * k) });
      through(c, [[left, foot], [left, top], [right, top], [right, foot]]).stroke();
    });
    c.fillStyle = shaded(c.createLinearGradient(0, foot, 0, foot + deep), theme.base);
    this.base = new Path2D();
    this.base.roundRect(left - 0.7 * unit, foot, right - left + 1.4 * unit, deep, 0.12 * unit);
    c.fill(this.base);
  }

  /** Close by, what is cut off at the top fades there. */
  fadeTop() {
    const { context: c, near, canvas: { clientWidth } } = this;
    c.globalCompositeOperation = "destination-out";
    c.fillStyle = shaded(c.createLinearGradient(0, 0, 0, FADE), [`rgba(0, 0, 0, ${near})`, "rgba(0, 0, 0, 0)"]);
    c.fillRect(0, 0, clientWidth, FADE);
    c.globalCompositeOperation = "source-over";
  }

  /** A soft shadow for each ball on the base. */
  drawShadows(places, theme) {
    const { context: c, unit } = this;
    c.save();
    c.clip(this.base);
    places.forEach(({ at, x }, i) => {
      const up = at[1] / this.long, wide = this.sizes[i] * unit * (1.15 + up);
      c.save();
      c.translate(x, this.lens.place([0, this.floor - 0.1, 0]).y);
      c.scale(1, 0.13);
      c.globalAlpha = Math.max(0.15, 1 - 1.6 * up);
      const fill = shaded(c.createRadialGradient(0, 0, 0, 0, 0, wide), [theme.shadow, "transparent"]);
      circle(c, { x: 0, y: 0 }, wide, fill);
      c.restore();
    });
    c.restore();
  }

  drawStrings(places, theme) {
    const { context: c, rests, long, sizes } = this;
    Object.assign(c, { lineWidth: Math.max(1, 0.028 * this.unit), strokeStyle: theme.string });
    places.forEach(({ at }, i) => {
      const points = [[rests[i] - 0.16, long, 0], this.onString(i, at, sizes[i]), [rests[i] + 0.16, long, 0]];
      through(c, points.map((point) => this.lens.place(point)).map(({ x, y }) => [x, y])).stroke();
    });
  }

  /** A polished ball of this tint. */
  drawBall(place, r, tint, theme) {
    const { context: c } = this, { x, y } = place, white = (part) => `rgba(255, 255, 255, ${part})`;
    const cover = (gradient, stops) => circle(c, place, r, shaded(gradient, stops));
    // What it mirrors: the sky above, a horizon, the table below.
    cover(c.createLinearGradient(0, y - r, 0, y + r), theme.ball);
    cover(c.createRadialGradient(x - 0.18 * r, y - 0.25 * r, 0.35 * r, x, y, r),
      [[0, "rgba(0, 0, 0, 0)"], [0.72, "rgba(0, 0, 0, 0.06)"], [1, theme.rim]]);
    if (tint !== PLAIN) {
      c.globalCompositeOperation = "multiply";
      circle(c, place, r, `rgb(${tint.map((part) => Math.round(255 * part))})`);
      c.globalCompositeOperation = "source-over";
    }
    const left = x - 0.36 * r, high = y - 0.46 * r;
    cover(c.createRadialGradient(left, high, 0, left, high, 0.55 * r),
      [[0, white(0.95)], [0.25, white(0.45)], [1, white(0)]]);
  }

  drawGlow(contacts, theme) {
    const { context: c, lens: { eye } } = this;
    c.globalCompositeOperation = theme.glowMode;
    for (const { at, x, y, unit, strength } of contacts.filter((contact) => contact.strength > 0)) {
      // The balls themselves hide it from who looks along the row.
      const view = minus(eye, at), seen = strength * Math.hypot(view[1], view[2]) / Math.hypot(...view);
      const radius = unit * (0.35 + 1.15 * strength), parts = [Math.min(1, 1.4 * seen), 0.42 * seen, 0.1 * seen, 0];
      const glow = shaded(c.createRadialGradient(x, y, 0, x, y, radius), parts.map((part) => theme.glow(part)));
      circle(c, { x, y }, radius, glow);
    }
    c.globalCompositeOperation = "source-over";
  }

  /** Velocities as arrows below the balls, so long for the `fastest` (m/s), with a rim against what is behind them; the
   *  first of the longest has the name v. */
  drawArrows(places, state, fastest, theme) {
    const { context: c } = this, speeds = Array.from(state.v, Math.abs), named = speeds.indexOf(Math.max(...speeds));
    places.forEach((place, i) => {
      const { at, x, y, unit } = place, end = this.lens.place(plus(at, [1, 0, 0], (1.75 * state.v[i]) / fastest));
      const long = Math.hypot(end.x - x, end.y - y), size = Math.max(SMALL, 0.34 * unit);
      const head = Math.min(long, 0.3 * unit), neck = long - head, half = 0.55 * head;
      const thin = Math.min(half, Math.max(1, 0.05 * unit));
      if (long < SHORTEST_ARROW) return;
      c.save();
      c.translate(x, y + (this.sizes[i] + 0.36) * unit);
      c.rotate(Math.atan2(end.y - y, end.x - x));
      Object.assign(c, { fillStyle: theme.ink, strokeStyle: theme.back, lineWidth: RIM, lineJoin: "round" });
      through(c, [[0, -thin], [neck, -thin], [neck, -half], [long, 0], [neck, half], [neck, thin], [0, thin]]);
      c.closePath();
      c.stroke();
      c.fill();
      c.translate(long + 0.6 * size, 0);
      if (end.x < x) c.rotate(Math.PI); // upright again
      Object.assign(c, { font: `italic ${size}px ${FONT}`, textAlign: "center", textBaseline: "middle" });
      if (i === named) rimmed(c, "v", 0, 0, theme.ink, theme.back);
      c.restore();
    });
  }

  /** Numbers on the balls whose middle is not hidden by others. */
  drawLabels(places, theme) {
    const { context: c } = this;
    Object.assign(c, { textAlign: "center", textBaseline: "middle", fillStyle: theme.label, strokeStyle: theme.halo,
      lineJoin: "round" });
    places.forEach(({ x, y, unit }, i) => {
      if (places.some((other, k) => other.unit > 1.001 * unit
        && Math.hypot(other.x - x, other.y - y) < 0.9 * this.sizes[k] * other.unit)) return;
      Object.assign(c, { font: `600 ${Math.max(10, 0.42 * unit)}px ${FONT}`, lineWidth: 0.07 * unit });
      c.strokeText(String(i + 1), x, y + 0.02 * unit);
      c.fillText(String(i + 1), x, y + 0.02 * unit);
    });
  }
}
