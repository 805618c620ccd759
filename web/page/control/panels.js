// What opens when it is asked for: a panel with the choices of one kind.

import { fillChange } from "#control/change.js";
import { pulsesTable, runTable, save, savePicture } from "#control/keep.js";
import { copyLink } from "#control/link.js";
import { LESSON, PRESETS } from "#engine/setup.js";
import { withPrefix } from "#view/common.js";
import { aria, element, unpacked } from "#view/elements.js";
import { fillTexts, languages, paceText, rounded, say, textsOf } from "#view/texts.js";

const KINDS = ["details", "change", "show", "beside", "lesson", "keep", "help"];

export class Panels {
  constructor(app) {
    this.app = app;
    this.openers = Object.fromEntries(KINDS.map((kind) => {
      const opener = element(app.controls.openers, "button", { type: "button", onclick: () => this.toggle(kind) });
      opener.dataset.opens = opener.dataset.text = kind;
      return [kind, aria(opener, { controls: "panel", expanded: false })];
    }));
    this.body = app.controls.panelbody;
    fillTexts();
    app.controls.close.onclick = () => this.close();
    app.controls.panel.onkeydown = ({ key }) => { if (key === "Escape") this.close(); };
  }

  /** Only what there is to be done with this source, and with an engine or without one. */
  offer({ live }, engine) {
    const needs = { details: !live, change: engine, beside: engine && live, lesson: engine };
    for (const kind of KINDS) this.openers[kind].hidden = !(needs[kind] ?? true);
    if (this.openers[this.kind]?.hidden) this.close();
  }

  toggle(kind) {
    const { panel, paneltitle, close } = this.app.controls, opener = this.openers[kind];
    if (kind !== this.kind && opener.hidden) return;
    this.kind = this.kind === kind ? null : kind;
    for (const each of KINDS) aria(this.openers[each], { expanded: each === this.kind });
    panel.hidden = !this.kind;
    document.body.classList.toggle("open", Boolean(this.kind));
    if (!this.kind) return void opener.focus();
    paneltitle.dataset.text = this.kind;
    fillTexts();
    this.refresh();
    const first = ["fieldset:first-child [type=radio]:checked", "input, .column:first-child button"];
    (first.map((kind) => this.body.querySelector(kind)).find(Boolean) ?? close).focus();
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

  /** Under the title of this name, one of several, by their names in the table of texts `texts`, or as this function
   *  says; or, with checkboxes, those for which `chosen` is true. */
  chips(title, names, texts, chosen, choose) {
    const set = element(this.body, "fieldset"), several = typeof chosen === "function";
    element(set, "legend", { textContent: say(title) });
    const row = element(set, "div", { className: "chips" });
    for (const key of names) {
      const label = element(row, "label"), checked = several ? chosen(key) : key === chosen;
      const input = element(label, "input", { type: several ? "checkbox" : "radio", name: `chips ${title}`, checked });
      input.dataset.key = `${title} ${key}`;
      const text = typeof texts === "function" ? texts(key) : say(texts ? `${texts}.${key}` : key);
      element(label, "span", { textContent: text });
      input.addEventListener("change", () => choose(key, input.checked));
    }
  }

  /** A number on a scale, or one of a list; `show` says it in words. */
  slider(title, { list, min = 0, max = list?.length - 1, step = 1, value, show, choose }) {
    const label = element(this.body, "label", { className: "field" }), range = { type: "range", min, max, step };
    element(label, "span", { textContent: say(title) });
    const output = element(label, "output"), input = element(label, "input", range);
    const tell = (shown) => { output.textContent = show(shown); aria(input, { valuetext: output.textContent }); };
    const nearest = list?.reduce((a, b) => (Math.abs(b - value) < Math.abs(a - value) ? b : a));
    const chosen = () => list?.[input.value] ?? Number(input.value);
    input.dataset.key = title;
    input.value = list?.indexOf(nearest) ?? value;
    tell(nearest ?? value);
    input.oninput = () => tell(chosen());
    input.onchange = () => choose(chosen());
  }

  // ---- panels

  change() { fillChange(this); }

  presets() {
    this.chips("preset", Object.keys(PRESETS), "presets", this.app.preset, (name) => this.app.choose(name));
  }

  show() {
    const { app } = this;
    this.chips("showWhat", Object.keys(textsOf("shows")), "shows", (kind) => app.shows[kind],
      (kind, on) => app.setShow(kind, on));
    const { space, clock, sound, theme, keys, lesson } = app;
    const on = { space, every: clock.slow === "always", sound: sound.on, light: !theme.dark, keys, ask: lesson.asks };
    this.chips("othersWhat", Object.keys(on), "others", (kind) => on[kind],
      (kind, checked) => app.setOther(kind, checked));
    this.slider("pace", {
      min: -6, max: 0, step: 0.25, value: Math.log10(app.clock.base), show: (p) => paceText(10 ** p),
      choose: (p) => app.setPace(10 ** p),
    });
    const [names, spoken] = languages();
    this.chips("languages", Object.keys(names), (code) => names[code], spoken, (code) => app.setLanguage(code));
  }

  beside() {
    const { app } = this;
    this.chips("besideWhat", Object.keys(textsOf("besides")), "besides", app.besideChoice ?? "stop",
      (name) => app.compare(name));
  }

  keep() {
    const { app } = this, column = element(this.body, "div", { className: "column" }), { source } = app.stages[0];
    const buttons = { link: () => copyLink(app), picture: () => savePicture(app),
      pulsesFile: () => save("pulses.csv", pulsesTable(source)), runFile: () => save("run.csv", runTable(source)) };
    for (const [name, onclick] of Object.entries(buttons))
      if (source.live || name === "picture")
        element(column, "button", { type: "button", textContent: say(name), onclick });
    const label = element(column, "label", { className: "file", textContent: say("open") });
    element(label, "input", { type: "file", accept: ".csv,text/csv",
      onchange: ({ target }) => app.openFile(target.files[0]) });
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

  /** What a recording was run with, and how the drawing departs from it. */
  details() {
    const { source, scene } = this.app.stages[0], { length, radius } = source.drawing, { parameters } = source;
    const known = parameters.length > 0, larger = length / (radius * scene.long);
    const note = (textContent) => element(this.body, "p", { textContent });
    note(source.name);
    note(say(known ? "sizes" : "sizesAssumed",
      { length: withPrefix(length, "m", 4), radius: withPrefix(radius, "m") }));
    if (larger > 1.01) note(say("enlarged", { times: rounded(larger, 2) }));
    if (!known) return;
    const list = element(this.body, "dl", { className: "parameters", tabIndex: 0 });
    for (const [name, value, unit, meaning] of parameters) {
      element(list, "dt", { textContent: name });
      element(list, "dd", { textContent: `${value} ${unit}`.trim() });
      if (meaning) element(list, "dd", { textContent: meaning, className: "meaning" });
    }
  }

  help() {
    const list = element(this.body, "dl", { className: "keys" });
    for (const [key, meaning] of textsOf("keys")) {
      element(list, "dt", { textContent: key });
      element(list, "dd", { textContent: meaning });
    }
    const column = element(this.body, "div", { className: "column" });
    element(column, "button", { type: "button", textContent: say("licences"), onclick: async ({ target }) => {
      target.remove();
      element(column, "pre", { tabIndex: 0, textContent: await unpacked("licences").text() });
    } });
  }
}
