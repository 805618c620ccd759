// Tracks: what strips show of a whole recording, of a click, or of the recent past of a live run.

import { countUpTo, largest, linear, placeIn, smallest } from "#view/common.js";

const PARTS = ["kinetic", "gravity", "elastic"]; // of the energy
const LEAST = { velocity: 1e-3, force: 1e-9, energy: 1e-12, momentum: 1e-3 }; // smallest ends of scales, SI
const KEPT = 3000; // samples

export class Track {
  /** `times` (s) rise; `curves`: by kind, a column of samples for each; `parts`: what its curves of energy are;
   *  `masses` of the balls (kg), if they are known. */
  constructor(balls, times, curves, parts, masses = null) {
    Object.assign(this, { balls, times, curves, parts, masses, pulses: [], most: { ...LEAST, overlap: 1e-9 },
      lowest: { velocity: 0, momentum: 0 } });
  }

  pulsesIn(left, right) { return this.pulses.filter(({ onset, release }) => release >= left && onset <= right); }

  /** Raises the largest absolute value of this kind to that of these columns, and lowers the lowest one. */
  see(kind, columns) {
    this.most[kind] = Math.max(this.most[kind], largest(columns));
    if (kind in this.lowest) this.lowest[kind] = smallest(columns, this.lowest[kind]);
  }

  /** The force of a pulse as points [s, N]: from its onset through the samples within it and its peak to its release. A
   *  pulse `at` a time is not resolved by the samples: a spike. */
  shapeOf({ contact, onset, release, peak, peakTime, at }) {
    if (at !== undefined) return [[at, 0], [at, peak], [at, 0]];
    const { times } = this, force = this.curves.force[contact], points = [[onset, 0]];
    for (let k = countUpTo(times, onset); times[k] < release; k++) points.push([times[k], force[k]]);
    if (release === Infinity) return points; // it presses still
    points.push([release, 0]);
    const top = Number.isFinite(peakTime) ? peakTime : topOf(points);
    points.splice(points.findIndex(([time]) => time >= top), 0, [top, peak]);
    return points;
  }

  /** When the force of a pulse is largest (s), as far as the samples tell. */
  peakTime(pulse) {
    const points = this.shapeOf(pulse);
    return points.reduce((best, point) => (point[1] > best[1] ? point : best))[0];
  }

  /** Points [s, m/s] of the velocity of each ball between the samples where `pulses` begin and end. */
  stepsAt(pulses) {
    const { times, curves: { velocity }, masses } = this;
    const points = velocity.map(() => []), segments = velocity.map(() => new Map());
    for (const { contact, onset, release, impulse, at, between } of pulses) {
      const within = between ? [] : this.segmentsOf(onset, release);
      for (const [i, force] of [[contact, -impulse], [contact + 1, impulse]]) {
        for (const k of between ?? []) points[i].push([at, velocity[i][k]]);
        const step = { onset, release, change: force / masses?.[i] };
        for (const k of within) if (segments[i].has(k)) segments[i].get(k).push(step); else segments[i].set(k, [step]);
      }
    }
    velocity.forEach((v, i) => {
      for (const [k, steps] of segments[i])
        points[i].push(...stepped([times[k], v[k]], [times[k + 1], v[k + 1]], steps));
      points[i].sort(([a], [b]) => a - b);
    });
    return points;
  }

  /** The samples after which a pulse begins and ends, as long as another one follows. */
  segmentsOf(onset, release) {
    const { times } = this, instant = onset === release, found = [];
    for (const time of instant ? [onset] : [onset, release]) {
      const before = countUpTo(times, time) - 1, sampled = times[before] === time;
      const k = sampled && instant ? before - 1 : before; // a step at a sample is in what lies before it
      if (k >= 0 && k < times.length - 1 && (!sampled || instant) && k !== found[0]) found.push(k);
    }
    return found;
  }

  /** Of a kind, the value of curve `i` at a time; within `near` (s) of a shorter pulse, its peak. */
  valueAt(kind, i, time, near) {
    const short = kind === "force" ? this.pulsesIn(time - near, time + near)
      .filter(({ contact, onset, release, at }) => contact === i && (at ?? release) - (at ?? onset) < near) : [];
    return short.length ? Math.max(...short.map(({ peak }) => peak))
      : linear(this.curves[kind][i], placeIn(this.times, time));
  }
}

/** Where a force [s, N] given by points is largest: at the vertex of the parabola through the largest and those beside
 *  it. */
function topOf(points) {
  const k = points.reduce((best, [, force], k) => (force > points[best][1] ? k : best), 0);
  if (k === 0) return 0.5 * (points[0][0] + points.at(-1)[0]); // no samples within
  const [[a, fa], [b, fb], [c, fc]] = points.slice(k - 1, k + 2);
  const [left, right] = [(fb - fa) / (b - a), (fc - fb) / (c - b)], turn = left - right;
  return turn > 0 ? Math.min(c, Math.max(a, 0.5 * (a + b) + (0.5 * (c - a) * left) / turn)) : b;
}

/** Points of a velocity between two samples [s, m/s], by its steps {onset, release, change}, those at the same time as
 *  one; what they leave of the difference changes evenly. Where a change is not known, all of it is one step. */
function stepped([from, before], [to, after], all) {
  const steps = [];
  for (const step of all.sort((a, b) => a.onset - b.onset)) {
    const last = steps.at(-1);
    if (step.onset < last?.release)
      Object.assign(last, { release: Math.max(last.release, step.release), change: last.change + step.change });
    else steps.push({ ...step });
  }
  if (steps.some(({ change }) => !Number.isFinite(change))) {
    const last = Math.max(...steps.map(({ release }) => release));
    return [[last, before], [last, after]];
  }
  const done = ({ onset, release }, time, over) => (release > onset
    ? Math.min(1, Math.max(0, (time - onset) / (release - onset))) : Number(over ? time >= onset : time > onset));
  const changed = (time, over) =>
    steps.reduce((sum, step) => sum + step.change * (done(step, time, over) - done(step, from, false)), 0);
  const rate = (after - before - changed(to, true)) / (to - from);
  return steps.flatMap(({ onset, release }) => [[onset, false], [release, true]])
    .filter(([time]) => time >= from && time <= to)
    .map(([time, over]) => [time, before + rate * (time - from) + changed(time, over)]);
}

export class History extends Track {
  constructor(balls, masses) {
    const curves = (count) => Array.from({ length: count }, () => []);
    super(balls, [], { velocity: curves(balls), force: curves(balls - 1), energy: curves(PARTS.length),
      momentum: curves(1) }, PARTS, masses);
  }

  /** Adds the state at `time`, and pulses in the time of their run, which began at `origin`. */
  record(time, { v, F, energy, momentum, overlap, ...stored }, pulses = [], origin = 0) {
    const parts = PARTS.map((part) => Math.max(0, stored[part].reduce((a, b) => a + b, 0))), { times, curves } = this;
    const row = { velocity: v, force: F, energy: parts, momentum: [momentum] };
    if (times.at(-1) >= time) this.keep(0, times.findLastIndex((earlier) => earlier < time) + 1);
    times.push(time);
    for (const [kind, values] of Object.entries(row)) values.forEach((value, i) => curves[kind][i].push(value));
    this.pulses.push(...pulses.map((pulse) =>
      ({ ...pulse, onset: pulse.onset + origin, release: pulse.release + origin,
        peakTime: pulse.peakTime + origin })));
    if (times.length > 1.2 * KEPT) this.keep(times.length - KEPT, times.length);
    const seen = { ...row, force: [...F, ...pulses.map(({ peak }) => peak)], energy: [energy],
      overlap: overlap.map((depth) => Math.max(0, depth)) };
    for (const [kind, values] of Object.entries(seen)) this.see(kind, [values]);
  }

  /** Keeps the samples from this one to before that one, and pulses that have ended among them. */
  keep(from, to) {
    const [first, next] = [this.times[from], this.times[to] ?? Infinity];
    for (const column of [this.times, ...Object.values(this.curves).flat()])
      column.splice(0, column.length, ...column.slice(from, to));
    this.pulses = this.pulses.filter(({ release }) => release >= first && release < next);
  }

  /** The pulses that have ended, and those of contacts that still press. */
  pulsesIn(left, right) {
    const { times, curves: { force } } = this, last = times.length - 1, pressing = [];
    force.forEach((column, contact) => {
      if (!(column[last] > 0)) return;
      let k = last;
      while (k > 0 && column[k - 1] > 0) k--;
      pressing.push({ contact, onset: times[Math.max(0, k - 1)], release: Infinity, peak: largest([column.slice(k)]) });
    });
    return [...super.pulsesIn(left, right), ...pressing];
  }
}
