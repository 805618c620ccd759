// The cradle, drawn: frame, strings, balls, and the glow of the forces between them.

import { prepared, shaded, through, withPrefix } from "#view/common.js";
import { FONT, say } from "#view/texts.js";

const LONGEST_STRING = 4.7, SHORTEST_STRING = 3.2; // lengths as drawn, in diameters of a ball
const SHORTER = 0.68; // the part of that which is left in a wide room
export const LARGEST = 110; // px, the radius of a ball
const AFTERGLOW = 0.5; // s on the viewer's clock that a contact shines after its pulse

/** Distinct colours for up to 20 balls: around the circle, the same lightness. */
export function ballColour(i, balls, dark) {
  return `oklch(${dark ? 0.78 : 0.52} 0.13 ${(25 + (330 * i) / Math.max(balls, 5)) % 360})`;
}

export class Scene {
  constructor(canvas) {
    Object.assign(this, { canvas, glow: [], sprites: new Map() });
  }

  /** The canvases that it draws on, from the one behind. */
  get layers() { return [this.canvas]; }

  close() {}

  /** Fits the picture into the canvas: where everything hangs. `near`: 0 for the whole cradle, 1 for the balls
   *  close by; `swingAngle` (rad): how far balls swing. */
  layout({ radius, ratio, length }, near = 0, swingAngle = 0.56) {
    // Never quite nothing, whatever is around it.
    const width = Math.max(60, this.canvas.clientWidth), height = Math.max(60, this.canvas.clientHeight);
    const sizes = ratio.map((mass) => Math.min(2.2, Math.max(0.35, Math.cbrt(mass)))); // of a radius
    const row = sizes.reduce((sum, size) => sum + 2 * size, 0), largest = Math.max(...sizes); // radii
    // Diameters. In a wide room strings are drawn shorter, so that the balls are larger.
    const drawn = Math.min(LONGEST_STRING, Math.max(SHORTEST_STRING, length / (2 * radius)))
      * Math.min(1, Math.max(SHORTER, height / width));
    // From afar: room for a swing to both sides, strings, balls and base. Close by: only for the balls and what is
    // above them.
    const swing = 2 * drawn * Math.sin(swingAngle), tall = 2 * drawn + 1.75 * largest + 0.9; // radii
    const far = Math.min(width / (row + 2 * swing + 1), (height - 8) / tall, LARGEST);
    const close = Math.max(far, Math.min(width / (row + 2.4), height / (7 * largest), LARGEST));
    const unit = far ** (1 - near) * close ** near, string = 2 * drawn * unit;
    const hanging = (1 - near) * (4 + (0.3 + 2 * drawn) * far + 0.45 * Math.max(0, height - 8 - far * tall))
      + near * (height - 2.3 * largest * close);
    let x = 0.5 * (width - row * unit);
    const positions = sizes.map((size) => (x += 2 * size * unit) - size * unit);
    const floor = hanging + 1.75 * largest * unit;
    Object.assign(this, { width, height, near, drawn, unit, string, top: hanging - string, floor, sizes, positions,
      length });
    return this;
  }

  /** Where ball `i` is on the canvas when its displacement is x (m), and how large `unit` is there (px). */
  place(i, x) {
    const { string, unit } = this, angle = x / this.length;
    return { x: this.positions[i] + string * Math.sin(angle), y: this.top + string * Math.cos(angle), unit };
  }

  /** The displacement (m) of ball `i` that is nearest to a point on the canvas. */
  displacement(i, { x, y }) { return this.length * Math.atan2(x - this.positions[i],
    Math.max(y - this.top, 0.15 * this.string)); }

  /** The ball at a point on the canvas, in front of others there, with a margin for fingers (px); -1 for none. */
  ballAt(point, state, margin = 0) {
    let best = -1, least = Infinity;
    for (let i = 0; i < this.positions.length; i++) {
      const { x, y, unit } = this.place(i, state.x[i]);
      const away = Math.hypot(x - point.x, y - point.y) - this.sizes[i] * unit, rank = away < 0 ? -unit : away;
      if (away < margin && rank < least) [best, least] = [i, rank];
    }
    return best;
  }

  /** The way on the canvas (px) from a place to one `radii` to the right. */
  ahead({ unit }, radii) { return { x: radii * unit, y: 0 }; }

  /** Where the balls i and i + 1 at these places touch, and how far apart they are, in the distance at which they
   *  do. */
  contact(i, a, b) {
    const from = this.sizes[i], reach = from + this.sizes[i + 1], part = from / reach;
    const away = Math.hypot(b.x - a.x, b.y - a.y) / (reach * this.unit) - 1;
    return { x: a.x + part * (b.x - a.x), y: a.y + part * (b.y - a.y), away };
  }

  /** Lets contacts shine: by their force now, or by what is left of their last pulses after `passed` s of the viewer's
   *  clock. */
  shine(state, pulses, strongest, passed) {
    const fade = Math.exp((-3 * passed) / AFTERGLOW);
    this.glow = Array.from(state.F, (force, i) => Math.max((this.glow[i] ?? 0) * fade, Math.max(0, force) / strongest));
    for (const { contact, peak } of pulses)
      this.glow[contact] = Math.max(this.glow[contact], Math.min(1, peak / strongest));
  }

  draw(state, options) {
    Object.assign(this, prepared(this.canvas, 2));
    const places = Array.from(state.x, (x, i) => this.place(i, x));
    this.drawCradle(places, options.theme);
    this.drawMarks(places, state, options);
  }

  drawCradle(places, theme) {
    this.drawFrame(theme);
    this.drawShadows(places, theme);
    this.drawStrings(places, theme);
    places.forEach((place, i) => this.drawBall(place, i, theme));
    this.drawGlow(places, theme);
  }

  /** What is no part of the cradle: rings around balls that are held or chosen, arrows, numbers. */
  drawMarks(places, state, { theme, labels, held, selected, arrows }) {
    const around = (i, gap, colour, width) =>
      ring(this.context, places[i], this.sizes[i] * places[i].unit + gap, colour, width);
    for (const i of held.keys()) around(i, 2.5, theme.accent, 2);
    if (arrows) this.drawArrows(places, state, arrows, theme);
    if (labels) this.drawLabels(places, theme);
    if (places[selected]) around(selected, 5, theme.focus, 3);
  }

  /** The rail, on posts that stand on a base. */
  drawFrame(theme) {
    const { context: c, unit, top, floor } = this, thick = Math.max(5, 0.2 * unit), edge = 1.9 * unit;
    const left = this.positions[0] - edge, right = this.positions.at(-1) + edge;
    const slab = (y, from, to, height, shades) => {
      c.fillStyle = shaded(c.createLinearGradient(0, y, 0, y + height), shades);
      c.beginPath();
      c.roundRect(from, y, to - from, height, Math.min(height / 2, 0.12 * unit));
      c.fill();
    };
    slab(floor, left - 0.7 * unit, right + 0.7 * unit, 0.42 * unit, theme.base);
    for (const x of [left, right]) {
      c.fillStyle = shaded(c.createLinearGradient(x - thick / 2, 0, x + thick / 2, 0), theme.rail);
      c.fillRect(x - thick / 2, top - 0.5 * thick, thick, floor - top + 0.5 * thick);
    }
    slab(top - thick, left - thick / 2, right + thick / 2, thick, theme.rail);
  }

  /** A soft shadow for each ball on what the cradle stands on. */
  drawShadows(places, theme) {
    const { context: c, unit, string, top } = this, none = theme.shadow.replace(/[\d.]+\)$/, "0)");
    places.forEach(({ x, y }, i) => {
      const up = Math.max(0, (top + string - y) / string), wide = this.sizes[i] * unit * (1.15 + up);
      c.save();
      c.translate(x, this.floor + 0.1 * unit);
      c.scale(1, 0.13);
      c.globalAlpha = Math.max(0.15, 1 - 1.6 * up);
      disc(c, 0, 0, wide, shaded(c.createRadialGradient(0, 0, 0, 0, 0, wide), [theme.shadow, none]));
      c.restore();
    });
  }

  drawStrings(places, theme) {
    const { context: c, unit, top } = this;
    c.lineWidth = Math.max(1, 0.028 * unit);
    c.strokeStyle = theme.string;
    places.forEach(({ x, y }, i) => {
      const rest = this.positions[i], size = this.sizes[i] * unit, angle = Math.atan2(x - rest, y - top);
      const high = top - 0.04 * unit;
      const eye = [x - size * Math.sin(angle), y - size * Math.cos(angle)];
      through(c, [[rest - 0.16 * unit, high], eye, [rest + 0.16 * unit, high]]).stroke();
    });
  }

  drawBall(place, i, theme) {
    const { context: c, ratio } = this, radius = this.sizes[i] * this.unit;
    const key = `${theme.dark} ${radius.toFixed(2)} ${ratio}`;
    let sprite = this.sprites.get(key);
    if (!sprite) {
      if (this.sprites.size > 60) this.sprites.clear();
      this.sprites.set(key, (sprite = ballSprite(radius, ratio, theme)));
    }
    c.drawImage(sprite, place.x - radius - 2, place.y - radius - 2, 2 * radius + 4, 2 * radius + 4);
  }

  drawGlow(places, theme) {
    const { context: c, unit } = this;
    c.save();
    c.globalCompositeOperation = theme.glowMode;
    this.glow.forEach((glow, i) => {
      if (glow < 0.004 || !places[i + 1]) return;
      // What has parted does not shine any more.
      const { x, y, away } = this.contact(i, places[i], places[i + 1]);
      const strength = Math.sqrt(glow) * Math.max(0, 1 - 4 * away);
      if (strength <= 0.05) return;
      const radius = unit * (0.35 + 1.15 * strength), inner = [0, theme.glow(Math.min(1, 0.25 + strength))];
      disc(c, x, y, radius, shaded(c.createRadialGradient(x, y, 0, x, y, radius),
        [inner, [0.25, theme.glow(0.55 * strength)], [1, theme.glow(0)]]));
    });
    c.restore();
  }

  /** Velocities as arrows below the balls; the longest is `arrows` m/s. */
  drawArrows(places, state, fastest, theme) {
    const { context: c } = this;
    places.forEach((place, i) => {
      const { unit } = place, way = this.ahead(place, (1.75 * state.v[i]) / fastest), long = Math.hypot(way.x, way.y);
      if (long < 1.5) return;
      c.save();
      c.translate(place.x, place.y + (this.sizes[i] + 0.32) * unit);
      c.rotate(Math.atan2(way.y, way.x));
      c.strokeStyle = c.fillStyle = ballColour(i, places.length, theme.dark);
      c.lineWidth = Math.max(2, 0.085 * unit);
      const head = Math.min(long, 0.24 * unit), half = 0.13 * unit;
      through(c, [[0, 0], [long - 0.7 * head, 0]]).stroke();
      through(c, [[long, 0], [long - head, -half], [long - head, half]]).fill();
      c.restore();
    });
  }

  drawLabels(places, theme) {
    const { context: c } = this;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillStyle = theme.label;
    places.forEach(({ x, y, unit }, i) => {
      c.font = `600 ${Math.max(10, 0.42 * unit)}px ${FONT}`;
      c.fillText(String(i + 1), x, y + 0.02 * unit);
    });
  }
}

/** Fills a circle. */
function disc(c, x, y, radius, fill) {
  c.fillStyle = fill;
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.fill();
}

/** Draws a circle around a place. */
function ring(c, { x, y }, radius, colour, width) {
  c.strokeStyle = colour;
  c.lineWidth = width;
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.stroke();
}

/** A polished ball, drawn once for each size. */
function ballSprite(r, ratio, theme) {
  const size = Math.ceil((2 * r + 4) * ratio);
  const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const c = canvas.getContext("2d");
  c.scale(ratio, ratio);
  c.translate(r + 2, r + 2);
  c.beginPath();
  c.arc(0, 0, r, 0, 2 * Math.PI);
  c.clip();
  const cover = (gradient, stops) => {
    c.fillStyle = shaded(gradient, stops);
    c.fillRect(-r, -r, 2 * r, 2 * r);
  };
  // What a polished ball mirrors: the sky above, a horizon, the table below.
  cover(c.createLinearGradient(0, -r, 0, r), theme.ball);
  const rim = [[0, "rgba(0, 0, 0, 0)"], [0.72, "rgba(0, 0, 0, 0.06)"], [1, theme.rim]];
  cover(c.createRadialGradient(-0.18 * r, -0.25 * r, 0.35 * r, 0, 0, r), rim);
  const light = [[0, "rgba(255, 255, 255, 0.95)"], [0.25, "rgba(255, 255, 255, 0.45)"], [1, "rgba(255, 255, 255, 0)"]];
  cover(c.createRadialGradient(-0.36 * r, -0.46 * r, 0, -0.36 * r, -0.46 * r, 0.55 * r), light);
  return canvas;
}

// ---- microscopes above the contacts: the gap between two balls, or how far they are pressed together, in micrometres

/** Draws a lens for each contact; `reach` (m) is half of what it shows. */
export function drawLenses(scene, state, { reach, theme, opacity }) {
  const { context: c, unit } = scene;
  const touches = Array.from(state.F, (_, i) =>
    scene.contact(i, scene.place(i, state.x[i]), scene.place(i + 1, state.x[i + 1])));
  const apart = touches.slice(1).map(({ x, y }, i) => Math.hypot(x - touches[i].x, y - touches[i].y));
  const radius = Math.min(0.9 * unit, 84, 0.48 * Math.min(...apart));
  if (radius < 15 || opacity <= 0) return;
  c.save();
  c.globalAlpha = opacity;
  touches.forEach((touch, i) => {
    const gap = -state.overlap[i]; // m until the law acts; negative while it does
    if (touch.away > 0.25) return;
    const centre = { x: touch.x, y: touch.y - Math.max(...scene.sizes) * unit - radius - 0.55 * unit };
    c.strokeStyle = theme.lensLine;
    c.lineWidth = 1;
    through(c, [[touch.x, touch.y], [centre.x, centre.y + radius]]).stroke();
    drawLens(c, centre, radius, gap / reach, Math.max(0, state.F[i]), theme);
    c.fillStyle = gap < 0 ? theme.accent : theme.ink; // pressed, or apart
    const size = Math.max(10, Math.min(15, 0.3 * unit));
    c.font = `600 ${size}px ${FONT}`;
    c.textAlign = "center";
    c.textBaseline = "alphabetic";
    if (radius < 22) return;
    c.fillText(say(gap < 0 ? "lensPressed" : "lensGap"), centre.x, centre.y - radius - 6 - 1.2 * size);
    c.fillText(withPrefix(Math.abs(gap), "m", 2), centre.x, centre.y - radius - 6);
  });
  c.restore();
}

/** One lens: `gap` in its half widths, drawn so that one half width is half of its radius. What is farther apart is out
 *  of its sight. */
function drawLens(c, { x, y }, radius, gap, force, theme) {
  c.save();
  disc(c, x, y, radius, theme.lens);
  c.clip();
  const shift = 0.5 * gap * radius, bend = 2.6 * radius;
  // Two surfaces that bulge towards each other; where they overlap, they flatten.
  for (const side of [-1, 1]) {
    const face = x + side * Math.max(0, 0.5 * shift), centre = face + side * bend;
    disc(c, centre, y, bend, shaded(c.createLinearGradient(face, y, face + side * radius, y), theme.lensBall));
  }
  if (shift < 0) {
    // The patch that is pressed: as high as the chord in which the undeformed surfaces would overlap.
    const depth = -0.5 * shift, half = Math.min(0.8 * radius, Math.sqrt(2 * bend * depth)), width = 2 + 0.5 * depth;
    if (force > 0) {
      c.fillStyle = shaded(c.createRadialGradient(x, y, 0, x, y, half + 8), [theme.glow(0.95), theme.glow(0)]);
      c.beginPath();
      c.ellipse(x, y, width + 0.4 * half, half + 8, 0, 0, 2 * Math.PI);
      c.fill();
    }
    c.fillStyle = theme.patch;
    c.beginPath();
    c.roundRect(x - width / 2, y - half, width, 2 * half, width / 2);
    c.fill();
  }
  c.restore();
  ring(c, { x, y }, radius, theme.lensLine, 1.5);
}
