// A recorded source: a run from the page's data or from a file, for the same player and scene as a live one.

import { LONGEST, QUIET, QUIET_LEAST } from "#engine/click.js";
import { fromCsv } from "#engine/table.js";
import { Setup } from "#engine/setup.js";
import { countUpTo, cubic, linear, placeIn } from "#view/common.js";

const LEAST_SAMPLES = 2; // of each pulse of a click that can be looked into

export class Recording {
  /** From what recording.py has packed into the page. */
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
    return new Recording(data);
  }

  /** From the text of a CSV file. Throws Refusal. */
  static read(file, text) { return new Recording(fromCsv(file, text)); }

  constructor({ title, balls, time, x, v, F, energy, pulses, parameters, length, radius, start }) {
    const made = start ? new Setup(balls, start) : null; // what it was run with, if that is known
    Object.assign(this, { live: false, account: false, origin: 0, name: title, balls, times: time, columns: { x, v, F },
      energy, parameters, length, radius, made, begin: time[0], end: time.at(-1) });
    this.masses = made?.get("ball.massRatio").map((ratio) => ratio * made.get("ball.mass"));
    this.measure(pulses);
    this.sortPulses(pulses);
    const numbers = (count) => new Float64Array(count);
    this.state = { balls, x: numbers(balls), v: numbers(balls), F: numbers(balls - 1), overlap: numbers(balls - 1),
      closed: numbers(balls - 1) };
    this.seek(this.begin);
  }

  measure(pulses) {
    const { columns: { x, v, F }, energy, masses } = this, parts = Object.values(energy);
    const most = (columns) => columns.reduce((most, column) => column.reduce((a, b) => Math.max(a, Math.abs(b)), most), 0);
    const sum = (k) => parts.reduce((total, part) => total + part[k], 0);
    this.extent = most(x);
    this.rigid = F.length > 0 && pulses.onset.length > 0 && most(F) === 0 && pulses.onset.every((t, i) => t === pulses.release[i]);
    this.parts = Object.keys(energy);
    this.counts = { velocity: v.length, force: F.length, energy: parts.length, momentum: masses ? 1 : 0 };
    const momentum = masses ? this.times.reduce((most, _, k) => Math.max(most, Math.abs(this.value("momentum", 0, k))), 0) : 0;
    this.most = { velocity: most(v) || 1e-9, force: Math.max(most(F), most([pulses.peak])) || 1e-9,
      energy: parts.length ? this.times.reduce((most, _, k) => Math.max(most, sum(k)), 0) || 1e-12 : 1,
      momentum: momentum || 1e-12 };
  }

  /** Pulses by onset, the order of their releases, and where the clicks are. */
  sortPulses({ contact, onset, release, peak }) {
    this.pulses = Array.from(onset, (begin, i) => ({ contact: contact[i] - 1, onset: begin, release: release[i],
      peak: peak[i] })).sort((a, b) => a.onset - b.onset || a.release - b.release);
    this.onsets = Float64Array.from(this.pulses, (pulse) => pulse.onset);
    this.finished = [...this.pulses].sort((a, b) => a.release - b.release);
    this.releases = Float64Array.from(this.finished, (pulse) => pulse.release);
    this.longest = this.pulses.reduce((most, pulse) => Math.max(most, pulse.release - pulse.onset), 0);
    this.clicks = [];
    this.pulses.forEach((pulse, i) => {
      const click = this.clicks.at(-1), quiet = click && Math.max(QUIET * click.length, QUIET_LEAST);
      if (click && pulse.onset - click.end <= quiet && pulse.onset - click.begin <= LONGEST) click.take(pulse);
      else this.clicks.push(new RecordedClick(this, pulse, i, this.clicks.length));
    });
    this.openable = this.clicks.filter((click) => click.resolved);
    this.begins = Float64Array.from(this.clicks, (click) => click.begin);
    this.openableBegins = Float64Array.from(this.openable, (click) => click.begin);
  }

  get time() { return this.now; }

  get drawing() {
    const { made, extent, balls } = this, length = made?.get("pendulum.length") ?? this.length ?? Math.max(0.4, 2 * extent);
    return { balls, mass: made?.get("ball.mass") ?? 1, ratio: made?.get("ball.massRatio") ?? Array(balls).fill(1),
      radius: made?.get("ball.radius") ?? this.radius ?? 0.03, length: Math.max(length, extent / 1.1), rigid: this.rigid,
      reach: extent / Math.max(length, extent / 1.1) };
  }

  /** Moves on to `time` (s), at most to the end. */
  advance(time) { this.go(Math.min(time, this.end)); }

  /** To any time of the run. */
  seek(time) {
    this.go(Math.min(Math.max(time, this.begin), this.end));
    this.told = this.now;
  }

  go(now) {
    const { times, columns: { x, v, F }, state, made } = this, place = this.place = placeIn(times, now);
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

  value(kind, i, k) {
    const { columns: { v, F }, masses } = this;
    if (kind === "velocity") return v[i][k];
    if (kind === "force") return F[i][k];
    if (kind === "energy") return this.energy[this.parts[i]][k];
    return masses.reduce((sum, mass, ball) => sum + mass * v[ball][k], 0);
  }

  pulsesIn(left, right) {
    return this.pulses.slice(countUpTo(this.onsets, left - this.longest), countUpTo(this.onsets, right))
      .filter(({ release }) => release >= left);
  }

  // ---- clicks

  /** The next click that can be looked into, or the one that lasts; null if there is none. */
  ahead() {
    const i = countUpTo(this.openableBegins, this.now), last = this.openable[i - 1];
    const click = last && this.now <= last.end + 0.05 * last.length ? last : this.openable[i];
    return click ? { distance: Math.max(click.begin - this.now, 0), length: click.length, done: true } : null;
  }

  /** The click that the time shown is in, or is nearest to. */
  get shownClick() {
    const i = countUpTo(this.openableBegins, this.now), past = this.openable[i - 1], next = this.openable[i];
    return past && !(next && next.begin - this.now < this.now - past.end) ? past : next ?? null;
  }

  /** The click that began last, or none. */
  get lastClick() { return this.clicks[countUpTo(this.begins, this.now) - 1]; }

  forget() {}
}

/** A click of a recording, told as that of a live run in click.js. */
class RecordedClick {
  constructor(recording, pulse, first, number) {
    Object.assign(this, { recording, first, number, count: 0, begin: pulse.onset, end: pulse.onset, done: true,
      sampled: true });
    this.take(pulse);
  }

  take(pulse) {
    this.count += 1;
    this.end = Math.max(this.end, pulse.release);
  }

  get length() { return this.end - this.begin; }

  get pulses() { return (this.own ??= this.recording.pulses.slice(this.first, this.first + this.count)); }

  get samples() { return this.recording; }

  /** From the last sample before it to the first one after it. */
  get range() {
    const { times } = this.recording;
    return [Math.max(0, countUpTo(times, this.begin) - 2), Math.min(times.length, countUpTo(times, this.end) + 1)];
  }

  /** Whether it can be looked into. */
  get resolved() {
    const [from, to] = this.range;
    return this.length > 0 && to - from - 2 >= LEAST_SAMPLES * this.count;
  }

  get speeds() { return this.velocities(this.begin); }
  get after() { return this.velocities(this.end); }

  velocities(time) {
    const place = placeIn(this.recording.times, time);
    return this.recording.columns.v.map((column) => linear(column, place));
  }

  get fastest() { return this.most.velocity; }
  get strongest() { return this.most.force; }
  /** The deepest overlap (m); 0 where that is not known. */
  get widest() { return this.most.overlap; }

  /** Looked for once. */
  get most() {
    const { columns: { x, v, F }, made } = this.recording, [from, to] = this.range;
    if (this.known) return this.known;
    const known = this.known = { velocity: 1e-9, force: 1e-9, overlap: made ? 1e-9 : 0 };
    for (let k = from; k < to; k++) {
      for (const column of v) known.velocity = Math.max(known.velocity, Math.abs(column[k]));
      F.forEach((column, i) => {
        known.force = Math.max(known.force, column[k]);
        if (made) known.overlap = Math.max(known.overlap, this.recording.overlap(i, x[i][k] - x[i + 1][k]));
      });
    }
    return known;
  }
}

/** Undoes `packed` of recording.py: base64, deflate, planes of bytes. */
async function unpacked({ kind, data }) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = kind === "f8" ? 8 : 4, count = planes.length / size, mixed = new Uint8Array(planes.length);
  for (let plane = 0; plane < size; plane++) {
    for (let i = 0; i < count; i++) mixed[i * size + plane] = planes[plane * count + i];
  }
  return kind === "f8" ? new Float64Array(mixed.buffer) : new Float32Array(mixed.buffer);
}
