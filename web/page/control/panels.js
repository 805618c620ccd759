// What opens when it is asked for: a panel with the choices of one kind.

import { pulsesTable, runTable, save, savePicture } from "#control/keep.js";
import { LAWS, LESSON, MOST_BALLS, PRESETS } from "#engine/setup.js";
import { withPrefix } from "#view/common.js";
import { aria, element, unpacked } from "#view/elements.js";
import { paceText, rounded, say, textsOf } from "#view/texts.js";

const PLAY_BAND = [0, 1e-7, 2.6e-7, 5e-7, 1e-6, 2.6e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4]; // m
const HARDNESS = [4, 14]; // powers of ten, N/m
const GRAVITIES = { earth: 9.81, moon: 1.62, mars: 3.71, jupiter: 24.8 };
const WEIGHTS = [0.125, 0.25, 0.5, 0.75, 1, 1.5, 2, 4, 8];

export class Panels {
  constructor(app) {
    this.app = app;
    this.openers = ["change", "show", "beside", "lesson", "keep", "help"].map((kind) => {
      const opener = element(app.controls.openers, "button", { type: "button", textContent: say(kind) });
      aria(opener, { controls: "panel", expanded: false });
      opener.dataset.opens = kind;
      opener.onclick = () => this.toggle(kind);
      return opener;
    });
    this.body = app.controls.panelbody;
    app.controls.close.onclick = () => this.toggle(this.kind);
    app.controls.panel.onkeydown = ({ key }) => { if (key === "Escape") this.toggle(this.kind); };
  }

  toggle(kind) {
    const opener = this.openers.find(({ dataset }) => dataset.opens === (kind ?? this.kind));
    const { panel, paneltitle, close } = this.app.controls;
    this.kind = this.kind === kind ? null : kind;
    for (const item of this.openers) aria(item, { expanded: item.dataset.opens === this.kind });
    panel.hidden = !this.kind;
    document.body.classList.toggle("open", Boolean(this.kind));
    if (!this.kind) return void opener?.focus();
    paneltitle.textContent = say(this.kind);
    this.refresh();
    (this.body.querySelector("input:checked, input, button") ?? close).focus();
  }

  close() { if (this.kind) this.toggle(this.kind); }

  /** Fills it anew, with what is the case now. */
  refresh() {
    if (!this.kind) return;
    const focus = document.activeElement?.dataset?.key;
    this.body.replaceChildren();
    this[this.kind]();
    if (focus) [...this.body.querySelectorAll("[data-key]")].find(({ dataset }) => dataset.key === focus)?.focus();
  }

  // ---- pieces

  /** One of several, by their names in the table of texts `texts`; or, with checkboxes, those for which `chosen` is
   *  true. */
  chips(title, names, texts, chosen, choose) {
    const set = element(this.body, "fieldset"), several = typeof chosen === "function";
    element(set, "legend", { textContent: title });
    const row = element(set, "div", { className: "chips" });
    for (const key of names) {
      const label = element(row, "label"), checked = several ? chosen(key) : key === chosen;
      const input = element(label, "input", { type: several ? "checkbox" : "radio", name: `chips ${title}`, checked });
      input.dataset.key = `${title} ${key}`;
      element(label, "span", { textContent: say(texts ? `${texts}.${key}` : key) });
      input.addEventListener("change", () => choose(key, input.checked));
    }
  }

  /** A number on a scale; `show` says it in words. */
  slider(title, { min = 0, max, step = 1, value, show, choose }) {
    const label = element(this.body, "label", { className: "field" });
    element(label, "span", { textContent: title });
    const output = element(label, "output"), input = element(label, "input", { type: "range", min, max, step, value });
    const tell = (shown) => { output.textContent = show(shown); aria(input, { valuetext: output.textContent }); };
    input.dataset.key = title;
    tell(value);
    input.oninput = () => tell(Number(input.value));
    input.onchange = () => choose(Number(input.value));
  }

  /** One of the values of a list, on a scale. */
  steps(title, list, value, show, choose) {
    const nearest = list.reduce((best, item, i) => (Math.abs(item - value) < Math.abs(list[best] - value) ? i : best),
      0);
    this.slider(title, { max: list.length - 1, value: nearest, show: (i) => show(list[i]),
      choose: (i) => choose(list[i]) });
  }

  // ---- panels

  change() {
    const { app } = this, { setup } = app.changedSource;
    if (!setup) return void this.presets();
    if (app.stages.length < 2) this.presets();
    else this.chips(say("side"), ["left", "right", "both"], "", app.side,
      (side) => { app.side = side; this.refresh(); });
    const set = (values) => app.change(values), get = (name) => setup.get(name);
    const length = (m) => (m ? withPrefix(m, "m") : say("none"));
    this.chips(say("law"), Object.keys(LAWS), "laws", setup.law, (law) => set(LAWS[law]));
    this.steps(say("deadBand"), PLAY_BAND, get("contact.deadBand"), length, (m) => set({ "contact.deadBand": m }));
    if (get("contact.model") === "powerLaw") {
      const hardness =
        Math.log10(get("contact.stiffness") * (get("contact.overlapRef") / 1e-6) ** (1 - get("contact.exponent")));
      const [min, max] = HARDNESS;
      this.slider(say("stiffness"), {
        min, max, step: 0.5, value: Math.min(max, Math.max(min, hardness)), show: (p) => withPrefix(10 ** p, "N/m", 2),
        choose: (p) => set({ "contact.stiffness": 10 ** p, "contact.overlapRef": 1e-6 }),
      });
    }
    if (setup.law === "rigid") {
      this.slider(say("restitution"), {
        max: 100, value: 100 * get("contact.restitution"), show: (percent) => `${percent} %`,
        choose: (percent) => set({ "contact.restitution": percent / 100 }),
      });
    } else {
      this.slider(say("loss"), {
        max: 1, step: 0.05, value: get("contact.dampingLaw") === "huntCrossley" ? get("contact.huntCrossley") : 0,
        show: (alpha) => (alpha ? `${rounded(alpha)} s/m` : say("none")),
        choose: (alpha) => set({ "contact.dampingLaw": "huntCrossley", "contact.huntCrossley": alpha }),
      });
    }
    const mass = get("ball.mass");
    this.slider(say("drag"), {
      max: 0.5, step: 0.01, value: get("pendulum.drag") / mass,
      show: (b) => (b ? `${rounded(b * mass)} kg/s` : say("none")),
      choose: (b) => set({ "pendulum.drag": b * mass }),
    });
    this.weight(setup, set);
    this.slider(say("length"), {
      min: 0.05, max: 2, step: 0.05, value: get("pendulum.length"), show: length,
      choose: (m) => set({ "pendulum.length": m }),
    });
    const worlds = Object.keys(GRAVITIES), world = worlds.find((name) => GRAVITIES[name] === get("gravity"));
    this.chips(say("gravity"), worlds, "gravities", world ?? "", (name) => set({ gravity: GRAVITIES[name] }));
    this.slider(say("balls"), { min: 1, max: MOST_BALLS, value: setup.balls, show: String,
      choose: (balls) => app.resize(balls) });
  }

  presets() {
    this.chips(say("preset"), Object.keys(PRESETS), "presets", this.app.preset, (name) => this.app.choose(name));
  }

  /** A heavier or a lighter ball. */
  weight(setup, set) {
    const ratios = setup.get("ball.massRatio"), uneven = ratios.findIndex((ratio) => ratio !== 1), { balls } = setup;
    const ball = Math.min(balls - 1, this.ball ?? (uneven >= 0 ? uneven : Math.floor(balls / 2)));
    const turnTo = (i) => { this.ball = i - 1; this.refresh(); };
    const nameOf = (i) => say("ball", { ball: i });
    this.slider(say("whose"), { min: 1, max: balls, value: ball + 1, show: nameOf, choose: turnTo });
    const choose = (ratio) => set({ "ball.massRatio": ratios.map((old, i) => (i === ball ? ratio : old)) });
    this.steps(say("weight"), WEIGHTS, ratios[ball], (ratio) => say("times", { ratio: rounded(ratio) }), choose);
  }

  show() {
    const { app } = this;
    this.chips(say("show"), Object.keys(textsOf("shows")), "shows", (kind) => app.shows[kind],
      (kind, on) => app.setShow(kind, on));
    const { space, clock, sound, theme, keys, lesson } = app;
    const on = { space, every: clock.slow === "always", sound: sound.on, light: !theme.dark, keys, ask: lesson.asks };
    this.chips("", Object.keys(on), "others", (kind) => on[kind], (kind, checked) => app.setOther(kind, checked));
    this.slider(say("pace"), {
      min: -6, max: 0, step: 0.25, value: Math.log10(app.clock.base), show: (p) => paceText(10 ** p),
      choose: (p) => app.setPace(10 ** p),
    });
  }

  beside() {
    const { app } = this;
    this.chips(say("besideWhat"), Object.keys(textsOf("besides")), "besides", app.besideChoice ?? "stop",
      (name) => app.compare(name));
  }

  keep() {
    const { app } = this, column = element(this.body, "div", { className: "column" }), { source } = app.stages[0];
    const buttons = { link: () => app.copyLink(), picture: () => savePicture(app) };
    if (source.live) {
      buttons.pulsesFile = () => save("pulses.csv", pulsesTable(source));
      buttons.runFile = () => save("run.csv", runTable(source));
    }
    for (const [name, onclick] of Object.entries(buttons))
      element(column, "button", { type: "button", textContent: say(name), onclick });
    const label = element(column, "label", { className: "file", textContent: say("open") });
    const input = element(label, "input", { type: "file", accept: ".csv,text/csv" });
    input.addEventListener("change", () => app.openFile(input.files[0]));
  }

  /** Six steps, each a link into this page. */
  lesson() {
    const column = element(this.body, "div", { className: "column" });
    const list = element(this.body, "ol", { className: "lesson" });
    element(column, "button", { type: "button", textContent: say("present"), onclick: () => this.app.open("present") });
    textsOf("lessons").forEach(({ title, text }, i) => {
      const item = element(list, "li");
      element(item, "a", { href: `#${LESSON[i]}`, textContent: title });
      element(item, "p", { textContent: text });
    });
  }

  help() {
    const list = element(this.body, "dl", { className: "keys" });
    for (const [key, meaning] of textsOf("keys")) {
      element(list, "dt", { textContent: key });
      element(list, "dd", { textContent: meaning });
    }
    const column = element(this.body, "div", { className: "column" });
    const button = element(column, "button", { type: "button", textContent: say("licences") });
    button.addEventListener("click", async () => {
      button.remove();
      element(column, "pre", { tabIndex: 0, textContent: await unpacked("licences").text() });
    });
  }
}
