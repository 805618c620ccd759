// The engine: WebAssembly behind plain objects. SI units throughout.

export const EFFORT = 1500; // of one call, about 0.15 ms

/** A refusal or failure of the engine, in its own words. */
export class Refusal extends Error {}

/** The compiled engine. Its functions are those of web/src/lib.rs. */
export class Engine {
  static async load(bytes) {
    const { instance: { exports } } = await WebAssembly.instantiate(bytes, {});
    return Object.assign(new Engine(), { functions: exports });
  }

  /** The engine's last "text" or "numbers", until the next call. */
  left(name, Kind) {
    const place = BigInt.asUintN(64, this.functions[name]());
    return new Kind(this.functions.memory.buffer, Number(place >> 32n), Number(place & 0xffffffffn));
  }

  get text() { return new TextDecoder().decode(this.left("text", Uint8Array)); }
  get numbers() { return this.left("numbers", Float64Array); }

  /** The default of each parameter by its name, as in a recipe of two balls. */
  defaults() {
    this.functions.defaults();
    return JSON.parse(this.text).start;
  }

  /** Starts a run from an FMU's recipe {balls, start}; its `warnings`: a text. Throws Refusal. */
  start({ balls, start }) {
    const recipe = new TextEncoder().encode(JSON.stringify({ format: 1, balls, start }));
    this.functions.make_room(recipe.length);
    this.left("text", Uint8Array).set(recipe);
    const number = this.functions.start();
    if (number < 0) throw new Refusal(this.text);
    return Object.assign(new Run(this, number, balls), { warnings: this.text });
  }
}

/** The values of a run at one time: sums, and a part of `numbers` for each quantity of balls and contacts. */
export class State {
  constructor(balls) {
    const counts = [...Array(4).fill(balls), ...Array(4).fill(balls - 1)], numbers = new Float64Array(8 * balls + 4);
    let at = 8;
    const parts = counts.map((count) => numbers.subarray(at, (at += count)));
    Object.assign(this, { balls, numbers });
    [this.x, this.v, this.kinetic, this.gravity, this.F, this.overlap, this.elastic, this.closed] = parts;
  }

  /** Copies numbers: of the whole in s, J, N.s and N, then the parts. */
  read(numbers) {
    this.numbers.set(numbers);
    [this.time, this.energy, this.dissipated, this.work, this.residual, this.momentum, this.supportForce, this.events] =
      numbers;
    return this;
  }

  /** Whether all contacts are open. */
  get apart() { return this.closed.every((closed) => !closed); }
}

/** One run of a cradle. It lives until `forget`. */
class Run {
  constructor(engine, number, balls, time = 0) {
    Object.assign(this, { engine, number, balls, time, shown: new State(balls), pulses: [] });
  }

  /** Moves on to `time`, until an `effort` (about 0.1 us each) is spent or, if it `stops` there, balls touch or part.
   *  The time reached. Throws Refusal. */
  advance(time, effort = Infinity, stops = false) {
    if (!(time > this.time)) return this.time;
    const { engine } = this;
    const reached = engine.functions.advance(this.number, time, Math.min(effort, Number.MAX_SAFE_INTEGER), stops);
    for (let numbers = engine.numbers; numbers.length; numbers = numbers.subarray(6)) {
      const [contact, onset, release, peak, peakTime, impulse] = numbers;
      this.pulses.push({ contact, onset, release, peak, peakTime, impulse });
    }
    if (Number.isNaN(reached)) throw new Refusal(engine.text);
    return (this.time = reached);
  }

  /** Places the balls anew, at positions (m) and velocities (m/s); those of `targets`, {ball: m}, are taken there by a
   *  hand in so many `seconds`, and nothing stops them. Throws Refusal. */
  setMotion(x, v, targets = new Map(), seconds = 0) {
    const { engine, balls } = this;
    engine.functions.make_numbers(3 * balls);
    engine.numbers.set([...x, ...v, ...Array.from({ length: balls }, (_, i) => targets.get(i) ?? NaN)]);
    if (engine.functions.set_motion(this.number, seconds) < 0) throw new Refusal(engine.text);
  }

  /** The largest horizontal speed (m/s) with which a ball may leave the deflection `x` (m). */
  fastest(ball, x) { return this.engine.functions.fastest(this.number, ball, x); }

  /** The largest deflection (m) to which a hand takes its balls. */
  get farthest() { return this.engine.functions.farthest(this.number); }

  /** The angle (rad) to which the ball that swings farthest does, from its start. */
  get reach() { return this.engine.functions.reach(this.number); }

  look() {
    this.engine.functions.look(this.number);
    return this.shown.read(this.engine.numbers);
  }

  /** The time of the next onset (s), or, if not `known` yet, a time before which there is none; Infinity: never. */
  nextOnset() {
    const time = this.engine.functions.next_onset(this.number), known = time > 0 || Object.is(time, 0);
    return { time: Math.abs(time), known };
  }

  /** Pulses that have finished since the last call: [{contact, onset, release, peak, peakTime, impulse}]. */
  takePulses() {
    return this.pulses.splice(0);
  }

  copy() { return new Run(this.engine, this.engine.functions.copy(this.number), this.balls, this.time); }

  forget() {
    if (this.number !== null) this.engine.functions.forget(this.number);
    this.number = null;
  }
}
