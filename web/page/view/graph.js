// Strips: velocities, forces, energy and momentum by time, with axes, as far as a track knows them; see history.js.

import { countUpTo, line, prepared, roundStep, thinned, withPrefix } from "#view/common.js";
import { ballColour } from "#view/scene.js";
import { FONT } from "#view/texts.js";

export const SECONDS = 7; // s on the viewer's clock that are shown
export const UNITS = { velocity: "m/s", force: "N", energy: "J", momentum: "kg m/s" };
const GUTTER = 66;     // px for the values on the axis, left of the curves
const TITLE = 1.8, FOOT = 17; // above the curves of a row, in sizes of its letters; px below them
const THIN = 520, LINE = 1; // px: where it is not wider, values take a second line, in sizes of letters
const NARROW = 4;      // px: a pulse that is not wider is a line as high as its peak
export const FINE = [1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10]; // round numbers that a scale ends at

export class Graph {
  constructor(canvas) { this.canvas = canvas; }

  /** The time at this pixel between these sides. */
  timeAt(pixel, { left, right }) {
    return left + (right - left) * Math.min(1, Math.max(0, (pixel - GUTTER) / (this.canvas.clientWidth - GUTTER)));
  }

  /** Draws these kinds of rows of `track`, from time `left` to `right`, with marks at `now` and, if it is not null, at
   *  `pointer`. Times are written from `origin` on. Inside a `click`, its scales and names of its pulses. */
  draw(kinds, track, { left, right, now, pointer, ...shown }) {
    const { context: c, width, height } = prepared(this.canvas, 2), tall = height / kinds.length;
    if (width <= GUTTER || !height) return;
    const { times } = track, scale = (width - GUTTER) / (right - left);
    const title = parseFloat(getComputedStyle(this.canvas).fontSize) * (width > THIN ? TITLE : TITLE + LINE);
    const place = (time) => GUTTER + (time - left) * scale;
    Object.assign(this, { context: c, track });
    const pulses = track.pulsesIn(left, right).map(({ contact, onset, release, peak }) => ({ contact, release, peak,
      x: place(0.5 * (onset + release)), narrow: (release - onset) * scale < NARROW,
      before: countUpTo(times, onset) - 1 })); // the last sample that knows nothing of it
    const view = { left, right, width, place, pulses, ...shown };
    kinds.forEach((kind, i) => {
      c.save();
      c.translate(0, i * tall);
      this.drawRow(kind, { ...view, top: title + (kind === "force" && shown.click ? 16 : 0), foot: tall - FOOT });
      for (const [time, colour] of [[pointer, shown.theme.grid], [now, shown.theme.accent]])
        if (time !== null) line(c, [[place(time), title], [place(time), tall - FOOT]], colour, 1.5);
      c.restore();
    });
  }

  drawRow(kind, view) {
    const { context: c, track } = this, { width, top, foot, click, theme } = view, stacked = kind === "energy";
    const most = roundStep(click?.most[kind] ?? track.most[kind], FINE);
    const least = ["velocity", "momentum"].includes(kind) ? -most : 0;
    const level = (value) => foot - ((value - least) / (most - least)) * (foot - top);
    this.drawAxes(kind, { ...view, level, least, most });
    c.beginPath();
    c.rect(GUTTER, 0, width - GUTTER, foot + 1);
    c.clip();
    const curves = [...track.curves[kind].keys()], filled = stacked ? 1 : click && kind === "force" ? 0.16 : 0;
    for (const i of stacked ? curves.reverse() : curves)
      line(c, this.points(kind, i, { ...view, level }), colourOf(kind, i, track, theme), 1.6, filled, foot);
    if (kind !== "force") return;
    for (const { x, peak } of view.pulses.filter(({ narrow }) => narrow))
      line(c, [[x, foot], [x, level(peak)]], theme.spike, 2);
    if (click) this.drawPairs({ ...view, level });
  }

  /** Grid lines with their values, and times below. */
  drawAxes(kind, { left, right, place, top, foot, width, level, least, most, origin, theme }) {
    const { context: c } = this, rows = (foot - top) / (most - least) * most >= 44 ? [-1, -0.5, 0, 0.5, 1] : [-1, 0, 1];
    const style = { font: `11px ${FONT}`, textBaseline: "middle", fillStyle: theme.soft };
    for (const value of rows.map((part) => part * most).filter((value) => value >= least)) {
      line(c, [[GUTTER, level(value)], [width, level(value)]], theme.grid);
      const text = withPrefix(value, UNITS[kind], 3, most).replace(" kg", "\u2009kg");
      Object.assign(c, style, { textAlign: "right" }).fillText(text, GUTTER - 4, Math.max(top + 2, level(value)));
    }
    const step = roundStep((right - left) * 90 / (width - GUTTER));
    for (let k = Math.ceil((left - origin) / step - 1e-9); k * step <= right - origin; k++) {
      const x = place(k * step + origin);
      line(c, [[x, foot], [x, foot + 3]], theme.soft);
      if (x <= GUTTER + 12 || x >= width - 22) continue;
      Object.assign(c, style, { textAlign: "center" }).fillText(withPrefix(k * step, "s", 4), x, foot + 10);
    }
  }

  /** A curve's points; a velocity jumps where a pulse lies between two samples. */
  points(kind, i, { left, right, place, level, pulses }) {
    const { times } = this.track, value = curveOf(this.track, kind, i), jumps = new Map();
    const points = thinned(times, left, right, place, (k) => level(value(k)));
    for (const { contact, release, before, x } of kind === "velocity" ? pulses : [])
      if ((contact === i || contact === i - 1) && release <= times[before + 1]) jumps.set(before, x);
    for (const [k, x] of jumps) points.push([x, level(value(k))], [x, level(value(k + 1))]);
    return jumps.size ? points.sort(([a], [b]) => a - b) : points;
  }

  /** Labels each pulse with its balls, at its peak. */
  drawPairs({ pulses, level, width, theme }) {
    if (pulses.length > 16) return;
    const { context: c, track } = this;
    Object.assign(c, { font: `600 11px ${FONT}`, textAlign: "center", textBaseline: "bottom" });
    const labels = pulses.map(({ contact, peak, x }) => ({ x, y: level(peak) - 2, contact,
      text: `${contact + 1}–${contact + 2}`, colour: colourOf("force", contact, track, theme) }));
    labels.sort((a, b) => a.x - b.x || a.contact - b.contact);
    labels.forEach(({ x, y, text, colour }, i) => {
      const next = labels[i + 1];
      // Pulses at the same time have one label.
      if (next?.x - x < 30) {
        Object.assign(next, { x: 0.5 * (x + next.x), y: Math.min(y, next.y), text: `${text}, ${next.text}`,
          colour: theme.ink });
      } else {
        c.fillStyle = colour;
        c.fillText(text, Math.max(GUTTER + 16, Math.min(width - 20, x)), y);
      }
    });
  }
}

/** The colour of curve `i` of this kind. */
export function colourOf(kind, i, { balls }, theme) {
  return kind === "momentum" ? theme.ink : kind === "energy" ? theme.energies[i] : ballColour(i, balls, theme.dark);
}

/** A curve as it is drawn: its value at sample `k`. Energies lie on top of one another. */
function curveOf({ curves }, kind, i) {
  if (kind !== "energy") return (k) => curves[kind][i][k];
  const below = curves.energy.slice(0, i + 1);
  return (k) => below.reduce((sum, part) => sum + Math.max(0, part[k]), 0);
}
