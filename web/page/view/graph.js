// Strips: velocities, forces, energy and momentum by time, with axes, as far as a track knows them; see history.js.

import { line, prepared, roundStep, thinned, withPrefix } from "#view/common.js";
import { ballColour } from "#view/scene.js";
import { FONT } from "#view/texts.js";

export const SECONDS = 7; // s on the viewer's clock that are shown
export const UNITS = { velocity: "m/s", force: "N", energy: "J", momentum: "kg m/s" };
const SMALL = 0.72, LEAST = 11; // of the page's letters, px: those of axes and labels
const GUTTER = 6, FOOT = 1.5, LABEL = 1.2; // in their sizes: left of the curves, below them, and the line of a label
const TITLE = 1.8;     // above the curves of a row, in sizes of the page's letters
export const THIN = 520; // px: where it is not wider, values take a second line,
const LINE = 1;          // in sizes of letters
const NARROW = 1.5;    // px: a pulse that is not wider is a line as high as its peak
export const FINE = [1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10]; // round numbers that a scale ends at

export class Graph {
  constructor(canvas) { Object.assign(this, { canvas, small: LEAST, gutter: GUTTER * LEAST }); }

  /** The time at this pixel between these sides. */
  timeAt(pixel, { left, right }) {
    const { gutter, canvas: { clientWidth: width } } = this;
    return left + (right - left) * Math.min(1, Math.max(0, (pixel - gutter) / (width - gutter)));
  }

  /** Draws these kinds of rows of `track`, from time `left` to `right`, with marks at `now` and, if it is not null, at
   *  `pointer`. Times are written from `origin` on. Inside a `click`, its scales and names of its pulses. */
  draw(kinds, track, { left, right, now, pointer, ...shown }) {
    const { context: c, width, height } = prepared(this.canvas, 2), tall = height / kinds.length;
    const letters = parseFloat(getComputedStyle(this.canvas).fontSize), small = Math.max(LEAST, SMALL * letters);
    const gutter = GUTTER * small, scale = (width - gutter) / (right - left);
    if (width <= gutter || !height) return;
    const place = (time) => gutter + (time - left) * scale, title = letters * (width > THIN ? TITLE : TITLE + LINE);
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
      const top = title + (kind === "force" && shown.click ? LABEL * small + 3 : 0);
      this.drawRow(kind, { ...view, top, foot: tall - FOOT * small });
      for (const [time, colour] of [[pointer, shown.theme.grid], [now, shown.theme.accent]])
        if (time !== null) line(c, [[place(time), title], [place(time), tall - FOOT * small]], colour, 1.5);
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
    c.rect(this.gutter, 0, width - this.gutter, foot + 1);
    c.clip();
    if (kind === "force") return this.drawPulses({ ...view, level });
    const curves = [...track.curves[kind].keys()];
    for (const i of stacked ? curves.reverse() : curves)
      line(c, this.points(kind, i, { ...view, level }), colourOf(kind, i, track, theme), 1.6, stacked ? 1 : 0, foot);
  }

  /** Forces: each pulse in its contact's colour. */
  drawPulses({ left, right, pulses, ...view }) {
    const { context: c, track } = this, { place, level, foot, click, theme } = view;
    const colours = track.curves.force.map((_, contact) => colourOf("force", contact, track, theme));
    line(c, [[place(left), foot], [place(right), foot]], theme.soft);
    const filled = new Set(); // pixel columns, in which a lower one of the same contact would not be seen
    for (const pulse of pulses) {
      const { contact, onset, release, at, peak } = pulse, colour = colours[contact];
      const [x, end] = [at ?? onset, at ?? release].map(place), column = `${contact} ${Math.round(0.5 * (x + end))}`;
      if (end - x > NARROW) {
        const points = track.shapeOf(pulse).map(([time, force]) => [place(time), level(force)]);
        line(c, points, colour, 1.6, click ? 0.16 : 0, foot);
      } else if (!filled.has(column)) {
        filled.add(column);
        c.fillStyle = colour;
        c.fillRect(0.5 * (x + end - NARROW), level(peak), NARROW, foot - level(peak));
      }
    }
    if (click) this.drawPairs({ ...view, pulses, colours });
  }

  /** Grid lines with their values, and times below. */
  drawAxes(kind, { left, right, place, top, foot, width, level, least, most: highest, origin, theme }) {
    const { context: c, small, gutter } = this, room = (foot - top) / (highest - least) * highest;
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
   *  another label above that. */
  drawPairs({ pulses, level, width, place, theme, colours }) {
    if (pulses.length > 16) return;
    const { context: c, track, small, gutter } = this, placed = [], line = LABEL * small;
    Object.assign(c, { font: `600 ${small}px ${FONT}`, textAlign: "center", textBaseline: "bottom" });
    const labels = pulses.map((pulse) => ({ x: place(track.peakTime(pulse)), y: level(pulse.peak) - 2,
      contacts: [pulse.contact], colour: colours[pulse.contact] }));
    labels.sort((a, b) => a.x - b.x);
    for (const label of labels) {
      const last = placed.at(-1);
      if (last && label.x - last.x < 1 && Math.abs(label.y - last.y) < line)
        Object.assign(last, { y: Math.min(label.y, last.y), colour: theme.ink,
          contacts: [...last.contacts, ...label.contacts].sort((a, b) => a - b) });
      else placed.push(label);
    }
    placed.forEach((label, i) => {
      label.text = label.contacts.map((contact) => `${contact + 1}–${contact + 2}`).join(", ");
      const half = 0.5 * c.measureText(label.text).width + 2;
      label.x = Math.max(gutter + half, Math.min(width - half, label.x));
      label.half = half;
      for (const other of placed.slice(0, i).sort((a, b) => b.y - a.y))
        if (Math.abs(other.x - label.x) < half + other.half && Math.abs(other.y - label.y) < line)
          label.y = other.y - line;
      c.fillStyle = label.colour;
      c.fillText(label.text, label.x, label.y);
    });
    this.labels = placed;
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
