// A click: contacts that follow each other so closely that they are one sound, from nanoseconds to milliseconds.

import { EFFORT } from "#engine/engine.js";
import { History } from "#engine/history.js";

export const QUIET = 3;          // a click is over when nothing touches for this many times as long as it has lasted,
export const QUIET_LEAST = 2e-6; // and for at least this many seconds
export const LONGEST = 0.2;      // s, of a click that never ends
const SAMPLES = 360;      // even instants at which its forces are sampled
const CLICK_TIME = 2;      // ms for one picture, if nothing else is said

/** Follows copies of a run through its next click ahead of time, in small portions. */
export class Click {
  /** `run` is before the onset at `begin` (s). */
  constructor(run, begin) {
    Object.assign(this, { begin, end: begin, pulses: [], reach: 1e-8, done: false });
    const [before, scout, sampler] = [run.copy(), run.copy(), run.copy()]; // `before` stays, to look at it again
    Object.assign(this, { before, scout, sampler, samples: new History(run.balls), taken: 0 });
  }

  /** Continues until `deadline` (ms), or until the click (`done`) and its samples (`sampled`) are known. */
  work(deadline = performance.now() + CLICK_TIME) {
    while (!this.sampled) {
      if (this.done) this.sample();
      else this.explore();
      if (performance.now() > deadline) return;
    }
  }

  explore() {
    const { scout } = this;
    if (!this.speeds) {
      if (scout.advance(this.begin, EFFORT) < this.begin) return;
      this.speeds = Array.from(scout.look().v); // with which it begins
    }
    const until = this.begin + this.reach;
    if (scout.advance(until, EFFORT) < until) return; // more effort is needed
    const state = scout.look();
    this.pulses.push(...scout.takePulses());
    if (state.apart && this.pulses.length) {
      this.end = this.pulses.reduce((latest, { release }) => Math.max(latest, release), this.begin);
      const { time } = scout.nextOnset(), enough = Math.max(QUIET * (this.end - this.begin), QUIET_LEAST);
      if (time - this.end > enough) this.finish(state);
      else this.reach = Math.max(1.3 * this.reach, time - this.begin);
    } else if (this.reach > LONGEST) {
      this.end = until;
      this.finish(state);
    } else this.reach *= 1.4;
  }

  finish(state) {
    this.after = Array.from(state.v);
    this.done = true;
    this.pulses.sort((a, b) => a.onset - b.onset || a.release - b.release);
    this.samples.pulses = this.pulses;
    this.length = this.end - this.begin;
    this.sampled = this.length === 0; // rigid: at one instant
  }

  /** Samples the forces at the next instant, or before it where balls touch or part. */
  sample() {
    const { samples, sampler, taken } = this, margin = 0.06 * this.length;
    const from = Math.max(this.begin - margin, this.before.time), step = (this.length + 2 * margin) / (SAMPLES - 1);
    const time = from + taken * step, reached = sampler.advance(time, EFFORT, true);
    if (!(samples.times.at(-1) >= reached)) samples.record(reached, sampler.look());
    if (reached >= time) this.taken++;
    this.sampled = this.taken === SAMPLES;
  }

  /** The largest velocity, force and overlap in it (SI). */
  get most() { return this.samples.most; }

  /** The lowest velocity and momentum in it (SI), or 0. */
  get lowest() { return this.samples.lowest; }

  forget() {
    for (const run of [this.before, this.scout, this.sampler]) run.forget();
  }
}
