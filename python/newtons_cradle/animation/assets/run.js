// The numbers of a run, and what they are at any instant between its samples.

/** Undoes `packed` of page.py: base64, deflate, planes of bytes. */
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

class Run {
  /** From the JSON in the page. */
  static async load(json) {
    const run = new Run();
    for (const name of ["title", "balls", "length", "radius", "strength", "parameters"]) run[name] = json[name];
    run.time = await unpacked(json.time);
    for (const name of ["x", "v", "F"]) run[name] = run.split(await unpacked(json[name]));
    run.energy = {};
    for (const [name, values] of Object.entries(json.energy)) run.energy[name] = await unpacked(values);
    const pulses = {};
    for (const [name, values] of Object.entries(json.pulses)) pulses[name] = await unpacked(values);
    run.sortPulses(pulses);
    const impacts = await unpacked(json.impacts);
    run.clicks = Array.from({ length: impacts.length / 2 },
      (_, i) => new Click(run, i, impacts[2 * i], impacts[2 * i + 1]));
    run.begins = run.clicks.map((click) => click.begin);
    return run;
  }

  /** One array for each ball or contact. */
  split(values) {
    const samples = this.time.length;
    return Array.from({ length: values.length / samples }, (_, i) => values.subarray(i * samples, (i + 1) * samples));
  }

  /** The table of pulses by contact; `largest`: the largest force of the run (N), of rigid impacts the
   *  impulse (N.s). */
  sortPulses({ contact, onset, release, peak }) {
    this.pulses = Array.from({ length: Math.max(0, this.balls - 1) }, (_, i) => {
      const part = (column) => column.subarray(countUpTo(contact, i + 0.5), countUpTo(contact, i + 1.5));
      return { onset: part(onset), release: part(release), peak: part(peak) };
    });
    this.largest = peak.reduce((a, b) => Math.max(a, b), 0) || 1;
    this.shortest = onset.reduce((least, begin, i) => (release[i] > begin ? Math.min(least, release[i] - begin)
      : least), Infinity);
  }

  get start() { return this.time[0]; }
  get stop() { return this.time[this.time.length - 1]; }

  place(t) { return placeIn(this.time, t); }

  /** The click that began last at t; undefined before the first. */
  lastClick(t) { return this.clicks[countUpTo(this.begins, t) - 1]; }

  /** How brightly contact `i` shines at t, 0 to 1: its force, and what is left of its last pulse after `fade` (s). */
  glow(contact, t, fade, place) {
    const { onset, release, peak } = this.pulses[contact], last = countUpTo(onset, t) - 1;
    if (last < 0) return 0;
    if (t <= release[last] && onset[last] < release[last])
      return Math.max(0, linear(this.F[contact], place)) / this.largest;
    return (peak[last] / this.largest) * Math.exp(-3 * (t - release[last]) / fade);
  }
}

// ---- clicks, and the stages they come apart into: from one change of which contacts are closed to the next

const STAGE = 1.6;     // s on the viewer's clock that a stage takes, where there are few
const WITHIN = 20;     // s that all stages of a click take together at most
const APPROACH = 5;    // 1/s: nearing a stage, the distance to it shrinks at this rate

/** "1", "1 and 2", "1, 2 and 3". */
function listed(names) {
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
}

/** The balls that these contacts join: "balls 1 and 2, and 4 to 6". */
function touching(contacts) {
  const groups = [];
  for (const i of contacts.map(({ contact }) => contact + 1).sort((a, b) => a - b)) {
    const last = groups.at(-1);
    if (last && i <= last[1]) last[1] = i + 1; else groups.push([i, i + 1]);
  }
  return `balls ${groups.map(([a, b]) => `${a} ${b === a + 1 ? "and" : "to"} ${b}`).join(", and ")}`;
}

class Click {
  /** `number` counts from 0; `begin` and `end` in s. */
  constructor(run, number, begin, end) {
    Object.assign(this, { run, number, begin, end });
  }

  /** Rising in time: {from, to, contacts, struck}, pulses of closed contacts and rigid impacts that begin it; none
   *  where the click takes no time. */
  get stages() {
    return (this.cut ??= this.end > this.begin ? this.stagesOf(this.pulses()) : []);
  }

  pulses() {
    return this.run.pulses.flatMap(({ onset, release, peak }, contact) => {
      const upTo = countUpTo(onset, this.begin), first = onset[upTo - 1] === this.begin ? upTo - 1 : upTo;
      return Array.from(onset.subarray(first, countUpTo(onset, this.end)), (begin, k) => (
        { contact, onset: begin, release: release[first + k], peak: peak[first + k] }));
    });
  }

  /** Changes that follow each other within a small part of the shortest pulse count as one. */
  stagesOf(pulses) {
    const near = 0.01 * (pulses.reduce((least, { onset, release }) => Math.min(least, release - onset), Infinity)
      || 0.1 * (this.end - this.begin)), cuts = [];
    for (const t of pulses.flatMap(({ onset, release }) => [onset, release]).sort((a, b) => a - b)) {
      if (!cuts.length || t - cuts.at(-1) > near) cuts.push(t);
    }
    if (cuts.length < 2) return [];
    cuts[cuts.length - 1] = this.end;
    return cuts.slice(1).map((to, i) => {
      const from = cuts[i], middle = 0.5 * (from + to);
      return { from, to, contacts: pulses.filter(({ onset, release }) => onset <= middle && middle < release),
        struck: pulses.filter(({ onset, release }) => onset === release && onset >= from && onset <= from + near) };
    });
  }

  /** Why it cannot be looked into; "" where it can. */
  get closed() {
    if (this.end === this.begin) return "Rigid impacts take no time: there is nothing to look into.";
    const { time } = this.run, samples = countUpTo(time, this.end) - countUpTo(time, this.begin) + 1;
    if (samples < 2 * this.stages.length + 1) return "The samples do not resolve this click.";
    return "";
  }

  /** Seconds of the run per second of the viewer's at t, such that each stage takes as long; `base` far away. */
  speed(t, base) {
    const seconds = Math.min(STAGE, WITHIN / this.stages.length);
    return this.stages.reduce((speed, { from, to }) =>
      Math.min(speed, Math.max((to - from) / seconds, APPROACH * Math.max(from - t, t - to, 0))), base);
  }

  /** The stage at t: its place, -1 before the click and the number of stages after it. */
  stageAt(t) {
    if (t < this.begin) return -1;
    const place = this.stages.findIndex(({ to }) => t < to);
    return place < 0 ? this.stages.length : place;
  }

  /** What happens at t, in words. */
  caption(t) {
    const { stages, run } = this, place = this.stageAt(t), name = `Click ${this.number + 1} of ${run.clicks.length}`;
    if (place < 0) return `${name}: ${this.movers(this.begin - 2e-9, "arrive")} at ${this.pace}.`;
    if (place === stages.length) {
      const leaving = this.movers(this.end, "leave");
      return `${name} took ${withPrefix(this.end - this.begin, "s")}: ${leaving} at ${this.pace}.`;
    }
    const { from, to, contacts, struck } = stages[place], head = `${name}, stage ${place + 1} of ${stages.length}`;
    if (!contacts.length) {
      const collided = struck.length ? `${touching(struck)} have collided` : "no balls touch";
      return `${head}: ${collided}; ${this.movers(0.5 * (from + to), "move")}.`;
    }
    const largest = Math.max(...contacts.map(({ peak }) => peak)), force = `up to ${withPrefix(largest, "N")}`;
    return `${head}: ${touching(contacts)} press each other, ${force}.`;
  }

  /** The balls that move at t, and what they do; sets `pace`, how fast. */
  movers(t, verb) {
    const place = this.run.place(t), speeds = this.run.v.map((column) => Math.abs(linear(column, place)));
    const fastest = Math.max(...speeds), moving = speeds.flatMap((speed, i) => (speed > 0.05 * fastest ? [i + 1] : []));
    const alike = moving.every((i) => speeds[i - 1] > 0.98 * fastest);
    this.pace = `${alike ? "" : "up to "}${withPrefix(fastest, "m/s")}`;
    if (moving.length > 5)
      return `${moving.length === speeds.length ? "all" : `${moving.length} of ${speeds.length}`} balls ${verb}`;
    return moving.length === 1 ? `ball ${moving[0]} ${verb}s` : `balls ${listed(moving)} ${verb}`;
  }
}
