// A recorded source: a run from a file, for the same player and scene as a live one.

import { Refusal, State } from "#engine/engine.js";
import { cubic, linear, placeIn } from "#view/common.js";
import { say } from "#view/texts.js";

export class Recording {
  /** From the text of a CSV file: columns time, x[1], x[2], ..., and v, F if there are. Throws Refusal. */
  constructor(name, text) {
    const [header, ...lines] = text.trim().split(/\r?\n/).filter((line) => !line.startsWith("#"));
    const names = (header ?? "").split(",").map((title) => title.trim().replace(/"/g, ""));
    const table = lines.map((line) => line.split(",").map(Number)), at = names.indexOf("time");
    this.times = table.map((row) => row[at]);
    const column = (kind) => names.filter((title) => new RegExp(`^${kind}\\[\\d+\\]$`).test(title))
      .sort((a, b) => parseInt(a.slice(2)) - parseInt(b.slice(2)))
        .map((title) => table.map((row) => row[names.indexOf(title)]));
    const x = column("x"), v = column("v"), F = column("F");
    const rising = this.times.length > 1 && this.times.every((time, k) => !k || time > this.times[k - 1]);
    if (!x.length || !rising || !x.flat().every(Number.isFinite))
      throw new Refusal(say("badFile", { file: name, reason: say("columns") }));
    Object.assign(this, { live: false, account: false, name, balls: x.length, table: { x, v, F },
      state: new State(x.length), origin: 0 });
    this.go(this.times[0]);
  }

  get time() { return this.origin + this.now; }

  get drawing() {
    const reach = Math.max(0.01, ...this.table.x.flat().map(Math.abs));
    return { balls: this.balls, radius: 0.03, mass: 1, ratio: Array(this.balls).fill(1),
      length: Math.max(0.4, 2 * reach), rigid: false, reach: 0.5 };
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

  go(now) {
    const { times, table, state } = this, place = placeIn(times, now);
    table.x.forEach((x, i) => {
      const v = table.v[i];
      state.x[i] = v ? cubic(x, v, place) : linear(x, place);
      state.v[i] = v ? linear(v, place) : (x[place.i + 1] - x[place.i]) / place.h;
    });
    table.F.slice(0, state.F.length).forEach((F, i) => { state.F[i] = linear(F, place); });
    this.now = now;
  }

  takePulses() { return []; }
  ahead() { return null; }
  get shownClick() { return null; }
  forget() {}
}
