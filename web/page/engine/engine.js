// The engine: WebAssembly behind plain objects. SI units throughout.

const LOST = "forgotten";
const EFFORT = 1500; // of one call, about 0.15 ms

/** What the engine refuses or cannot go on with, in its own words. */
class Refusal extends Error {}

/** The compiled engine. Its functions are those of web/src/lib.rs. */
class Engine {
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
      if (problem instanceof WebAssembly.RuntimeError) throw new Error(`The engine stopped: ${this.text() || problem.message}`);
      throw problem;
    }
  }

  /** The text that the engine left last. */
  text() {
    const { memory, text_left, text_length } = this.functions;
    return new TextDecoder().decode(new Uint8Array(memory.buffer, text_left(), text_length()));
  }

  numbers(address, count) { return new Float64Array(this.functions.memory.buffer, address, count); }

  /** Bytes of memory that the engine has taken. */
  get memory() { return this.functions.memory.buffer.byteLength; }

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
class State {
  constructor(balls) {
    const contacts = balls - 1;
    this.balls = balls;
    this.numbers = new Float64Array(8 + 4 * balls + 6 * contacts);
    let at = 8;
    const next = (count) => this.numbers.subarray(at, (at += count));
    [this.x, this.v, this.kinetic, this.gravity] = [balls, balls, balls, balls].map(next);
    [this.F, this.overlap, this.elastic, this.impulse, this.pulses, this.closed] = Array(6).fill(contacts).map(next);
    this.read();
  }

  /** Of the whole: time (s), energies (J), with the work of external forces and the residual, momentum (N.s), force (N), events. */
  read() {
    [this.time, this.energy, this.dissipated, this.work, this.residual, this.momentum, this.supportForce, this.events] = this.numbers;
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

  /** What was looked at last. */
  get state() { return this.shown ?? this.look(); }

  /** Moves on to `time` or until `effort` (about 0.1 us each) is spent; the time reached. Throws Refusal. */
  advance(time, effort = Infinity) {
    if (!(time > this.time)) return this.time;
    const most = Math.min(effort, Number.MAX_SAFE_INTEGER);
    const reached = this.engine.call("advance", this.number, time, most);
    if (Number.isNaN(reached)) throw new Refusal(this.engine.text());
    return (this.time = reached);
  }

  /** What it shows now: always the same object. */
  look() {
    const state = (this.shown ??= new State(this.balls));
    state.numbers.set(this.engine.numbers(this.engine.call("look", this.number), state.numbers.length));
    return state.read();
  }

  /** The next onset: {at}, or {notBefore} if it is not known yet. `at` is infinite if there is none. */
  nextOnset() {
    const time = this.engine.call("next_onset", this.number);
    return time < 0 || Object.is(time, -0) ? { notBefore: -time } : { at: time };
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
    if (this.number === LOST) return;
    this.engine.call("forget", this.number);
    this.number = LOST;
  }
}
