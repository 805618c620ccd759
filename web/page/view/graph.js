// Strips: velocities, forces, energy and momentum by time, with axes, as far as a track knows them; see history.js.

import { line, prepared, rimmed, roundStep, thinned, withPrefix } from "#view/common.js";
import { ballColour, contactColour } from "#view/scene.js";
import { contactName, FONT } from "#view/texts.js";

export const SECONDS = 7; // s on the viewer's clock that are shown
export const UNITS = { velocity: "m/s", force: "N", energy: "J", momentum: "kg m/s" };
const LEAST = 11;        // px, the letters of axes and labels before they are laid out
const GUTTER = 6.6, FOOT = 1.5, LABEL = 1.2; // in their sizes: left of the curves, below them, and the line of a label
export const THIN = 520; // px: where it is not wider, titles are short
const NARROW = 1.5;    // px: a pulse that is not wider is a line as high as its peak
const PARTS = 4;       // of a scale, in which it goes below 0
const DASH = 5;        // px: where curves lie on each other, each one shows as long
export const FINE = [1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10]; // round numbers that a scale ends at

export class Graph {
  constructor(canvas) { Object.assign(this, { canvas, small: LEAST, gutter: GUTTER * LEAST }); }

  /** The time at this pixel between these sides. */
  timeAt(pixel, { left, right }) {
    const { gutter, canvas: { clientWidth: width } } = this;
    return left + (right - left) * Math.min(1, Math.max(0, (pixel - gutter) / (width - gutter)));
  }

  /** Draws these kinds of rows of `track`, from time `left` to `right`, with marks at `now` and, if it is not null, at
   *  `pointer`. Times are written from `origin` on, titles are so high (px), `most` and `lowest` tell values of a kind.
   *  Inside a `click`, its pulses are named. */
  draw(kinds, track, { left, right, now, pointer, titles, ...shown }) {
    const { context: c, width, height } = prepared(this.canvas, 2), tall = height / kinds.length;
    const small = parseFloat(getComputedStyle(this.canvas).fontSize);
    const gutter = GUTTER * small, scale = (width - gutter) / (right - left);
    if (width <= gutter || !height) return;
    const place = (time) => gutter + (time - left) * scale;
    Object.assign(this, { context: c, track, small, gutter });
    // Highest first, so that none hides another.
    const pulses = track.pulsesIn(left, right).sort((a, b) => b.peak - a.peak);
    const ofContacts = track.curves.force.map(() => []);
    for (const pulse of pulses) ofContacts[pulse.contact].push(pulse);
    const steps = kinds.includes("velocity") ? track.stepsAt(pulses) : [];
    const view = { left, right, width, place, pulses, ofContacts, steps, ...shown };
    kinds.forEach((kind, i) => {
      c.save();
      c.translate(0, i * tall);
      const named = kind === "force" && shown.click, title = titles[i] ?? 0, foot = tall - FOOT * small;
      const top = title + (named ? LABEL * small + 3 : 0.6 * small);
      const row = { ...view, title, top, foot, level: this.levels(kind, top, foot, shown) };
      c.save();
      this.drawRow(kind, row);
      c.restore();
      for (const [time, colour] of [[pointer, shown.theme.grid], [now, shown.theme.ink]])
        if (time !== null) line(c, [[place(time), title], [place(time), foot]], colour, 1.5);
      if (named) this.drawPairs(row);
      c.restore();
    });
  }

  drawRow(kind, view) {
    const { context: c, track } = this, { width, foot, theme } = view, stacked = kind === "energy";
    this.drawAxes(kind, view);
    c.beginPath();
    c.rect(this.gutter, 0, width - this.gutter, foot + 1);
    c.clip();
    if (kind === "force") return this.drawPulses(view);
    const curves = [...track.curves[kind].keys()].map((i) =>
      ({ points: this.points(kind, i, view), colour: colourOf(kind, i, track, theme), of: i }));
    if (stacked) for (const { points, colour } of curves.reverse()) line(c, points, colour, 1.6, 1, foot);
    else drawAll(c, curves, curves.length);
  }

  /** Where values of a kind are in a row between these heights: a function with its ends, `least` and `most`. */
  levels(kind, top, foot, { most: highest, lowest }) {
    const most = roundStep(highest(kind), FINE), part = most / PARTS;
    const least = -Math.min(most, part * Math.ceil(-lowest(kind) / part - 0.02));
    return Object.assign((value) => foot - ((value - least) / (most - least)) * (foot - top), { least, most });
  }

  /** Forces: each pulse in its contact's colour. */
  drawPulses({ left, right, pulses, ...view }) {
    const { context: c, track } = this, { place, level, foot, click, theme } = view;
    const colours = track.curves.force.map((_, contact) => colourOf("force", contact, track, theme));
    line(c, [[place(left), foot], [place(right), foot]], theme.soft);
    const filled = new Set(); // pixel columns, in which a lower one of the same contact would not be seen
    const lines = pulses.flatMap((pulse) => {
      const { contact: of, onset, release, at, peak } = pulse, colour = colours[of];
      const [x, end] = [at ?? onset, at ?? release].map(place), middle = 0.5 * (x + end);
      const column = `${of} ${Math.round(middle)}`, wide = end - x > NARROW;
      if (!wide && filled.has(column)) return [];
      filled.add(column);
      const points = wide ? track.shapeOf(pulse).map(([time, force]) => [place(time), level(force)])
        : [[middle, foot], [middle, level(peak)]];
      return [{ points, colour, of, opacity: wide && click ? 0.16 : 0 }];
    });
    drawAll(c, lines, colours.length, foot);
  }

  /** Grid lines with their values, and times below. */
  drawAxes(kind, { left, right, place, top, foot, width, level, origin, theme }) {
    const { context: c, small, gutter } = this, { least, most: highest } = level;
    const room = (foot - top) / (highest - least) * highest;
    const rows = room >= 44 ? [-1, -0.5, 0, 0.5, 1] : [-1, 0, 1];
    const style = { font: `${small}px ${FONT}`, textBaseline: "middle", fillStyle: theme.soft };
    for (const value of rows.map((part) => part * highest).filter((value) => value >= least)) {
      line(c, [[gutter, level(value)], [width, level(value)]], theme.grid);
      const text = withPrefix(value, UNITS[kind], 3, highest).replace(" kg", "\u2009kg");
      Object.assign(c, style, { textAlign: "right" }).fillText(text, gutter - 4, Math.max(top + 2, level(value)));
    }
    const step = roundStep((right - left) * 8 * small / (width - gutter));
    const most = Math.max(right - origin, origin - left);
    const digits = Math.ceil(Math.log10(most / step)) + 1;
    for (let k = Math.ceil((left - origin) / step - 1e-9); k * step <= right - origin; k++) {
      const x = place(k * step + origin);
      line(c, [[x, foot], [x, foot + 3]], theme.soft);
      if (x <= gutter + small || x >= width - 2 * small) continue;
      const text = withPrefix(k * step, "s", digits, most);
      Object.assign(c, style, { textAlign: "center" }).fillText(text, x, foot + 0.9 * small);
    }
  }

  /** A curve's points [px, px]: samples and, of a velocity, what is between them at pulses. */
  points(kind, i, { left, right, place, level, ofContacts, steps }) {
    const { track } = this, { times } = track, value = curveOf(track, kind, i);
    const sampled = (shown) => thinned(times, left, right, place, (k) => level(value(k)), shown);
    if (kind !== "velocity") return sampled();
    const coarse = [i - 1, i].flatMap((contact) => ofContacts[contact]?.filter(({ between }) => between) ?? []);
    const points = sampled((k) => !coarse.some(({ between: [before, after] }) => k > before && k < after));
    const all = [...steps[i].map(([time, speed]) => [place(time), level(speed)]), ...points].sort(([a], [b]) => a - b);
    return thinned(all.map(([x]) => x), -Infinity, Infinity, (x) => x, (k) => all[k][1]);
  }

  /** Labels each pulse with its balls, at its peak; pulses of the same instant together, where there is no room beside
   *  another label above that, with a line to the peak, as long as that is below the title. Nothing else is seen through
   *  labels. */
  drawPairs({ pulses, title, level, width, place, theme }) {
    if (pulses.length > 16) return;
    const { context: c, track, small, gutter } = this, placed = [], high = LABEL * small;
    Object.assign(c, { font: `600 ${small}px ${FONT}`, textAlign: "center", textBaseline: "bottom" });
    const labels = pulses.map((pulse) => ({ x: place(track.peakTime(pulse)), y: level(pulse.peak) - 2,
      contacts: [pulse.contact], colour: colourOf("force", pulse.contact, track, theme) }));
    labels.sort((a, b) => a.x - b.x);
    for (const label of labels) {
      const last = placed.at(-1);
      if (last && label.x - last.x < 1 && Math.abs(label.y - last.y) < high)
        Object.assign(last, { y: Math.min(label.y, last.y), colour: theme.ink,
          contacts: [...last.contacts, ...label.contacts].sort((a, b) => a - b) });
      else placed.push(label);
    }
    placed.forEach((label, i) => {
      label.peak = [label.x, label.y];
      label.text = label.contacts.map(contactName).join(", ");
      const half = 0.5 * c.measureText(label.text).width + 2;
      label.x = Math.max(gutter + half, Math.min(width - half, label.x));
      label.half = half;
      for (const other of placed.slice(0, i).sort((a, b) => b.y - a.y))
        if (Math.abs(other.x - label.x) < half + other.half && Math.abs(other.y - label.y) < high)
          label.y = other.y - high;
    });
    this.labels = placed.filter(({ y }) => y > title);
    for (const { peak: [x, foot], y, colour } of this.labels) if (y < foot) line(c, [[x, foot], [x, y]], colour);
    for (const { text, x, y, colour } of this.labels) rimmed(c, text, x, y, colour, theme.back);
  }
}

/** Draws lines {points, colour, of, opacity}: `of` which of so many curves they are. Where some lie on each other, each
 *  is seen in parts. */
function drawAll(c, lines, count, foot = 0) {
  for (const { points, colour, opacity } of lines) line(c, points, colour, 1.6, opacity, foot);
  if (count < 2) return;
  c.setLineDash([DASH, (count - 1) * DASH]);
  for (const { points, colour, of } of lines) {
    c.lineDashOffset = -of * DASH;
    line(c, points, colour, 1.6);
  }
  c.setLineDash([]);
}

/** The colour of curve `i` of this kind. */
export function colourOf(kind, i, { balls }, theme) {
  if (kind === "energy") return theme.energies[i];
  return kind === "momentum" ? theme.ink : (kind === "force" ? contactColour : ballColour)(i, balls, theme.dark);
}

/** A curve as it is drawn: its value at sample `k`. Energies lie on top of one another. */
function curveOf({ curves }, kind, i) {
  if (kind !== "energy") return (k) => curves[kind][i][k];
  const below = curves.energy.slice(0, i + 1);
  return (k) => below.reduce((sum, part) => sum + Math.max(0, part[k]), 0);
}
