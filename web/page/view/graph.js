// Strips: velocities, forces, energy and momentum by time, with axes, as far as a track knows them; see history.js.

import { countUpTo, linear, placeIn, prepared, roundStep, through, withPrefix } from "#view/common.js";
import { ballColour } from "#view/scene.js";
import { FONT } from "#view/texts.js";

export const SECONDS = 7; // s on the viewer's clock that are shown
export const UNITS = { velocity: "m/s", force: "N", energy: "J", momentum: "kg m/s" };
const GUTTER = 66;     // px for the values on the axis, left of the curves
const TITLE = 22, FOOT = 17; // px above and below the curves of a row
const THIN = 520, LINE = 12; // px: where it is not wider, values take a second line
const NARROW = 4;      // px: a pulse that is not wider is a line as high as its peak

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
    const { times } = track, scale = (width - GUTTER) / (right - left), title = width > THIN ? TITLE : TITLE + LINE;
    const place = (time) => GUTTER + (time - left) * scale;
    const view = { left, right, width, place, from: Math.max(0, countUpTo(times, left) - 1),
      to: Math.min(times.length, countUpTo(times, right) + 1), ...this.pulses(track, left, right, scale), ...shown };
    Object.assign(this, { context: c, track });
    kinds.forEach((kind, i) => {
      c.save();
      c.translate(0, i * tall);
      this.drawRow(kind, { ...view, top: title + (kind === "force" && shown.click ? 16 : 0), foot: tall - FOOT });
      for (const [time, colour] of [[pointer, shown.theme.grid], [now, shown.theme.accent]])
        if (time !== null) this.line([[place(time), title], [place(time), tall - FOOT]], colour, 1.5);
      c.restore();
    });
  }

  /** Pulses between the sides; by contact, the samples after which one lies before the next, and its time; and the
   *  samples within narrow ones. */
  pulses(track, left, right, scale) {
    const pulses = track.pulsesIn(left, right), jumps = new Map(), within = new Set(), { times, counts } = track;
    for (const { contact, onset, release } of pulses) {
      const before = countUpTo(times, onset) - 1;
      if (release <= times[before + 1]) jumps.set(before * counts.force + contact, 0.5 * (onset + release));
      if ((release - onset) * scale >= NARROW) continue;
      for (let k = before + 1; times[k] <= release; k++) within.add(k * counts.force + contact);
    }
    return { pulses, jumps, within };
  }

  drawRow(kind, view) {
    const { context: c, track } = this, { width, top, foot, click, theme } = view;
    const most = roundUp(click?.most[kind] ?? track.most[kind]);
    const least = ["velocity", "momentum"].includes(kind) ? -most : 0;
    const level = (value) => foot - ((value - least) / (most - least)) * (foot - top);
    this.drawAxes(kind, { ...view, level, least, most });
    c.beginPath();
    c.rect(GUTTER, 0, width - GUTTER, foot + 1);
    c.clip();
    if (kind === "energy") return this.drawEnergy({ ...view, level });
    for (let i = 0; i < track.counts[kind]; i++) {
      const points = this.points(kind, i, { ...view, level });
      this.line(points, colourOf(kind, i, track, theme), 1.6, click && kind === "force" ? foot : null);
    }
    if (kind !== "force") return;
    for (const { onset, release, peak } of view.pulses) {
      const x = view.place(0.5 * (onset + release));
      if (view.place(release) - view.place(onset) < NARROW) this.line([[x, foot], [x, level(peak)]], theme.spike, 2);
    }
    if (click) this.drawPairs({ ...view, level });
  }

  /** Grid lines with their values, and times below. */
  drawAxes(kind, { left, right, place, top, foot, width, level, least, most, origin, theme }) {
    const { context: c } = this;
    c.font = `11px ${FONT}`;
    c.fillStyle = theme.soft;
    c.textBaseline = "middle";
    c.textAlign = "right";
    const parts = (foot - top) / (most - least) * most >= 44 ? [-1, -0.5, 0, 0.5, 1] : [-1, 0, 1];
    for (const value of parts.map((part) => part * most).filter((value) => value >= least)) {
      this.line([[GUTTER, level(value)], [width, level(value)]], theme.grid);
      const text = withPrefix(value, UNITS[kind]).replace(" kg", "\u2009kg");
      c.fillText(text, GUTTER - 4, Math.max(top + 2, level(value)));
    }
    c.textAlign = "center";
    const step = (right - left) * 90 / (width - GUTTER);
    for (const time of ticks(left - origin, right - origin, step)) {
      const x = place(time + origin);
      this.line([[x, foot], [x, foot + 3]], theme.soft);
      if (x > GUTTER + 12 && x < width - 22) c.fillText(withPrefix(time, "s", 4), x, foot + 10);
    }
  }

  /** A curve's points, at most six for each pixel: of many samples the first ones, the least, the largest and the last.
   *  A velocity jumps where a pulse lies between two samples; a force leaves out what narrow pulses are drawn for. */
  points(kind, i, { from, to, place, level, jumps, within }) {
    const { track } = this, { times, counts: { force: contacts } } = track, points = [];
    let column = NaN, count = 0, x, y, low, high;
    const flush = () => { if (count > 3) points.push([x, low], [x, high], [x, y]); };
    const add = (time, value) => {
      const at = place(time);
      y = level(value);
      if (Math.floor(at) === column) [low, high, count] = [Math.min(low, y), Math.max(high, y), count + 1];
      else {
        flush();
        [column, low, high, count] = [Math.floor(at), y, y, 1];
      }
      if (count <= 3) points.push([at, y]);
      x = at;
    };
    for (let k = from; k < to; k++) {
      const value = track.value(kind, i, k);
      add(times[k], kind === "force" && within.has(k * contacts + i) ? 0 : value);
      if (kind !== "velocity" || k + 1 >= to) continue;
      const jump = (i ? jumps.get(k * contacts + i - 1) : null) ?? (i < contacts ? jumps.get(k * contacts + i) : null);
      if (!jump) continue;
      add(jump, value);
      add(jump, track.value(kind, i, k + 1));
    }
    flush();
    return points;
  }

  /** Which balls each pulse is between, at its peak. */
  drawPairs({ pulses, place, level, width, theme }) {
    if (pulses.length > 16) return;
    const { context: c, track } = this, { times } = track;
    c.font = `600 11px ${FONT}`;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    const labels = pulses.map(({ contact, onset, release, peak }) => {
      let top = countUpTo(times, onset);
      for (let k = top; times[k] <= release; k++)
        if (track.value("force", contact, k) > track.value("force", contact, top)) top = k;
      return { x: place(times[top] ?? onset), y: level(peak) - 2, text: `${contact + 1}–${contact + 2}`, contact };
    });
    labels.sort((a, b) => a.x - b.x || a.contact - b.contact);
    for (let i = 0; i < labels.length; i++) {
      const { x, y, text, contact } = labels[i], next = labels[i + 1];
      // Pulses at the same time have one label.
      if (next && next.x - x < 30) {
        Object.assign(next, { x: 0.5 * (x + next.x), y: Math.min(y, next.y), text: `${text}, ${next.text}` });
        continue;
      }
      c.fillStyle = text.includes(",") ? theme.ink : colourOf("force", contact, track, theme);
      c.fillText(text, Math.max(GUTTER + 16, Math.min(width - 20, x)), y);
    }
  }

  /** Energies on top of one another, at every second pixel. */
  drawEnergy({ left, right, place, width, level, theme }) {
    const { context: c, track } = this, { times } = track, step = 2 * (right - left) / (width - GUTTER);
    const last = Math.min(right, times.at(-1)), at = [];
    for (let time = Math.max(left, times[0]); time < last; time += step) at.push(time);
    if (times.length < 2) return;
    at.push(last);
    const places = at.map((time) => placeIn(times, time)), sums = at.map(() => 0);
    track.parts.forEach((_, part) => {
      const line = () => at.map((time, j) => [place(time), level(sums[j])]), below = line();
      places.forEach((found, j) => { sums[j] += Math.max(0, valueAt(track, "energy", part, found)); });
      c.fillStyle = colourOf("energy", part, track, theme);
      through(c, [...below, ...line().reverse()]).fill();
    });
  }

  line(points, colour, width = 1, foot = null) {
    const { context: c } = this;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.lineJoin = "round";
    through(c, points).stroke();
    if (foot === null || !points.length) return;
    c.lineTo(points.at(-1)[0], foot);
    c.lineTo(points[0][0], foot);
    c.globalAlpha = 0.16;
    c.fillStyle = colour;
    c.fill();
    c.globalAlpha = 1;
  }
}

/** The colour of curve `i` of this kind. */
export function colourOf(kind, i, { balls }, theme) {
  return kind === "momentum" ? theme.ink : kind === "energy" ? theme.energies[i] : ballColour(i, balls, theme.dark);
}

/** What a track's curve is at a place between its samples. */
export function valueAt(track, kind, i, place) {
  const pair = [track.value(kind, i, place.i), track.value(kind, i, place.i + 1)];
  return linear(pair, { i: 0, part: place.part });
}

/** The next round number that is not below `value`. */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10].find((round) => round * power >= value * (1 - 1e-9));
}

/** Round numbers from `low` to `high`, at least `least` apart. */
function ticks(low, high, least) {
  const step = roundStep(least), first = Math.ceil(low / step - 1e-9);
  const count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(0, count) }, (_, k) => (first + k) * step);
}
