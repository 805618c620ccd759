// A set-up: the number of balls, and start values by the names that the FMU gives them. Values of balls and contacts are arrays.

const PER_BALL = ["ball.massRatio", "pendulum.lengthRatio", "x_start", "v_start"];
const MOST_BALLS = 20;

const LAWS = {
  linear: { "contact.model": "powerLaw", "contact.exponent": 1 },
  quadratic: { "contact.model": "powerLaw", "contact.exponent": 2 },
  cubic: { "contact.model": "powerLaw", "contact.exponent": 3 },
  hertz: { "contact.model": "hertz" },
  rigid: { "contact.model": "rigid" },
};

class Setup {
  /** `values`: start values by name; those of balls as arrays, filled up with what a ball at rest has. */
  constructor(balls, values) {
    this.balls = balls;
    this.values = { ...values };
    for (const name of PER_BALL) {
      const given = this.values[name] ?? [];
      this.values[name] = Array.from({ length: balls }, (_, i) => given[i] ?? rest(name));
    }
    for (const [name, value] of Object.entries(DEFAULTS)) if (this.values[name] === value) delete this.values[name];
  }

  get(name) { return this.values[name] ?? DEFAULTS[name]; }

  /** The same with other values. */
  with(values) { return new Setup(this.balls, { ...this.values, ...values }); }

  /** All balls at rest, hanging down. */
  atRest() { return this.with({ x_start: [], v_start: [] }); }

  /** Another number of balls, at rest. */
  resized(balls) {
    const values = { ...this.values };
    delete values["contact.gap"];
    return new Setup(balls, values).atRest();
  }

  /** Which of the laws of contact it has. */
  get law() {
    const model = this.get("contact.model");
    if (model !== "powerLaw") return model;
    return Object.keys(LAWS).find((law) => LAWS[law]["contact.exponent"] === this.get("contact.exponent")) ?? "linear";
  }

  /** What the engine starts from. */
  recipe() {
    const start = {};
    for (const [name, value] of Object.entries(this.values)) {
      if (Array.isArray(value)) value.forEach((element, i) => { start[`${name}[${i + 1}]`] = element; });
      else start[name] = value;
    }
    return { balls: this.balls, start };
  }

  /** As the part of an address behind #. Values that are the defaults are left out, and those of the `preset` it is made from. */
  toLink(preset) {
    const ready = PRESETS[preset]?.setup(), parts = this.parts(), alike = (one) => String([one.balls, ...one.atRest().parts()]);
    if (!ready || alike(ready) !== alike(this)) return [`balls=${this.balls}`, ...parts].join("&");
    const given = ready.parts();
    return [`preset=${preset}`, ...parts.filter((part) => !given.includes(part))].join("&");
  }

  /** Values that are not the defaults, as parts of an address. */
  parts() {
    const usual = (name, value) => Array.isArray(value) && value.every((element) => element === rest(name));
    return Object.entries(this.values).filter((entry) => !usual(...entry)).map(([name, value]) => `${name}=${value}`);
  }

  /** What it has other than `first`, with the same balls, as parts of an address. */
  besides(first) {
    const names = [...new Set([...Object.keys(this.values), ...Object.keys(first.values)])].filter((name) => !/_start$/.test(name));
    return names.filter((name) => String(this.get(name)) !== String(first.get(name))).map((name) => `right.${name}=${this.get(name)}`);
  }

  /** From the part of an address behind #: {setup, options}; options are the names that are not the engine's. Throws Refusal. */
  static fromLink(text) {
    const values = {}, options = {};
    for (const part of text.replace(/^#/, "").split("&").filter(Boolean)) {
      const [name, raw = ""] = part.split("=").map(decodeURIComponent), right = name.replace(/^right\./, "");
      if (LINK_OPTIONS.includes(name)) options[name] = raw;
      else if (right !== name) options.right = { ...options.right, [right]: parsed(right, raw) };
      else values[name] = parsed(name, raw);
    }
    const { preset = "textbook" } = options, { balls: asked, ...own } = values;
    if (!PRESETS[preset]) throw new Refusal(`preset = ${preset} is refused; allowed: ${Object.keys(PRESETS).join(", ")}`);
    const ready = asked === undefined ? PRESETS[preset].setup() : null, balls = ready?.balls ?? asked;
    if (!(Number.isInteger(balls) && balls >= 1 && balls <= MOST_BALLS)) {
      throw new Refusal(`balls = ${balls} is refused; allowed: 1 to ${MOST_BALLS}`);
    }
    for (const [name, given] of Object.entries(own)) {
      const most = name === "contact.gap" ? balls - 1 : balls;
      if (Array.isArray(given) && given.length > most) throw new Refusal(`${name} has ${given.length} numbers; allowed: up to ${most}`);
    }
    return { setup: new Setup(balls, { ...ready?.values, ...own }), options };
  }
}

const LINK_OPTIONS = ["preset", "beside", "slow", "show", "lift", "look"];

/** A value from an address: a word, a number, or numbers of balls or contacts. */
function parsed(name, raw) {
  const several = PER_BALL.includes(name) || name === "contact.gap";
  if (!several && /^[a-z]/i.test(raw) && Number.isNaN(Number(raw))) return raw;
  const values = (several ? raw.split(",") : [raw]).map((text) => {
    if (text.trim() === "" || Number.isNaN(Number(text))) throw new Refusal(`${name} = ${text} is not a number`);
    return Number(text);
  });
  return several ? values : values[0];
}

/** What a ball at rest has. */
function rest(name) { return name.endsWith("Ratio") ? 1 : 0; }

/** Positions near `x` at which no neighbours are nearer than `clearance[i]` allows (m): midway between those to which balls are only
 *  pushed to the right, and only to the left. Balls that touch nothing stay where they are, to the last bit. */
function apart(x, clearance) {
  const right = [...x], left = [...x], last = x.length - 1;
  for (let i = 0; i < last; i++) right[i + 1] = Math.max(x[i + 1], right[i] - clearance[i]);
  for (let i = last - 1; i >= 0; i--) left[i] = Math.min(x[i], left[i + 1] + clearance[i]);
  const places = x.map((_, i) => 0.5 * (left[i] + right[i]));
  // Rounding may leave an overlap.
  for (let i = 0; i < last; i++) if (places[i] - places[i + 1] > clearance[i]) places[i + 1] = places[i] - clearance[i];
  return places;
}
