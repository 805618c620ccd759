// Time: how fast it runs, and how it slows down at a click by itself.

import { EFFORT } from "#engine/engine.js";

const CLICK_SHOWN = 12; // s on the viewer's clock that a click takes
const APPROACH = 2.6;   // 1/s: nearing a click, the time to it shrinks at this rate; leaving it, it grows
const SLOWEST = 1e-9;   // seconds of the run per second of the viewer's
const LONGEST_FRAME = 0.05; // s: the most time that passes from one picture to the next
const BUDGET = 4;       // ms after which the engine begins nothing more for a picture
const PARTS = 16;       // samples of a run in a step while balls touch

export class Clock {
  constructor() {
    this.base = 1;      // seconds of the run per second of the viewer's, away from clicks
    this.running = true;
    this.late = 0;      // fraction of recent time that did not pass because the engine had too much to do
    this.spent = 0;     // ms that the engine took for the last picture
    this.targets = new Map(); // by source, the time that it is to reach, s
    this.stride = Infinity;   // s of the run between samples while balls touch
    this.slowAt("no");
  }

  get inside() { return this.slow !== "no" && this.rate < 0.02 * this.base; }

  /** When to slow down: at the "next" click, "always", or "no"; "leaving": the next click is over. */
  slowAt(slow) {
    // `rate`: as `base`, now; `sinceClick`: s of the run since the last click, which took `lastLength`.
    Object.assign(this, { slow, met: false, sinceClick: Infinity, lastLength: 0 });
    if (slow === "no") this.rate = this.base;
  }

  /** The rate of time, given the clicks ahead. */
  rateFor(clicks) {
    if (this.slow === "no") return this.base;
    const known = [{ distance: this.sinceClick, length: this.lastLength }, ...(this.slow === "leaving" ? [] : clicks)];
    const rates = known.map(({ distance, length }) => Math.max(length / CLICK_SHOWN, APPROACH * distance, SLOWEST));
    return Math.min(this.base, ...rates);
  }

  /** Advances all sources together by `seconds` of the viewer's, within the budget. */
  frame(seconds, sources) {
    const begun = performance.now(), watch = this.slow !== "no", deadline = begun + BUDGET, pieces = watch ? 6 : 1;
    const piece = Math.min(seconds, LONGEST_FRAME) / pieces;
    let passed = 0;
    for (; passed < pieces && this.finish(sources, deadline); passed++) {
      const clicks = watch ? sources.map((source) => source.ahead(begun + 0.5 * BUDGET)).filter(Boolean) : [];
      this.rate = this.rateFor(clicks);
      // Does not pass an onset whose click is not known yet.
      const unknown = clicks.filter(({ done }) => !done).map(({ distance }) => distance);
      const step = Math.min(piece * this.rate, ...unknown);
      this.stride = step / PARTS;
      for (const source of sources) this.targets.set(source, Math.min(source.time + step, source.end ?? Infinity));
      this.notice(clicks, step);
    }
    this.finish(sources, deadline);
    this.spent = performance.now() - begun;
    this.late += 0.06 * ((piece > 0 ? 1 - passed / pieces : 0) - this.late);
  }

  /** Records the click passed last. */
  notice(clicks, step) {
    const current = clicks.filter(({ distance, done }) => done && distance === 0).map(({ length }) => length);
    if (current.length) Object.assign(this, { sinceClick: 0, lastLength: Math.max(...current), met: true });
    else this.sinceClick += step;
    if (this.slow === "next" && this.met && this.sinceClick > 0.3 * this.lastLength + 1e-8) this.slow = "leaving";
    if (this.slow === "leaving" && this.rate >= this.base) this.slowAt("no");
  }

  /** The rate needed where a source is now, with these clicks ahead. */
  land(clicks) {
    this.slowAt(this.slow !== "leaving" ? this.slow : clicks[0]?.distance === 0 ? "next" : "no");
    this.rate = this.rateFor(clicks);
  }

  calm() { this.slowAt(this.slow === "always" ? "always" : "no"); }
  reset() { this.targets.clear(); }

  /** Whether all sources have reached their targets, in short calls of the engine that end at the deadline. */
  finish(sources, deadline) {
    for (const source of sources) {
      const target = this.targets.get(source);
      while (source.time < target) {
        const soon = source.touches ? source.time + this.stride : target;
        source.advance(soon > source.time ? Math.min(soon, target) : target, EFFORT);
        if (source.time < target && performance.now() > deadline) return false;
      }
    }
    return true;
  }
}
