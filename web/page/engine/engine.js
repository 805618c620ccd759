// The engine: WebAssembly behind plain objects. SI units throughout.

export const EFFORT = 1500; // of one call, about 0.15 ms

/** What the engine refuses or cannot go on with, in its own words. */
export class Refusal extends Error {}

/** The compiled engine. Its functions are those of web/src/lib.rs. */
export class Engine {
  /** From the bytes of the .wasm file. */
  static async load(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Engine(instance.exports);
  }

  constructor(functions) {
    this.functions = functions;
    functions.prepare();
  }

  /** Calls a function; a panic of the engine becomes an error with what it said. */
  call(name, ...given) {
    try {
      return this.functions[name](...given);
    } catch (problem) {
      if (problem instanceof WebAssembly.RuntimeError)
        throw new Error(`The engine stopped: ${this.text() || problem.message}`);
      throw problem;
    }
  }

  /** The text that the engine left last. */
  text() {
    const { memory, text_left, text_length } = this.functions;
    return new TextDecoder().decode(new Uint8Array(memory.buffer, text_left(), text_length()));
  }

  numbers(address, count) { return new Float64Array(this.functions.memory.buffer, address, count); }

  /** Starts a run from a recipe {balls, start}, as an FMU carries it. Throws Refusal. */
  start({ balls, start }) {
    const bytes = new TextEncoder().encode(JSON.stringify({ format: 1, balls, start }));
    const address = this.call("text", bytes.length);
    new Uint8Array(this.functions.memory.buffer, address, bytes.length).set(bytes);
    const number = this.call("start");
    if (number < 0) throw new Refusal(this.text());
    return new Run(this, number, balls);
  }
}

/** What a run shows at one time: sums, and a part of `numbers` for each quantity of the balls and contacts. */
export class State {
  constructor(balls) {
    const counts = [...Array(4).fill(balls), ...Array(4).fill(balls - 1)], numbers = new Float64Array(8 * balls + 4);
    let at = 8;
    const parts = counts.map((count) => numbers.subarray(at, (at += count)));
    Object.assign(this, { balls, numbers });
    [this.x, this.v, this.kinetic, this.gravity, this.F, this.overlap, this.elastic, this.closed] = parts;
    this.read();
  }

  /** Of the whole: time (s), energies (J), with the work of external forces and the residual, momentum (N.s), force
   *  (N), events. */
  read() {
    [this.time, this.energy, this.dissipated, this.work, this.residual, this.momentum, this.supportForce, this.events] =
      this.numbers;
    return this;
  }

  /** Whether all contacts are open. */
  get apart() { return this.closed.every((closed) => !closed); }
}

/** One run of a cradle. It lives until `forget`. */
class Run {
  constructor(engine, number, balls) {
    Object.assign(this, { engine, number, balls, time: 0, shown: null });
  }

  /** Moves on to `time` or until `effort` (about 0.1 us each) is spent; the time reached. Throws Refusal. */
  advance(time, effort = Infinity) {
    if (!(time > this.time)) return this.time;
    const reached = this.engine.call("advance", this.number, time, Math.min(effort, Number.MAX_SAFE_INTEGER));
    if (Number.isNaN(reached)) throw new Refusal(this.engine.text());
    return (this.time = reached);
  }

  /** What it shows now: always the same object. */
  look() {
    const state = (this.shown ??= new State(this.balls));
    state.numbers.set(this.engine.numbers(this.engine.call("look", this.number), state.numbers.length));
    return state.read();
  }

  /** When the next onset is, or, where it is not `known` yet, before when there is none; infinite if there is none at
   *  all. */
  nextOnset() {
    const time = this.engine.call("next_onset", this.number), known = time > 0 || Object.is(time, 0);
    return { time: Math.abs(time), known };
  }

  /** Pulses that have finished since the last call: [{contact, onset, release, peak, impulse}]. */
  takePulses() {
    const count = this.engine.call("pulse_count", this.number);
    if (!count) return [];
    const numbers = this.engine.numbers(this.engine.call("pulses", this.number), 5 * count);
    return Array.from({ length: count }, (_, i) => {
      const [contact, onset, release, peak, impulse] = numbers.subarray(5 * i, 5 * i + 5);
      return { contact, onset, release, peak, impulse };
    });
  }

  /** Another run that goes on from here. */
  copy() {
    const copy = new Run(this.engine, this.engine.call("copy", this.number), this.balls);
    copy.time = this.time;
    return copy;
  }

  forget() {
    if (this.number !== null) this.engine.call("forget", this.number);
    this.number = null;
  }
}
