// What opens when it is asked for: a panel with the choices of one kind.

const PLAY_BAND = [0, 1e-7, 2.6e-7, 5e-7, 1e-6, 2.6e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4]; // m
const HARDNESS = [4, 14]; // powers of ten, N/m
const GRAVITIES = { earth: 9.81, moon: 1.62, mars: 3.71, jupiter: 24.8 };
const WEIGHTS = [0.125, 0.25, 0.5, 0.75, 1, 1.5, 2, 4, 8];

class Panels {
  constructor(app) {
    this.app = app;
    this.box = document.getElementById("panel");
    this.body = document.getElementById("panelbody");
    this.openers = [...document.querySelectorAll("[data-opens]")];
    for (const opener of this.openers) {
      opener.setAttribute("aria-expanded", "false");
      opener.setAttribute("aria-controls", "panel");
      opener.addEventListener("click", () => this.toggle(opener.dataset.opens));
    }
    document.getElementById("close").addEventListener("click", () => this.toggle(this.kind));
    this.box.addEventListener("keydown", (event) => { if (event.key === "Escape") this.toggle(this.kind); });
  }

  toggle(kind) {
    const opener = this.openers.find(({ dataset }) => dataset.opens === (kind ?? this.kind));
    this.kind = this.kind === kind ? null : kind;
    this.openers.forEach((item) => item.setAttribute("aria-expanded", String(item.dataset.opens === this.kind)));
    this.box.hidden = !this.kind;
    if (!this.kind) return void opener?.focus();
    document.getElementById("paneltitle").textContent = say(this.kind);
    this.fill();
    (this.body.querySelector("input:checked, input, button") ?? document.getElementById("close")).focus();
  }

  /** Fills it anew, with what is the case now. */
  refresh() {
    if (!this.kind) return;
    const focus = document.activeElement?.dataset?.key;
    this.fill();
    if (focus) [...this.body.querySelectorAll("[data-key]")].find(({ dataset }) => dataset.key === focus)?.focus();
  }

  fill() {
    this.body.replaceChildren();
    this[this.kind]();
  }

  // ---- pieces

  element(name, text, properties = {}, parent = this.body) {
    const element = Object.assign(document.createElement(name), properties);
    if (text !== null) element.textContent = text;
    parent.append(element);
    return element;
  }

  /** One of several. */
  chips(title, items, chosen, choose, type = "radio") {
    const set = this.element("fieldset", null), name = `chips ${title}`;
    this.element("legend", title, {}, set);
    const row = this.element("div", null, { className: "chips" }, set);
    for (const [key, text] of items) {
      const label = this.element("label", null, {}, row);
      const input = this.element("input", null, { type, name, checked: type === "radio" ? key === chosen : chosen(key) }, label);
      input.dataset.key = `${title} ${key}`;
      this.element("span", text, {}, label);
      input.addEventListener("change", () => choose(key, input.checked));
    }
  }

  /** A number on a scale; `show` says it in words. */
  slider(title, { min, max, step = 1, value, show, choose }) {
    const label = this.element("label", null, { className: "field" });
    this.element("span", title, {}, label);
    const output = this.element("output", show(value), {}, label);
    const input = this.element("input", null, { type: "range", min, max, step, value }, label);
    input.dataset.key = title;
    input.setAttribute("aria-valuetext", show(value));
    input.addEventListener("input", () => { output.textContent = show(Number(input.value)); input.setAttribute("aria-valuetext", output.textContent); });
    input.addEventListener("change", () => choose(Number(input.value)));
  }

  /** One of the values of a list, on a scale. */
  steps(title, list, value, show, choose) {
    const nearest = list.reduce((best, item, i) => (Math.abs(item - value) < Math.abs(list[best] - value) ? i : best), 0);
    this.slider(title, { min: 0, max: list.length - 1, value: nearest, show: (i) => show(list[i]), choose: (i) => choose(list[i]) });
  }

  // ---- panels

  change() {
    const { app } = this, setup = app.changedSource.setup;
    if (!setup) return void this.presets();
    if (app.stages.length > 1) {
      this.chips(say("side"), ["left", "right", "both"].map((side) => [side, say(side)]), app.side, (side) => { app.side = side; this.refresh(); });
    } else this.presets();
    const set = (values) => app.change(values), rigid = setup.law === "rigid", power = setup.get("contact.model") === "powerLaw";
    this.chips(say("law"), Object.keys(LAWS).map((law) => [law, say(`laws.${law}`)]), setup.law, (law) => set(LAWS[law]));
    this.steps(say("deadBand"), PLAY_BAND, setup.get("contact.deadBand"), (m) => (m ? quantity(m, "m") : say("none")), (m) => set({ "contact.deadBand": m }));
    if (power) {
      const hardness = Math.log10(setup.get("contact.stiffness") * (setup.get("contact.overlapRef") / 1e-6) ** (1 - setup.get("contact.exponent")));
      this.slider(say("stiffness"), {
        min: HARDNESS[0], max: HARDNESS[1], step: 0.5, value: Math.min(HARDNESS[1], Math.max(HARDNESS[0], hardness)),
        show: (p) => quantity(10 ** p, "N/m", 2), choose: (p) => set({ "contact.stiffness": 10 ** p, "contact.overlapRef": 1e-6 }),
      });
    }
    if (rigid) {
      this.slider(say("restitution"), {
        min: 0, max: 100, value: 100 * setup.get("contact.restitution"), show: (percent) => `${percent} %`, choose: (percent) => set({ "contact.restitution": percent / 100 }),
      });
    } else {
      this.slider(say("loss"), {
        min: 0, max: 1, step: 0.05, value: setup.get("contact.dampingLaw") === "huntCrossley" ? setup.get("contact.huntCrossley") : 0,
        show: (alpha) => (alpha ? `${rounded(alpha)} s/m` : say("none")), choose: (alpha) => set({ "contact.dampingLaw": "huntCrossley", "contact.huntCrossley": alpha }),
      });
    }
    const mass = setup.get("ball.mass");
    this.slider(say("drag"), {
      min: 0, max: 0.5, step: 0.01, value: setup.get("pendulum.drag") / mass, show: (b) => (b ? `${rounded(b * mass)} kg/s` : say("none")),
      choose: (b) => set({ "pendulum.drag": b * mass }),
    });
    this.weight(setup, set);
    this.slider(say("length"), {
      min: 0.05, max: 2, step: 0.05, value: setup.get("pendulum.length"), show: (m) => quantity(m, "m"), choose: (m) => set({ "pendulum.length": m }),
    });
    const world = Object.keys(GRAVITIES).find((name) => GRAVITIES[name] === setup.get("gravity"));
    this.chips(say("gravity"), Object.keys(GRAVITIES).map((name) => [name, say(`gravities.${name}`)]), world, (name) => set({ gravity: GRAVITIES[name] }));
    this.slider(say("balls"), { min: 1, max: MOST_BALLS, value: setup.balls, show: String, choose: (balls) => app.resize(balls) });
  }

  presets() {
    this.chips(say("preset"), Object.keys(PRESETS).map((name) => [name, say(`presets.${name}`)]), this.app.preset, (name) => this.app.choose(name));
  }

  /** A heavier or a lighter ball. */
  weight(setup, set) {
    const ratios = setup.get("ball.massRatio"), uneven = ratios.findIndex((ratio) => ratio !== 1);
    const ball = Math.min(setup.balls - 1, this.ball ?? (uneven >= 0 ? uneven : Math.floor(setup.balls / 2)));
    this.slider(say("whose"), { min: 1, max: setup.balls, value: ball + 1, show: (i) => say("ball", i), choose: (i) => { this.ball = i - 1; this.refresh(); } });
    this.steps(say("weight"), WEIGHTS, ratios[ball], (ratio) => say("times", ratio), (ratio) => set({ "ball.massRatio": ratios.map((old, i) => (i === ball ? ratio : old)) }));
  }

  show() {
    const { app } = this;
    const kinds = Object.keys(TEXTS.shows).map((kind) => [kind, say(`shows.${kind}`)]);
    this.chips(say("show"), kinds, (kind) => app.shows[kind], (kind, on) => app.setShow(kind, on), "checkbox");
    const others = [["every", say("every")], ["sound", say("sound")], ["light", say("theme")], ["keys", say("singleKeys")]];
    const on = { every: app.clock.slow === "always", sound: app.sound.on, light: !app.theme.dark, keys: app.keys };
    this.chips("", others, (kind) => on[kind], (kind, checked) => app.setOther(kind, checked), "checkbox");
    this.slider(say("pace"), {
      min: -6, max: 0, step: 0.25, value: Math.log10(app.clock.base), show: (p) => paceText(10 ** p), choose: (p) => app.setPace(10 ** p),
    });
  }

  beside() {
    const { app } = this;
    this.chips(say("besideWhat"), Object.keys(TEXTS.besides).map((name) => [name, say(`besides.${name}`)]), app.besideChoice ?? "stop", (name) => app.compare(name));
  }

  keep() {
    const { app } = this, column = this.element("div", null, { className: "column" });
    const button = (text, act) => this.element("button", text, { type: "button", onclick: act }, column);
    button(say("link"), () => app.copyLink());
    button(say("picture"), () => savePicture(app));
    const { source } = app.stages[0];
    if (source.live) {
      button(say("pulsesFile"), () => save("pulses.csv", pulsesTable(source)));
      button(say("runFile"), () => save("run.csv", runTable(source)));
    }
    const label = this.element("label", say("open"), { className: "file" }, column);
    const input = this.element("input", null, { type: "file", accept: ".csv,text/csv" }, label);
    input.addEventListener("change", () => app.openFile(input.files[0]));
  }

  /** Six steps, each a link into this page. */
  lesson() {
    const list = this.element("ol", null, { className: "lesson" });
    TEXTS.lessons.forEach(({ title, text }, i) => {
      const item = this.element("li", null, {}, list);
      this.element("a", title, { href: `#${LESSON[i]}` }, item);
      this.element("p", text, {}, item);
    });
  }

  help() {
    const list = this.element("dl", null, { className: "keys" });
    for (const [key, meaning] of TEXTS.keys) {
      this.element("dt", key, {}, list);
      this.element("dd", meaning, {}, list);
    }
    const column = this.element("div", null, { className: "column" });
    const show = async () => this.element("pre", await unpacked("licences").text(), { tabIndex: 0 }, column);
    this.element("button", say("licences"), { type: "button", onclick: (event) => { event.target.remove(); show(); } }, column);
  }
}

function paceText(rate) { return rate >= 0.999 ? say("realTime") : say("slower", quantity(rate, "s", 2)); }
