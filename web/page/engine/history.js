// Tracks: what strips show of a whole recording, of a click, or of the recent past of a live run.

import { largest } from "#view/common.js";

const PARTS = ["kinetic", "gravity", "elastic"]; // of the energy
const LEAST = { velocity: 1e-3, force: 1e-9, energy: 1e-12, momentum: 1e-3 }; // that a scale ends at
const KEPT = 900; // samples

export class Track {
  /** `times` (s) rise; `curves`: by kind, a column of samples for each; `parts`: what its curves of energy are. */
  constructor(balls, times, curves, parts) {
    Object.assign(this, { balls, times, curves, parts, pulses: [], most: { ...LEAST, overlap: 1e-9 } });
  }

  pulsesIn(left, right) { return this.pulses.filter(({ onset, release }) => release >= left && onset <= right); }

  /** Raises the largest value of this kind to that of these columns. */
  see(kind, columns) { this.most[kind] = Math.max(this.most[kind], largest(columns)); }
}

export class History extends Track {
  constructor(balls) {
    const curves = (count) => Array.from({ length: count }, () => []);
    super(balls, [], { velocity: curves(balls), force: curves(balls - 1), energy: curves(PARTS.length),
      momentum: curves(1) }, PARTS);
  }

  /** Adds the state at `time`, and pulses in the time of their run, which began at `origin`. */
  record(time, { v, F, energy, momentum, overlap, ...stored }, pulses = [], origin = 0) {
    const parts = PARTS.map((part) => Math.max(0, stored[part].reduce((a, b) => a + b, 0))), { times, curves } = this;
    const row = { velocity: v, force: F, energy: parts, momentum: [momentum] };
    times.push(time);
    for (const [kind, values] of Object.entries(row)) values.forEach((value, i) => curves[kind][i].push(value));
    this.pulses.push(...pulses.map((pulse) =>
      ({ ...pulse, onset: pulse.onset + origin, release: pulse.release + origin })));
    if (times.length > KEPT) {
      for (const column of [times, ...Object.values(curves).flat()]) column.shift();
      while (this.pulses[0]?.release < times[0]) this.pulses.shift();
    }
    const seen = { ...row, force: [...F, ...pulses.map(({ peak }) => peak)], energy: [energy],
      overlap: overlap.map((depth) => Math.max(0, depth)) };
    for (const [kind, values] of Object.entries(seen)) this.see(kind, [values]);
  }
}
