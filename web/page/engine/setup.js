// A set-up: the number of balls, and start values by the FMU's names; those of balls and contacts are arrays.

import { Refusal } from "#engine/engine.js";

/** Default values of the FMU. */
export const DEFAULTS = Object.create(null);
/** Default elements of vectors: of balls at rest, and of contacts. */
export const USUAL = Object.create(null);
export const MOST_BALLS = 20;

/** Takes the engine's defaults by name. */
export function learnDefaults(defaults) {
  for (const [name, value] of Object.entries(defaults)) {
    const [family, element] = name.split("[");
    if (element) USUAL[family] ??= value; else DEFAULTS[name] = value;
  }
  USUAL.x_start = 0; // balls hang until a hand lifts them
}

const elements = (name, balls) => (name.startsWith("contact.") ? balls - 1 : balls);

export const MODELS = { circular: { "pendulum.model": "circular" }, linear: { "pendulum.model": "linear" } };

export const LAWS = {
  linear: { "contact.model": "powerLaw", "contact.exponent": 1 },
  quadratic: { "contact.model": "powerLaw", "contact.exponent": 2 },
  cubic: { "contact.model": "powerLaw", "contact.exponent": 3 },
  hertz: { "contact.model": "hertz" },
  rigid: { "contact.model": "rigid" },
};

/** How a pendulum of this length is drawn, in recordings without an engine as well: its angle (rad) at a deflection
 *  (m), and the reverse. */
export function swingOf(length, circular) {
  return circular ? { angle: (x) => Math.asin(Math.max(-1, Math.min(1, x / length))),
    deflection: (angle) => length * Math.sin(angle) }
    : { angle: (x) => x / length, deflection: (angle) => length * angle };
}

/** The parameter of each damping law. */
const LOSSES = { kelvinVoigt: "contact.damping", kelvinVoigtNoPull: "contact.damping",
  huntCrossley: "contact.huntCrossley", viscoelastic: "contact.relaxationTime",
  constantRestitution: "contact.restitution" };

export class Setup {
  /** `values`: start values by name; vectors as arrays, filled up with defaults. */
  constructor(balls, values) {
    this.balls = balls;
    this.values = { ...values };
    for (const [name, usual] of Object.entries(USUAL))
      this.values[name] = Array.from({ length: elements(name, balls) }, (_, i) => values[name]?.[i] ?? usual);
    for (const [name, value] of Object.entries(DEFAULTS)) if (this.values[name] === value) delete this.values[name];
  }

  get(name) { return this.values[name] ?? DEFAULTS[name]; }
  with(values) { return new Setup(this.balls, { ...this.values, ...values }); }
  atRest() { return this.with({ x_start: [], v_start: [] }); }

  /** The release, {x_start, v_start}; null where balls rest. */
  get release() {
    const { x_start, v_start } = this.values;
    return [...x_start, ...v_start].some(Boolean) ? { x_start, v_start } : null;
  }

  /** At these positions (m) and velocities (m/s), without overlaps under its law. */
  moving(x, v) {
    return this.with({ x_start: this.apart(x).map((place) => Number(place.toFixed(12))), v_start: Array.from(v) });
  }

  /** These positions (m) without overlaps under its law: balls on the right give way. */
  apart(x) {
    const clearance = this.values["contact.gap"].map((gap) => this.get("contact.deadBand") + gap), places = [...x];
    // Pre-compressed balls overlap at rest: a force law takes what there is.
    if (this.law === "rigid" || clearance.every((least) => least >= 0))
      clearance.forEach((least, i) => { places[i + 1] = Math.max(places[i + 1], places[i] - least); });
    return places;
  }

  resized(balls) {
    const contacts = Object.keys(USUAL).filter((name) => name.startsWith("contact."));
    return new Setup(balls, { ...this.values, ...Object.fromEntries(contacts.map((name) => [name, []])) }).atRest();
  }

  /** Values that do not change while balls move. */
  get drawing() {
    const mass = this.get("ball.mass"), ratio = this.get("ball.massRatio");
    return { balls: this.balls, radius: this.get("ball.radius"), mass, ratio,
      masses: ratio.map((part) => part * mass), length: this.get("pendulum.length"), rigid: this.law === "rigid",
      sizes: this.sizes, moduli: this.moduli,
      swing: swingOf(this.get("pendulum.length"), this.get("pendulum.model") === "circular") };
  }

  /** Young's moduli, as multiples of the default one, of steel. */
  get moduli() {
    const common = this.get("ball.youngModulus") / DEFAULTS["ball.youngModulus"];
    return this.get("ball.youngModulusRatio").map((ratio) => common * ratio);
  }

  /** Radii over the common one; where all balls are alike but for their masses, those of one material. */
  get sizes() {
    const radii = this.get("ball.radiusRatio"), moduli = this.get("ball.youngModulusRatio");
    return [...radii, ...moduli].some((ratio) => ratio !== 1) ? radii : this.get("ball.massRatio").map(Math.cbrt);
  }

  get law() {
    const model = this.get("contact.model"), exponent = this.get("contact.exponent");
    const known = Object.keys(LAWS).find((law) => LAWS[law]["contact.exponent"] === exponent) ?? "linear";
    return model === "powerLaw" ? known : model;
  }

  /** Name of the parameter by which its contacts lose energy. */
  get lossName() { return this.law === "rigid" ? "contact.restitution" : LOSSES[this.get("contact.dampingLaw")]; }

  /** The value of that parameter for each contact; empty if nothing is lost. */
  get losses() {
    const { lossName: name } = this, common = this.get(name), restores = name === "contact.restitution";
    return common === (restores ? 1 : 0) ? []
      : this.get("contact.lossRatio").map((ratio) => (restores ? common ** ratio : common * ratio));
  }

  recipe() {
    const start = Object.entries(this.values).flatMap(([name, value]) =>
      Array.isArray(value) ? value.map((element, i) => [`${name}[${i + 1}]`, element]) : [[name, value]]);
    return { balls: this.balls, start: Object.fromEntries(start) };
  }

  /** The different values of a cradle beside it, by name; `preset`: the one it is made from. */
  compared(name, preset) {
    const middle = Math.floor(this.balls / 2), double = (ratio, i) => (i === middle ? 2 * ratio : ratio);
    return {
      usual: PRESETS[preset]?.beside ?? TOUCHING, hertz: TOUCHING, noBand: { "contact.deadBand": 0 },
      rigid: LAWS.rigid,
      lossy: { "contact.dampingLaw": "huntCrossley", "contact.huntCrossley": 0.3, "contact.restitution": 0.9 },
      heavy: { "ball.massRatio": this.get("ball.massRatio").map(double) },
      linear: MODELS.linear,
    }[name];
  }

  /** As the part of an address behind #, without values that are the defaults or those of the `preset` it is from. */
  toLink(preset) {
    const ready = PRESETS[preset]?.setup(), same = ready && this.alike(ready), given = same ? ready.parts() : [];
    const parts = this.parts().filter((part) => !given.includes(part));
    return [same ? `preset=${preset}` : `balls=${this.balls}`, ...parts].join("&");
  }

  /** Whether another one differs in the release only. */
  alike(other) {
    const [one, two] = [this, other].map(({ balls, values }) =>
      String([balls, ...new Setup(balls, values).atRest().parts().sort()]));
    return one === two;
  }

  /** The name of the producer's preset that it is, however it is released; undefined if it is none. */
  get preset() {
    return Object.keys(FILES).find((name) => this.alike(fromFile(name)));
  }

  /** Values that are not the defaults, as parts of an address. */
  parts() {
    return Object.entries(this.values).filter(([name, value]) => ![value].flat().every((one) => one === USUAL[name]))
      .map(([name, value]) => `${name}=${written(value)}`);
  }

  /** Its differences from `first`, with the same balls, as parts of an address. */
  besides(first) {
    return Object.keys({ ...this.values, ...first.values })
      .filter((name) => !name.endsWith("_start") && String(this.get(name)) !== String(first.get(name)))
      .map((name) => `right.${name}=${written(this.get(name))}`);
  }

  /** From the part of an address behind #: {setup, options}, which are not the engine's. Throws Refusal. */
  static fromLink(text) {
    const values = Object.create(null), options = Object.create(null);
    for (const part of text.replace(/^#/, "").split("&").filter(Boolean)) {
      const [name, raw = ""] = part.split("=").map(decoded), right = name.replace(/^right\./, "");
      if (LINK_OPTIONS.includes(name)) options[name] = raw;
      else if (right !== name) options.right = { ...options.right, [right]: parsed(right, raw) };
      else values[name] = parsed(name, raw);
    }
    const { preset = "textbook" } = options, { balls: asked, ...own } = values;
    if (!Object.hasOwn(PRESETS, preset))
      throw new Refusal(`preset = ${preset} is refused; allowed: ${Object.keys(PRESETS).join(", ")}`);
    const ready = asked === undefined ? PRESETS[preset].setup() : null, balls = ready?.balls ?? asked;
    for (const [name, given, most] of [["balls", balls, MOST_BALLS], ["lift", options.lift ?? 1, balls]])
      if (!(Number.isInteger(Number(given)) && given >= 1 && given <= most))
        throw new Refusal(`${name} = ${given} is refused; allowed: 1 to ${most}`);
    for (const [name, given] of Object.entries(own)) {
      if (Array.isArray(given) && given.length > elements(name, balls))
        throw new Refusal(`${name} has ${given.length} numbers; allowed: up to ${elements(name, balls)}`);
    }
    return { setup: new Setup(balls, { ...ready?.values, ...own }), options };
  }
}

/** Numbers as an address has them, without what rounding has left. */
const written = (value) => [value].flat().map((one) => (typeof one === "number" ? Number(one.toPrecision(12)) : one));

const LINK_OPTIONS = ["preset", "beside", "slow", "show", "lift", "lang", "view", "present", "ask"];

/** A part of an address, in which % stands before two digits of base 16. */
function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    throw new Refusal(`${text} is refused; allowed: text in which % is written as %25`);
  }
}

/** A value from an address: a word, a number, or numbers of balls or contacts. */
function parsed(name, raw) {
  const values = (name in USUAL ? raw.split(",") : [raw]).map((text) => (text.trim() ? Number(text) : NaN));
  const word = values.findIndex(Number.isNaN);
  if (word >= 0 && (name in USUAL || !/^[a-z]/i.test(raw)))
    throw new Refusal(`${name} = ${raw.split(",")[word]} is not a number`);
  return word >= 0 ? raw : name in USUAL ? values : values[0];
}

export const FILES = {}; // the presets of cradle-fmu: values by name

/** The lesson's steps, see docs/lesson.md, as parts of the address. */
export const LESSON = [
  "preset=textbook&lift=2",
  "preset=textbook&lift=2&show=energy,momentum",
  "preset=textbook&lift=2&slow=next",
  "preset=steel&lift=2&slow=next",
  "preset=textbook&lift=2&beside=hertz",
  "preset=textbook&ball.massRatio=1,1,1,1,0.5&lift=1&slow=next&show=velocity",
];

const TOUCHING = { "contact.model": "hertz", "contact.deadBand": 0 }; // steel

/** The set-up of a preset as cradle-fmu has it. */
function fromFile(name) {
  const { balls, ...values } = FILES[name];
  return new Setup(balls, values);
}

/** Without the release where one lifts by hand. `beside`: changes of the cradle to compare with; `own`: those that the
 *  page makes. */
function ready(name, beside, byHand = false, own = {}) {
  const setup = () => {
    const made = fromFile(name).with(own);
    return byHand ? made.atRest() : made;
  };
  return { setup, beside };
}

export const PRESETS = {
  textbook: ready("textbook", TOUCHING, true, MODELS.circular),
  figure3: ready("figure3", { "contact.exponent": 1.5 }),
  figure5: ready("figure5", { "contact.deadBand": 0 }),
  figure6: ready("figure6", { "contact.deadBand": 0 }),
  steel: ready("steel", LAWS.rigid, true, MODELS.circular),
  desk: ready("desk", { "contact.huntCrossley": 0 }),
  tapered: ready("tapered", { "ball.massRatio": [], "ball.radiusRatio": [] }),
  unlike: ready("unlike", { "ball.massRatio": [], "ball.youngModulusRatio": [] }),
  clay: ready("clay", { "contact.lossRatio": [] }),
  rigid: ready("rigid", { "contact.restitution": 0.95 }, true),
  buzzing: ready("buzzing", { "contact.dampingLaw": "huntCrossley", "contact.huntCrossley": 0.3 }),
};
