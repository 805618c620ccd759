// What runs along: velocities, forces, energy and momentum by time, over some seconds or over one click.

import { prepared, through } from "#view/common.js";
import { ballColour } from "#view/scene.js";
import { FONT } from "#view/texts.js";

const HISTORY = 900;  // samples that are kept
export const SECONDS = 7;    // s on the viewer's clock that are shown
export const ENERGY_PARTS = ["kinetic", "gravity", "elastic"];

export class Graph {
  constructor(canvas) { this.canvas = canvas; }

  /** Forgets what was recorded. */
  clear(balls) {
    Object.assign(this, { balls, rows: [], fastest: 1e-9, strongest: 1e-9, largest: 1e-12, momentum: 1e-12 });
  }

  /** Notes what a source shows at the time of the page's clock. */
  record(time, state, pulses) {
    if (state.balls !== this.balls) this.clear(state.balls);
    const sum = (values) => values.reduce((a, b) => a + b, 0), peak = Math.max(0, ...pulses.map((pulse) => pulse.peak));
    const [v, F] = [state.v, state.F].map((values) => Array.from(values));
    const energies = ENERGY_PARTS.map((part) => sum(state[part]));
    this.rows.push({ time, velocity: v, force: F, momentum: [state.momentum], peak, energies });
    if (this.rows.length > HISTORY) this.rows.shift();
    this.fastest = Math.max(this.fastest, ...v.map(Math.abs));
    this.strongest = Math.max(this.strongest, peak, ...F);
    this.largest = Math.max(this.largest, state.energy);
    this.momentum = Math.max(this.momentum, Math.abs(state.momentum));
  }

  /** Where the scales of the rows end: at the most of a click, or of what was recorded. */
  scales(click) { return { velocity: (click ?? this).fastest, force: (click ?? this).strongest,
    momentum: this.momentum }; }

  /** Draws these kinds of rows, from time `left` to `right`; inside a click with all that is known of it. */
  draw(kinds, { left, right, now, ...shown }) {
    const { context: c, width, height } = prepared(this.canvas, 2), tall = height / kinds.length;
    if (!width || !height) return;
    this.context = c;
    const place = (time) => ((time - left) / (right - left)) * width;
    kinds.forEach((kind, i) => {
      c.save();
      c.translate(0, i * tall);
      c.beginPath();
      c.rect(0, 0, width, tall);
      c.clip();
      if (i) this.line([[0, 0.5], [width, 0.5]], shown.theme.grid);
      this.drawRow(kind, { place, tall, width, ...shown });
      c.restore();
    });
    this.line([[place(now), 0], [place(now), height]], shown.theme.accent, 1.5);
  }

  drawRow(kind, { place, tall, width, click, offset, theme }) {
    const top = kind === "force" && click ? 34 : 22, foot = tall - 6, middle = 0.5 * (top + foot);
    const half = 0.5 * (foot - top), { balls } = this;
    if (kind === "energy") return this.drawEnergy(place, top, foot, theme);
    const several = { velocity: balls, force: balls - 1, momentum: 1 }[kind], largest = this.scales(click)[kind];
    const level = (value) => (kind === "force" ? foot - (value / largest) * (foot - top)
      : middle - (value / largest) * half);
    this.line([[0, level(0)], [width, level(0)]], theme.grid);
    const known = kind === "momentum" ? null : click?.samples, values = known?.[kind === "force" ? "F" : "v"];
    for (let i = 0; i < several; i++) {
      const points = known ? known.time.map((time, k) => [place(time + offset), level(values[k][i])])
        : this.rows.map((row) => [place(row.time), level(row[kind][i])]);
      const colour = kind === "momentum" ? theme.ink : ballColour(i, balls, theme.dark);
      this.line(points, colour, 1.6, known && kind === "force" ? foot : null);
    }
    if (kind !== "force") return;
    if (known) return this.drawPairs(click, { place, offset, level, theme });
    // Pulses that lasted less than from one picture to the next.
    for (const { time, peak } of this.rows)
      if (peak > 0) this.line([[place(time), foot], [place(time), level(peak)]], theme.spike, 2);
  }

  /** Which balls each pulse is between, at its peak. */
  drawPairs({ pulses, samples }, { place, offset, level, theme }) {
    if (pulses.length > 16) return;
    const { context: c } = this;
    c.font = `600 11px ${FONT}`;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    const labels = pulses.map(({ contact, onset, release, peak }) => {
      let top = 0;
      samples.time.forEach((time, k) => {
        if (time >= onset && time <= release && samples.F[k][contact] > (samples.F[top][contact] || 0)) top = k;
      });
      return { x: place(samples.time[top] + offset), y: level(peak) - 2, text: `${contact + 1}–${contact + 2}`,
        contact };
    });
    labels.sort((a, b) => a.x - b.x);
    for (let i = 0; i < labels.length; i++) {
      const { x, y, text, contact } = labels[i], next = labels[i + 1];
      // Pulses at the same time have one label.
      if (next && next.x - x < 30) {
        Object.assign(next, { x: 0.5 * (x + next.x), y: Math.min(y, next.y), text: `${text}, ${next.text}` });
        continue;
      }
      c.fillStyle = text.includes(",") ? theme.ink : ballColour(contact, this.balls, theme.dark);
      c.fillText(text, Math.max(16, Math.min(this.canvas.clientWidth - 20, x)), y);
    }
  }

  /** Energies on top of one another. */
  drawEnergy(place, top, foot, theme) {
    const { context: c, rows } = this, level = (value) => foot - (value / this.largest) * (foot - top);
    const sums = rows.map(() => 0);
    ENERGY_PARTS.forEach((_, part) => {
      const line = () => rows.map(({ time }, k) => [place(time), level(sums[k])]), below = line();
      rows.forEach(({ energies }, k) => { sums[k] += Math.max(0, energies[part]); });
      c.fillStyle = theme.energies[part];
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
