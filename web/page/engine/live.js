// A live source: a run of the engine that hands can take hold of and that changes can be made to while it moves.
// Both kinds of sources have `drawing`, `state`, `account`, `advance`, `takePulses`, `ahead` and `shownClick`.

import { Click } from "#engine/click.js";
import { History } from "#engine/history.js";

const NEVER_OPEN = 0.5; // s after which a change is made although balls are still in contact
const CROWD = 2;        // average number of pulses in a picture, up to which the engine samples each
const KEPT = 20000;     // pulses that are kept for the CSV file

export class Live {
  constructor(engine, setup) {
    // `holds`: who holds, {ball, x}; `crowd`: pulses in a picture.
    Object.assign(this, { live: true, engine, holds: new Map(), crowd: 0 });
    this.begin(setup);
  }

  /** Starts a run. If the engine refuses, nothing has changed. Throws Refusal. */
  begin(setup) {
    const run = this.engine.start(setup.recipe()), origin = this.run ? this.time : 0;
    this.run?.forget();
    this.dropClicks();
    // What does not change while balls move; `reach` (rad) of the largest swing; `farthest` (m) that a hand goes.
    const { reach, farthest } = run, drawing = { ...setup.drawing, reach, farthest };
    const track = new History(setup.balls, drawing.masses);
    const empty = { pending: null, moved: null, fresh: [], pulses: [] };
    Object.assign(this, { setup, drawing, run, origin, state: run.look(), track, ...empty });
    track.record(this.time, this.state);
  }

  /** Whether there are too many pulses to sample each: velocities then step by the impulses. */
  get crowded() { return this.crowd > CROWD; }

  /** Whether balls touch now, and their pulses are to be sampled. */
  get touches() { return !this.state.apart && !this.crowded; }

  /** Whether sums of energy belong to one undisturbed run: no ball is held. */
  get account() { return this.holds.size === 0; }

  /** Time of the run (s), and of the page, which continues when a new run begins. */
  get now() { return this.run.time; }
  get time() { return this.origin + this.run.time; }

  /** Advances to `time` of the page (s), as far as `effort` allows; then not past where balls touch or part either, as
   *  long as each pulse is looked at. */
  advance(time, effort = Infinity) {
    if (this.holds.size) return this.advanceHeld(time, effort);
    this.run.advance(time - this.origin, effort, effort < Infinity && !this.crowded);
    if (time - this.time < 1e-15 * time) this.origin = time - this.run.time; // a rounding error is no time left
    this.state = this.run.look();
    const pulses = this.run.takePulses();
    this.track.record(this.time, this.state, pulses, this.origin);
    this.fresh.push(...pulses);
    this.pulses.push(...pulses);
    if (this.pulses.length > 2 * KEPT) this.pulses.splice(0, this.pulses.length - KEPT);
    if (this.pending) this.tryPending();
  }

  /** The pulses since the last picture. */
  takePulses() {
    this.crowd += 0.1 * (this.fresh.length - this.crowd);
    return this.fresh.splice(0);
  }

  /** Starts a run with other values at the next instant at which all contacts are open; then calls `done`. */
  change(given, done = () => {}) {
    const values = { ...this.pending?.values, ...given };
    this.engine.start(this.setup.with(values).atRest().recipe()).forget(); // refused now rather than later
    this.pending = { since: this.time, ...this.pending, values, done };
    this.tryPending();
  }

  tryPending() {
    const { values, since, done } = this.pending;
    if (!this.state.apart && this.time - since < NEVER_OPEN) return;
    this.pending = null;
    this.restart(this.setup.with(values), ...this.motion());
    done();
  }

  /** A new run at these positions (m) and velocities (m/s). */
  restart(setup, x, v) { this.begin(setup.moving(x, v)); }
  motion() { return [Array.from(this.state.x), Array.from(this.state.v)]; }

  /** Which balls are held, and where: {ball: x}. */
  get held() {
    return new Map([...this.holds.values()].flatMap(({ balls, x }) => [...balls].map((ball) => [ball, x])));
  }

  /** `who` takes ball `ball` (from 0), or moves its ball, to `x` (m); balls outward of it come along. */
  hold(who, ball, x) {
    this.dropClicks();
    const { farthest: most } = this.drawing, place = Math.min(most, Math.max(-most, x));
    const hold = this.holds.get(who) ?? { ball, balls: new Set([ball]), side: 0 };
    const side = place < 0 ? -1 : 1, near = 0.02 * this.setup.get("pendulum.length");
    if (side !== hold.side) hold.balls = new Set([hold.ball]);
    for (let other = hold.ball + side; other >= 0 && other < this.setup.balls; other += side) {
      if (!hold.balls.has(other) && side * (this.state.x[other] - place) > near) break;
      hold.balls.add(other);
    }
    this.holds.set(who, Object.assign(hold, { x: place, side }));
  }

  /** Moves held balls to the hand, without any time passing. */
  place() {
    const { held } = this, [x] = this.motion();
    for (const [ball, place] of held) x[ball] = place;
    for (const [ball, place] of held) // pushed balls give way
      x.forEach((other, i) => { if (!held.has(i) && (i - ball) * (place - other) > 0) x[i] = place; });
    this.setMotion(x, x.map(() => 0));
  }

  /** Places the balls anew, at positions (m) and velocities (m/s). */
  setMotion(x, v) {
    this.moved = null;
    this.run.setMotion(this.setup.apart(x), v);
    this.state = this.run.look();
  }

  /** The other balls swing on while the hand takes the held ones along, as far as `effort` allows. Those are seen in
   *  the hand at once; the others, once all have come to where `moved` takes them, {held, until, time}. */
  advanceHeld(time, effort) {
    const { held, run } = this, passed = time - this.time;
    if (!this.moved) {
      if (!(passed > 0)) return;
      const [x, v] = this.motion();
      run.setMotion(this.setup.apart(x), v, held, passed);
      this.moved = { held, time, until: run.time + passed };
    }
    const { moved } = this;
    if (run.advance(moved.until, effort) >= moved.until) this.endMove(moved);
    else for (const [ball, place] of held) this.state.x[ball] = place;
  }

  /** Those that the hand has taken along are where it took them, and at rest. */
  endMove({ held, time }) {
    const { run } = this, pulses = run.takePulses(), { x, v } = run.look();
    for (const [ball, place] of held) [x[ball], v[ball]] = [place, 0];
    this.setMotion(x, v);
    this.origin = time - run.time;
    this.track.record(this.time, this.state, pulses, this.origin);
    this.fresh.push(...pulses);
  }

  /** `who` lets go; held balls fly on at `speed` (m/s). Starts a run when nobody holds any more. */
  release(who, speed = 0) {
    const hold = this.holds.get(who);
    if (!hold) return;
    this.holds.delete(who);
    const [x, v] = this.motion(), still = this.held, place = Number(hold.x.toFixed(speed ? 6 : 4));
    for (const ball of hold.balls) if (!still.has(ball)) {
      const most = this.run.fastest(ball, place);
      [x[ball], v[ball]] = [place, Math.max(-most, Math.min(most, Number(speed.toFixed(6))))];
    }
    this.restart(this.setup, x, v);
  }

  dropClicks() {
    this.click?.forget();
    this.past?.forget();
    this.click = this.past = null;
  }

  /** The next or current click {distance, length, done} (s), explored until `deadline` (ms); or null. */
  ahead(deadline) {
    if (this.holds.size) return null;
    const now = this.run.time;
    this.past?.work(deadline);
    if (this.click?.done && now > this.click.end + 0.05 * this.click.length) {
      this.past?.forget();
      [this.past, this.click] = [this.click, null];
    }
    if (!this.click) {
      const { time, known } = this.run.nextOnset();
      if (time === Infinity) return null;
      if (!known) return { distance: Math.max(0, time - now), length: 0, done: false };
      this.click = new Click(this.run, time);
    }
    const { click } = this;
    click.work(deadline);
    return { distance: Math.max(click.begin - now, 0), length: click.end - click.begin, done: click.done };
  }

  /** The click at the time shown, or the last one before. */
  get shownClick() {
    const now = this.run.time, { click, past } = this;
    if (click?.done && (!past || click.begin - now < now - past.end)) return click;
    return past;
  }

  /** To `time` of the run within a click that is known. */
  seek(time) {
    const click = this.shownClick;
    if (!click || time < click.before.time) return;
    const now = click.before.copy();
    now.advance(time);
    now.takePulses();
    this.run.forget();
    this.run = now;
    this.state = now.look();
    if (click === this.past && time < click.end) {
      this.click?.forget();
      [this.click, this.past] = [click, null];
    }
    this.pulses = this.pulses.filter(({ release }) => release <= time);
    this.fresh = [];
  }

  forget() {
    this.dropClicks();
    this.run.forget();
  }
}
