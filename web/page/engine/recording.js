// A recorded source: a run from the page's data or from a file, for the same player and scene as a live one.

import { LONGEST, QUIET, QUIET_LEAST } from "#engine/click.js";
import { State } from "#engine/engine.js";
import { LEAST } from "#engine/history.js";
import { Setup } from "#engine/setup.js";
import { fromCsv } from "#engine/table.js";
import { countUpTo, cubic, largest, linear, placeIn } from "#view/common.js";
import { inflated } from "#view/elements.js";

const LEAST_SAMPLES = 2; // of each pulse of a click that can be looked into

export class Recording {
  /** From what page.py has packed into the page. */
  static async load(json) {
    const data = { ...json, time: await unpacked(json.time) }, { length: samples } = data.time;
    for (const name of ["x", "v", "F"]) {
      const values = await unpacked(json[name]), count = values.length / samples;
      data[name] = Array.from({ length: count }, (_, i) => values.subarray(i * samples, (i + 1) * samples));
    }
    for (const name of ["energy", "pulses"]) {
      const columns = Object.entries(json[name]).map(async ([key, packed]) => [key, await unpacked(packed)]);
      data[name] = Object.fromEntries(await Promise.all(columns));
    }
    const { contact, onset, release, peak } = data.pulses;
    data.pulses = Array.from(onset, (begin, i) =>
      ({ contact: contact[i] - 1, onset: begin, release: release[i], peak: peak[i] }));
    return new Recording(data);
  }

  /** From the text of a CSV file. Throws Refusal. */
  static read(file, text) { return new Recording(fromCsv(file, text)); }

  /** `pulses`: {contact, from 0, onset, release, peak}. `start`: what it was run with, if that is known. */
  constructor({ title, balls, time, x, v, F, energy, pulses, parameters = [], length, radius, start }) {
    const made = start ? new Setup(balls, start) : null, [begin, end] = [time[0], time.at(-1)], extent = largest(x);
    const sizes = { "pendulum.length": length ?? Math.max(0.4, 2 * extent), "ball.radius": radius ?? 0.03 };
    const { drawing } = made ?? new Setup(balls, sizes), strings = Math.max(drawing.length, extent / 1.1);
    const rigid = pulses.length > 0 && largest(F) === 0 && pulses.every(({ onset, release }) => onset === release);
    this.drawing = { ...drawing, length: strings, rigid, reach: extent / strings };
    Object.assign(this, { live: false, account: false, origin: 0, name: title, balls, times: time, x, parameters, made,
      begin, end });
    this.follow({ velocity: v, force: F, energy: Object.values(energy) }, Object.keys(energy), pulses);
    this.findClicks(pulses);
    this.state = new State(balls);
    this.seek(begin);
  }

  /** Makes a track of these curves, see history.js. */
  follow(curves, parts, pulses) {
    const { made, times, drawing: { mass, ratio } } = this, { velocity, energy } = curves;
    const sum = (columns, weight = () => 1) => times.map((_, k) =>
      columns.reduce((sum, column, i) => sum + weight(i) * column[k], 0));
    curves.momentum = made ? [sum(velocity, (i) => ratio[i] * mass)] : [];
    const seen = { ...curves, force: [...curves.force, pulses.map(({ peak }) => peak)], energy: [sum(energy)] };
    const kinds = Object.keys(curves), by = (of) => Object.fromEntries(kinds.map((kind) => [kind, of(kind)]));
    Object.assign(this, { curves, parts, counts: by((kind) => curves[kind].length),
      most: by((kind) => largest(seen[kind]) || LEAST[kind]) });
  }

  /** Where the clicks are, and pulses by their releases. */
  findClicks(pulses) {
    const column = (items, name) => Float64Array.from(items, (item) => item[name]);
    // A half-sine's impulse, as the peak is what is known; of rigid impacts, it is the impulse.
    for (const pulse of pulses)
      pulse.impulse = (2 / Math.PI) * pulse.peak * (pulse.release - pulse.onset) || pulse.peak;
    this.pulses = pulses.sort((a, b) => a.onset - b.onset || a.release - b.release);
    this.onsets = column(pulses, "onset");
    this.finished = [...pulses].sort((a, b) => a.release - b.release);
    this.releases = column(this.finished, "release");
    this.longest = pulses.reduce((most, pulse) => Math.max(most, pulse.release - pulse.onset), 0);
    this.clicks = [];
    for (const pulse of pulses) {
      const click = this.clicks.at(-1), quiet = click && Math.max(QUIET * click.length, QUIET_LEAST);
      if (click && pulse.onset - click.end <= quiet && pulse.onset - click.begin <= LONGEST) click.take(pulse);
      else this.clicks.push(new RecordedClick(this, pulse, this.clicks.length));
    }
    this.openable = this.clicks.filter((click) => click.resolved);
    this.begins = column(this.clicks, "begin");
    this.openableBegins = column(this.openable, "begin");
  }

  get time() { return this.now; }

  /** Moves on to `time` (s), at most to the end. */
  advance(time) { this.go(Math.min(time, this.end)); }

  /** To any time of the run. */
  seek(time) {
    this.go(Math.min(Math.max(time, this.begin), this.end));
    this.told = this.now;
  }

  go(now) {
    const { times, x, curves: { velocity: v, force: F }, state, made } = this, place = placeIn(times, now);
    x.forEach((column, i) => {
      state.x[i] = cubic(column, v[i], place);
      state.v[i] = linear(v[i], place);
    });
    F.forEach((column, i) => { state.F[i] = linear(column, place); });
    state.closed.fill(0);
    const click = this.clicks[countUpTo(this.begins, now) - 1];
    for (const { contact, onset, release } of click && now < click.end ? click.pulses : [])
      if (onset <= now && now < release) state.closed[contact] = 1;
    if (made) state.overlap.forEach((_, i) => { state.overlap[i] = this.overlap(i, state.x[i] - state.x[i + 1]); });
    this.now = now;
  }

  /** How far contact `i` is pressed together (m) when its balls have come `nearer` by so much than they hang. */
  overlap(i, nearer) {
    return nearer - this.made.get("contact.deadBand") - (this.made.values["contact.gap"]?.[i] ?? 0);
  }

  /** Pulses that have finished since the last call. */
  takePulses() {
    const { releases, finished, told, now } = this;
    this.told = now;
    return now > told ? finished.slice(countUpTo(releases, told), countUpTo(releases, now)) : [];
  }

  // ---- as a track, see history.js

  value(kind, i, k) { return this.curves[kind][i][k]; }

  pulsesIn(left, right) {
    return this.pulses.slice(countUpTo(this.onsets, left - this.longest), countUpTo(this.onsets, right))
      .filter(({ release }) => release >= left);
  }

  // ---- clicks that can be looked into

  /** The last that has begun, and the next one. */
  get around() {
    const i = countUpTo(this.openableBegins, this.now);
    return [this.openable[i - 1], this.openable[i]];
  }

  /** The next click, or the one that lasts; null if there is none. */
  ahead() {
    const [last, next] = this.around, click = last && this.now <= last.end + 0.05 * last.length ? last : next;
    return click ? { distance: Math.max(click.begin - this.now, 0), length: click.length, done: true } : null;
  }

  /** The click that the time shown is in, or is nearest to. */
  get shownClick() {
    const [past, next] = this.around;
    return past && !(next && next.begin - this.now < this.now - past.end) ? past : next ?? null;
  }

  /** The click that began last, or none. */
  get lastClick() { return this.clicks[countUpTo(this.begins, this.now) - 1]; }

  forget() {}
}

/** A click of a recording, told as that of a live run in click.js. */
class RecordedClick {
  constructor(recording, first, number) {
    Object.assign(this, { samples: recording, number, begin: first.onset, end: first.release, pulses: [first],
      done: true, sampled: true });
  }

  take(pulse) {
    this.pulses.push(pulse);
    this.end = Math.max(this.end, pulse.release);
  }

  get length() { return this.end - this.begin; }

  /** From the last sample before it to the first one after it. */
  get range() {
    const { times } = this.samples;
    return [Math.max(0, countUpTo(times, this.begin) - 2), Math.min(times.length, countUpTo(times, this.end) + 1)];
  }

  /** Whether it can be looked into. */
  get resolved() {
    const [from, to] = this.range;
    return this.length > 0 && to - from - 2 >= LEAST_SAMPLES * this.pulses.length;
  }

  get speeds() { return this.velocities(this.begin); }
  get after() { return this.velocities(this.end); }

  velocities(time) {
    const place = placeIn(this.samples.times, time);
    return this.samples.curves.velocity.map((column) => linear(column, place));
  }

  /** The largest velocity, force and overlap in it (SI), looked for once; an overlap of 0 where that is not known. */
  get most() { return (this.found ??= this.measure()); }

  measure() {
    const { samples, range: [from, to] } = this, { x, curves: { velocity, force }, made } = samples;
    const most = (columns) => Math.max(1e-9, largest(columns.map((column) => column.subarray(from, to))));
    const pressed = force.map((column, i) =>
      column.map((_, k) => Math.max(0, samples.overlap(i, x[i][k] - x[i + 1][k]))));
    return { velocity: most(velocity), force: most(force), overlap: made ? most(pressed) : 0 };
  }
}

/** Undoes `packed` of page.py: base64, deflate, planes of bytes. */
async function unpacked({ kind, data }) {
  const planes = new Uint8Array(await inflated(data, "deflate").arrayBuffer());
  const size = kind === "f8" ? 8 : 4, count = planes.length / size, mixed = new Uint8Array(planes.length);
  for (let plane = 0; plane < size; plane++) {
    for (let i = 0; i < count; i++) mixed[i * size + plane] = planes[plane * count + i];
  }
  return kind === "f8" ? new Float64Array(mixed.buffer) : new Float32Array(mixed.buffer);
}
