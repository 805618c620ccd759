// A recorded source: a run from a file, for the same player and scene as a live one.

const NAMES = { x: /^x\[(\d+)\]$/, v: /^v\[(\d+)\]$/, F: /^F\[(\d+)\]$/ };

class Recording {
  /** From the text of a CSV file: columns time, x[1], x[2], ..., and v, F if there are. Throws Refusal. */
  constructor(name, text) {
    const [header, ...lines] = text.trim().split(/\r?\n/).filter((line) => !line.startsWith("#"));
    const names = (header ?? "").split(",").map((title) => title.trim().replace(/"/g, ""));
    const table = lines.map((line) => line.split(",").map(Number)), at = names.indexOf("time");
    this.times = table.map((row) => row[at]);
    const column = (kind) => names.flatMap((title, i) => { const found = title.match(NAMES[kind]); return found ? [[Number(found[1]), i]] : []; })
      .sort((a, b) => a[0] - b[0]).map(([, i]) => table.map((row) => row[i]));
    const x = column("x"), v = column("v"), F = column("F");
    const rising = this.times.length > 1 && this.times.every((time, k) => !k || time > this.times[k - 1]);
    if (!x.length || !rising || !x.flat().every(Number.isFinite)) throw new Refusal(say("badFile", name, say("columns")));
    Object.assign(this, { name, balls: x.length, table: { x, v, F }, state: new State(x.length), fresh: [], origin: 0 });
    this.go(this.times[0]);
  }

  get live() { return false; }
  get account() { return false; }
  get time() { return this.origin + this.now; }

  get drawing() {
    const reach = Math.max(0.01, ...this.table.x.flat().map(Math.abs));
    return { balls: this.balls, radius: 0.03, mass: 1, ratio: Array(this.balls).fill(1), length: Math.max(0.4, 2 * reach), gravity: 9.81, rigid: false, reach: 0.5 };
  }

  /** Moves on to `time` on the clock of the page; after the end it begins again. */
  advance(time) {
    let now = time - this.origin;
    if (now > this.times.at(-1)) {
      this.origin += this.times.at(-1) - this.times[0];
      now = Math.min(time - this.origin, this.times.at(-1));
    }
    this.go(now);
    this.origin = time - this.now;
  }

  /** Between samples the cubic through both positions and velocities (Hermite), where there are velocities. */
  go(now) {
    const { times, table, state } = this;
    let k = Math.max(0, Math.min(times.length - 2, this.at ?? 0));
    if (now < times[k]) k = 0;
    while (k < times.length - 2 && times[k + 1] <= now) k++;
    const h = times[k + 1] - times[k], part = Math.max(0, Math.min(1, (now - times[k]) / h)), rest = 1 - part;
    const between = (column) => rest * column[k] + part * column[k + 1];
    table.x.forEach((x, i) => {
      const v = table.v[i];
      state.x[i] = v
        ? x[k] * (1 + 2 * part) * rest * rest + x[k + 1] * (3 - 2 * part) * part * part + h * part * rest * (v[k] * rest - v[k + 1] * part)
        : between(x);
      state.v[i] = v ? between(v) : (x[k + 1] - x[k]) / h;
    });
    table.F.slice(0, state.F.length).forEach((F, i) => { state.F[i] = between(F); });
    Object.assign(this, { at: k, now });
  }

  takePulses() { return []; }
  wantsClick() {}
  prepare() {}
  ahead() { return null; }
  get shownClick() { return null; }
  forget() {}
}
