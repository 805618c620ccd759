// What a live source has shown of late, for the strips: a track, as a recording is one by itself.
//
// A track has `times` (s, rising), `value(kind, i, k)` of curve `i` at sample `k`, `counts` of curves, the `most` of
// each kind, the names of the `parts` of its energy, and `pulsesIn(left, right)`.

import { largest } from "#view/common.js";

const ENERGY_PARTS = ["kinetic", "gravity", "elastic"];
export const LEAST = { velocity: 1e-9, force: 1e-9, energy: 1e-12, momentum: 1e-12 }; // that a scale ends at
const KEPT = 900; // samples

export class History {
  constructor(balls) {
    Object.assign(this, { balls, times: [], rows: [], pulses: [], parts: ENERGY_PARTS });
    this.counts = { velocity: balls, force: balls - 1, energy: ENERGY_PARTS.length, momentum: 1 };
    this.most = { ...LEAST, overlap: 1e-9 };
  }

  /** Notes what is shown at `time`, and pulses by the clock of their run, which began at `origin`. */
  record(time, state, pulses = [], origin = 0) {
    const sum = (values) => values.reduce((a, b) => a + b, 0);
    const row = { velocity: Array.from(state.v), force: Array.from(state.F), momentum: [state.momentum],
      energy: ENERGY_PARTS.map((part) => Math.max(0, sum(state[part]))) };
    this.times.push(time);
    this.rows.push(row);
    for (const pulse of pulses)
      this.pulses.push({ ...pulse, onset: pulse.onset + origin, release: pulse.release + origin });
    if (this.rows.length > KEPT) {
      this.times.shift();
      this.rows.shift();
      while (this.pulses[0]?.release < this.times[0]) this.pulses.shift();
    }
    const seen = { ...row, force: [...row.force, ...pulses.map(({ peak }) => peak)], energy: [state.energy],
      overlap: state.overlap.map((overlap) => Math.max(0, overlap)) };
    for (const [kind, values] of Object.entries(seen)) this.most[kind] = Math.max(this.most[kind], largest([values]));
  }

  value(kind, i, k) { return this.rows[k][kind][i]; }

  pulsesIn(left, right) { return this.pulses.filter(({ onset, release }) => release >= left && onset <= right); }
}
