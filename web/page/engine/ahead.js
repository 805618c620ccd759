// Computing ahead of what is shown, so that the work of a click is spread over the pictures before it.

const STRIDE = 1 / 30;    // s of the run: no piece of work is longer,
const PIECE = 1000;       // nor does it cost more, about 0.1 us each
const MOST_POINTS = 300;

/** A run that goes ahead of another one, and leaves copies where something has happened. */
class Ahead {
  constructor(run) {
    Object.assign(this, { scout: run.copy(), points: [], pulses: [] });
    this.events = this.scout.state.events;
  }

  /** Up to when all is known (s). */
  get time() { return this.scout.time; }

  /** One piece of work on the way to `until` (s). */
  piece(until) {
    const { scout } = this;
    scout.advance(Math.min(until, scout.time + STRIDE), PIECE);
    this.pulses.push(...scout.takePulses());
    const { events } = scout.look();
    if (events === this.events) return;
    this.events = events;
    this.points.push(scout.copy());
  }

  /** Goes on until `until` (s) or until the clock shows `deadline` (ms). */
  work(until, deadline) {
    while (this.time < until && this.points.length < MOST_POINTS && performance.now() < deadline) this.piece(until);
  }

  /** The copy that was left last up to `time` (s), which is handed out; null if it was handed out before. */
  point(time) {
    let found = null;
    while (this.points.length && this.points[0].time <= time) {
      found?.forget();
      found = this.points.shift();
    }
    return found;
  }

  /** Pulses that have finished up to `time` (s). */
  takePulses(time) {
    let count = 0;
    while (count < this.pulses.length && this.pulses[count].release <= time) count++;
    return this.pulses.splice(0, count);
  }

  forget() { for (const run of [this.scout, ...this.points]) run.forget(); }
}
