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
    run.clicks = Array.from({ length: impacts.length / 2 }, (_, i) => new Click(run, i, impacts[2 * i], impacts[2 * i + 1]));
    run.begins = run.clicks.map((click) => click.begin);
    return run;
  }

  /** One array for each ball or contact. */
  split(values) {
    const samples = this.time.length;
    return Array.from({ length: values.length / samples }, (_, i) => values.subarray(i * samples, (i + 1) * samples));
  }

  /** The table of pulses by contact; `largest`: the largest force of the run (N), of rigid impacts the impulse (N.s). */
  sortPulses({ contact, onset, release, peak }) {
    this.pulses = Array.from({ length: Math.max(0, this.balls - 1) }, (_, i) => {
      const part = (column) => column.subarray(countUpTo(contact, i + 0.5), countUpTo(contact, i + 1.5));
      return { onset: part(onset), release: part(release), peak: part(peak) };
    });
    this.largest = peak.reduce((a, b) => Math.max(a, b), 0) || 1;
    this.shortest = onset.reduce((least, begin, i) => (release[i] > begin ? Math.min(least, release[i] - begin) : least), Infinity);
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
    if (t <= release[last] && onset[last] < release[last]) return Math.max(0, linear(this.F[contact], place)) / this.largest;
    return (peak[last] / this.largest) * Math.exp(-3 * (t - release[last]) / fade);
  }
}
