// A recorded source: a run from the page's data or from a file, for the same player and scene as a live one.

import { LONGEST, QUIET, QUIET_LEAST } from "#engine/click.js";
import { State } from "#engine/engine.js";
import { Track } from "#engine/history.js";
import { Setup } from "#engine/setup.js";
import { fromCsv, runOf } from "#engine/table.js";
import { columnsOf, countUpTo, cubic, largest, linear, placeIn } from "#view/common.js";

const LEAST_SAMPLES = 2; // of each pulse of a click that can be looked into
const RESOLVED = 4;      // samples that show the shape of a pulse

export class Recording extends Track {
  /** From the data that page.py has packed into the page. */
  static async load({ time, samples, pulses, ...known }) {
    const [times, columns, table] = await Promise.all([time, samples, pulses].map(columnsOf));
    const rows = Array.from(table.get("contact"), (contact, i) => ({ contact: contact - 1, onset: table.get("onset")[i],
      release: table.get("release")[i], peak: table.get("peak")[i], impulse: table.get("impulse")[i] }));
    return new Recording({ ...runOf(new Map([...times, ...columns])), pulses: rows, ...known });
  }

  /** From the text of a CSV file. Throws Refusal. */
  static read(file, text) { return new Recording({ title: file, ...fromCsv(file, text) }); }

  /** `pulses`: {contact, from 0, onset, release, peak, impulse}. `start`: what it was run with, if that is known. */
  constructor({ title, balls, time, x, v, F, energy, pulses, parameters = [], length, radius, start }) {
    const sizes = { "pendulum.length": length, "ball.radius": radius }, setup = start ? new Setup(balls, start) : null;
    const known = setup ?? new Setup(balls, sizes), extent = largest(x);
    const { drawing } = known.with({ "pendulum.length": Math.max(known.get("pendulum.length"), extent / 1.1) });
    const sum = (columns) => time.map((_, k) => columns.reduce((sum, column) => sum + column[k], 0));
    const momenta = v.map((column, i) => column.map((speed) => drawing.masses[i] * speed));
    super(balls, time, { velocity: v, force: F, energy: Object.values(energy), momentum: setup ? [sum(momenta)] : [] },
      Object.keys(energy), setup && drawing.masses);
    const rigid = pulses.length > 0 && largest(F) === 0 && pulses.every(({ onset, release }) => onset === release);
    this.drawing = { ...drawing, rigid, reach: drawing.swing.angle(extent) };
    Object.assign(this, { live: false, account: false, origin: 0, name: title, x, parameters, setup,
      begin: time[0], end: time.at(-1), state: new State(balls) });
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
    const { times, x, curves: { velocity: v, force: F }, state, setup } = this, place = placeIn(times, now);
    this.now = now;
    state.x.set(x.map((column, i) => cubic(column, v[i], place)));
    state.v.set(this.speedsAt(now));
    state.F.set(F.map((column) => linear(column, place)));
    state.closed.fill(0);
    for (const { contact, onset, release } of this.lastClick?.pulses ?? [])
      if (onset <= now && now < release) state.closed[contact] = 1;
    if (setup) state.overlap.set(F.map((_, i) => this.overlap(i, state.x[i], state.x[i + 1])));
  }

  /** Overlap of contact `i` (m) at these deflections of its balls. */
  overlap(i, left, right) {
    const { setup, setup: { swings } } = this, heights = [left, right].map((x, k) => {
      const { angle, height } = swings[i + k];
      return height(angle(x));
    });
    const radii = setup.get("ball.radiusRatio"), gap = setup.values["contact.gap"][i];
    const rest = (radii[i] + radii[i + 1]) * setup.get("ball.radius") + gap;
    const apart = right - left, up = heights[1] - heights[0], distance = Math.hypot(rest + apart, up);
    return -(apart * (2 * rest + apart) + up * up) / (distance + rest) - gap - setup.get("contact.deadBand");
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

  /** The last that has begun, and the next one. */
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

  forget() {}
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
  get most() {
    const { samples, pulses, speeds, after, range } = this, part = (i) => samples.x[i].subarray(...range);
    const pressed = (_, i) => part(i).map((place, k) => Math.max(1e-9, samples.overlap(i, place, part(i + 1)[k])));
    return { velocity: largest([speeds, after]), force: largest([pulses.map(({ peak }) => peak)]),
      overlap: samples.setup ? largest(samples.curves.force.map(pressed)) : 0 };
  }
}
