// A recorded source: a run from the page's data or from a file, for the same player and scene as a live one.

import { LONGEST, QUIET, QUIET_LEAST } from "#engine/click.js";
import { Refusal, State } from "#engine/engine.js";
import { Track } from "#engine/history.js";
import { DEFAULTS, Setup, swingOf } from "#engine/setup.js";
import { fromCsv, runOf } from "#engine/table.js";
import { columnsOf, countUpTo, cubic, largest, linear, placeIn, smallest } from "#view/common.js";

const LEAST_SAMPLES = 2; // of each pulse of a click that can be looked into
const RESOLVED = 4;      // samples that show the shape of a pulse

export class Recording extends Track {
  /** From the data that page.py has packed into the page. */
  static async load({ time, samples, pulses, ...known }, engine) {
    const [times, columns, table] = await Promise.all([time, samples, pulses].map(columnsOf));
    const rows = Array.from(table.get("contact"), (contact, i) => ({ contact: contact - 1, onset: table.get("onset")[i],
      release: table.get("release")[i], peak: table.get("peak")[i], peakTime: table.get("peak_time")?.[i],
      impulse: table.get("impulse")[i] }));
    return new Recording({ ...runOf(new Map([...times, ...columns])), pulses: rows, ...known }, engine);
  }

  /** From the text of a CSV file, which tells no parameters. Throws Refusal. */
  static read(file, text) { return new Recording({ title: file, ...fromCsv(file, text) }); }

  /** `pulses`: {contact, from 0, onset, release, peak, impulse}. `start`: what it was run with, if that is known; with
   *  an `engine` it can go on from there, by the engine's own method, and overlaps of what is not rigid are known. */
  constructor({ title, balls, time, x, v, F, energy, pulses, parameters = [], length = DEFAULTS["pendulum.length"],
    radius = DEFAULTS["ball.radius"], start }, engine = null) {
    const setup = engine && start ? new Setup(balls, withoutSolver(start)) : null;
    const extent = largest(x), long = Math.max(length, extent / 1.1);
    const drawing = setup ? setup.with({ "pendulum.length": long }).drawing
      : drawingOf(balls, radius, long, start);
    const sum = (columns) => time.map((_, k) => columns.reduce((sum, column) => sum + column[k], 0));
    const momenta = v.map((column, i) => column.map((speed) => drawing.masses[i] * speed));
    super(balls, time, { velocity: v, force: F, energy: Object.values(energy), momentum: setup ? [sum(momenta)] : [] },
      Object.keys(energy), setup && drawing.masses);
    const rigid = pulses.length > 0 && largest(F) === 0 && pulses.every(({ onset, release }) => onset === release);
    this.drawing = { ...drawing, rigid, reach: drawing.swing.angle(extent), farthest: extent };
    const soft = setup && setup.law !== "rigid"; // rigid balls do not overlap, but as drawn between two samples
    Object.assign(this, { live: false, account: false, origin: 0, name: title, x, parameters, setup,
      run: soft ? unlessRefused(() => engine.start(setup.atRest().recipe())) : null, begin: time[0], end: time.at(-1),
      state: new State(balls) });
    this.findClicks(pulses);
    for (const kind of ["velocity", "force", "momentum"]) this.see(kind, this.curves[kind]);
    this.see("force", [pulses.map(({ peak }) => peak)]);
    this.see("energy", [sum(this.curves.energy)]);
    this.seek(this.begin);
  }

  findClicks(pulses) {
    for (const pulse of pulses) {
      if (!pulse.impulse) this.placeGuess(pulse);
      // A half-sine's impulse, where the peak is all that is known; of rigid impacts, only their impulse is.
      pulse.impulse ||= (2 / Math.PI) * pulse.peak * (pulse.release - pulse.onset) || pulse.peak;
      pulse.peak ||= pulse.impulse;
    }
    this.pulses = pulses.sort((a, b) => a.onset - b.onset || a.release - b.release);
    const clicks = [];
    for (const pulse of pulses) {
      const click = clicks.at(-1), quiet = click && Math.max(QUIET * (click.end - click.begin), QUIET_LEAST);
      if (click && pulse.onset - click.end <= quiet && pulse.onset - click.begin <= LONGEST) {
        click.pulses.push(pulse);
        click.end = Math.max(click.end, pulse.release);
      } else clicks.push({ begin: pulse.onset, end: pulse.release, pulses: [pulse] });
    }
    this.clicks = clicks.map((click, number) => new RecordedClick(this, click, number));
    this.openable = this.clicks.filter(({ resolved }) => resolved);
  }

  /** A pulse that only samples tell of: if they do not show its shape, `at` says when it may have been, and `between`
   *  which samples, that know nothing of it. */
  placeGuess(pulse) {
    const { times, curves: { force: { [pulse.contact]: force } } } = this, { onset, release } = pulse;
    const first = countUpTo(times, onset) - 1;
    let last = countUpTo(times, release) - 1;
    while (last + 1 < times.length && force[last] > 0) last++;
    const within = Array.from({ length: last - first - 1 }, (_, k) => first + 1 + k).filter((k) => force[k] > 0);
    if (within.length >= RESOLVED) return;
    const top = within.reduce((best, k) => (force[k] > force[best] ? k : best), within[0]);
    Object.assign(pulse, { at: times[top] ?? 0.5 * (onset + release), between: [first, last] });
  }

  get time() { return this.now; }
  get track() { return this; }

  advance(time) { this.go(Math.min(time, this.end)); }

  seek(time) {
    this.go(Math.min(Math.max(time, this.begin), this.end));
    this.told = this.now;
  }

  go(now) {
    const { times, x, curves: { velocity: v, force: F }, state } = this, place = placeIn(times, now);
    this.now = now;
    state.x.set(x.map((column, i) => cubic(column, v[i], place)));
    state.v.set(this.speedsAt(now));
    state.F.set(F.map((column) => linear(column, place)));
    state.closed.fill(0);
    for (const { contact, onset, release } of this.lastClick?.pulses ?? [])
      if (onset <= now && now < release) state.closed[contact] = 1;
    state.overlap.set(this.overlapsAt(state.x));
  }

  /** Overlaps of the contacts (m) at these deflections of the balls; 0 where they are not known. */
  overlapsAt(x) {
    const found = this.run && unlessRefused(() => {
      this.run.setMotion(x, x.map(() => 0));
      return this.run.look().overlap;
    });
    return found ?? Array(this.balls - 1).fill(0);
  }

  takePulses() {
    const { told, now } = this;
    this.told = now;
    return now > told ? this.pulsesIn(told, now).filter(({ release }) => release > told && release <= now) : [];
  }

  /** Velocities of the balls (m/s). */
  speedsAt(time) {
    const place = placeIn(this.times, time);
    return this.curves.velocity.map((column) => linear(column, place));
  }

  /** The openable click that has begun last, and the next one. */
  get around() {
    const i = begun(this.openable, this.now);
    return [this.openable[i - 1], this.openable[i]];
  }

  /** The next or current click; null if there is none. */
  ahead() {
    const [last, next] = this.around, click = last && this.now <= last.end + 0.05 * last.length ? last : next;
    return click ? { distance: Math.max(click.begin - this.now, 0), length: click.length, done: true } : null;
  }

  /** The click at the time shown, or the nearest one. */
  get shownClick() {
    const [past, next] = this.around;
    return past && !(next && next.begin - this.now < this.now - past.end) ? past : next ?? null;
  }

  /** The click that began last, or none. */
  get lastClick() { return this.clicks[begun(this.clicks, this.now) - 1]; }

  forget() { this.run?.forget(); }
}

/** Start values but for those that say how a run was computed, as a page does not. */
function withoutSolver(start) {
  return Object.fromEntries(Object.entries(start).filter(([name]) => !name.startsWith("solver.")));
}

/** What `act` returns; null where the engine refuses, as a recording is played all the same. */
function unlessRefused(act) {
  try {
    return act();
  } catch (problem) {
    if (!(problem instanceof Refusal)) throw problem;
    return null;
  }
}

/** How many of these clicks have begun at `now`. */
const begun = (clicks, now) => countUpTo(clicks, now, ({ begin }) => begin);

/** A click of a recording, told as that of a live run in click.js. */
class RecordedClick {
  constructor(samples, { begin, end, pulses }, number) {
    const { times } = samples, length = end - begin; // from the last sample before it to the first one after it
    const from = Math.max(0, countUpTo(times, begin) - 2), to = Math.min(times.length, countUpTo(times, end) + 1);
    const resolved = length > 0 && to - from - 2 >= LEAST_SAMPLES * pulses.length;
    Object.assign(this, { samples, number, begin, end, length, pulses, range: [from, to], resolved, done: true,
      sampled: true });
  }

  get speeds() { return this.samples.speedsAt(this.begin); }
  get after() { return this.samples.speedsAt(this.end); }

  /** The largest velocity, force and overlap in it (SI); an overlap of 0 where that is not known. */
  get most() { return this.largest ??= this.findMost(); }

  get lowest() { return { velocity: smallest([this.speeds, this.after]) }; }

  findMost() {
    const { samples, pulses, speeds, after, range: [from, to] } = this, instants = Array.from({ length: to - from });
    const pressed = (_, k) =>
      samples.overlapsAt(samples.x.map((column) => column[from + k])).map((depth) => Math.max(0, depth));
    return { velocity: largest([speeds, after]), force: largest([pulses.map(({ peak }) => peak)]),
      overlap: samples.run ? Math.max(1e-9, largest(instants.map(pressed))) : 0 };
  }
}

/** What is drawn where no engine knows more than these sizes (m), and perhaps what a run was started with. */
function drawingOf(balls, radius, length, start) {
  const known = { "ball.mass": 1, "ball.massRatio": Array(balls).fill(1), ...start };
  const { "ball.mass": mass, "ball.massRatio": ratio, "pendulum.model": model } = known;
  return { balls, radius, mass, ratio, sizes: ratio.map(Math.cbrt), masses: ratio.map((part) => part * mass), length,
    rigid: false, swing: swingOf(length, model === "circular") };
}
