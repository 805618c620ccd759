// What opens when it is asked for: a panel with the choices of one kind.

import { fillChange } from "#control/change.js";
import { pulsesTable, runTable, save, savePicture } from "#control/keep.js";
import { offers } from "#control/keys.js";
import { copyLink } from "#control/link.js";
import { LESSON } from "#engine/setup.js";
import { aria, element, unpacked, withPrefix } from "#view/common.js";
import { languages, paceText, rounded, say, textsOf } from "#view/texts.js";

const KINDS = ["details", "change", "show", "beside", "lesson", "keep", "help"];

export class Panels {
  constructor(app) {
    this.app = app;
    this.openers = Object.fromEntries(KINDS.map((kind) => {
      const opener = element(app.controls.openers, "button",
        { type: "button", textContent: say(kind), onclick: () => this.toggle(kind) });
      opener.dataset.opens = opener.dataset.text = kind;
      return [kind, aria(opener, { controls: "panel", expanded: false })];
    }));
    this.body = app.controls.panelbody;
    app.controls.close.onclick = () => this.close();
  }

  toggle(kind) {
    const { panel, close } = this.app.controls;
    this.kind = this.kind === kind ? null : kind;
    for (const each of KINDS) aria(this.openers[each], { expanded: each === this.kind });
    panel.hidden = !this.kind;
    document.body.classList.toggle("open", Boolean(this.kind));
    if (!this.kind) return void this.openers[kind].focus();
    this.refresh();
    const [chosen, first] = ["fieldset:first-child [type=radio]:checked", "input, .column:first-child button"]
      .map((item) => this.body.querySelector(item));
    (chosen ?? first ?? close).focus();
  }

  close() { if (this.kind) this.toggle(this.kind); }

  /** Offers panels with possible choices, and fills the open one with the current values. */
  refresh() {
    for (const kind of KINDS) this.openers[kind].hidden = !offers(this.app, kind);
    if (this.openers[this.kind]?.hidden) this.close();
    if (!this.kind) return;
    const focus = document.activeElement?.dataset?.key;
    this.app.controls.paneltitle.textContent = say(this.kind);
    this.body.replaceChildren();
    this[this.kind]();
    if (focus) this.body.querySelector(`[data-key="${focus}"]`)?.focus();
  }

  /** Under the title of this name, one of these choices {key: text}, or those for which `chosen` is true. */
  chips(title, choices, chosen, choose) {
    const set = element(this.body, "fieldset"), several = typeof chosen === "function";
    element(set, "legend", { textContent: say(title) });
    const row = element(set, "div", { className: "chips" });
    for (const [key, textContent] of Object.entries(choices)) {
      const label = element(row, "label"), checked = several ? chosen(key) : key === chosen;
      const input = element(label, "input", { type: several ? "checkbox" : "radio", name: `chips ${title}`, checked });
      input.dataset.key = `${title} ${key}`;
      element(label, "span", { textContent });
      input.onchange = () => choose(key, input.checked);
    }
  }

  /** A number on a scale, or one of a list; `show` gives its text. */
  slider(title, { list, min = 0, max = list?.length - 1, step = 1, value, show, choose }) {
    const label = element(this.body, "label", { className: "field" }), range = { type: "range", min, max, step };
    element(label, "span", { textContent: say(title) });
    const output = element(label, "output"), input = element(label, "input", range);
    const tell = (shown) => { output.textContent = show(shown); aria(input, { valuetext: output.textContent }); };
    const nearest = list?.reduce((a, b) => (Math.abs(b - value) < Math.abs(a - value) ? b : a));
    const chosen = () => list?.[input.value] ?? Number(input.value);
    input.dataset.key = title;
    input.value = list?.indexOf(nearest) ?? value;
    tell(value);
    input.oninput = () => tell(chosen());
    input.onchange = () => choose(chosen());
  }

  /** A column of buttons with the texts of these names, if possible now. */
  buttons(acts) {
    const column = element(this.body, "div", { className: "column" });
    for (const [name, onclick] of Object.entries(acts))
      if (offers(this.app, name)) element(column, "button", { type: "button", textContent: say(name), onclick });
    return column;
  }

  terms(className, rows) {
    const list = element(this.body, "dl", { className, tabIndex: 0 });
    for (const [term, ...told] of rows) {
      element(list, "dt", { textContent: term });
      for (const textContent of told) if (textContent) element(list, "dd", { textContent });
    }
  }

  change() { fillChange(this); }

  show() {
    const { app } = this, { space, clock, sound, theme, keys, lesson } = app, [names, spoken] = languages();
    const on = { space, every: clock.slow === "always", sound: sound.on, light: !theme.dark, keys, ask: lesson.asks };
    const others = Object.entries(textsOf("others")).filter(([kind]) => offers(app, kind));
    this.chips("showWhat", textsOf("shows"), (kind) => app.shows[kind], (kind, on) => app.set(kind, on));
    this.chips("othersWhat", Object.fromEntries(others), (kind) => on[kind], (kind, on) => app.set(kind, on));
    this.slider("pace", { min: -6, max: 0, step: 0.25, value: Math.log10(clock.base), show: (p) => paceText(10 ** p),
      choose: (p) => app.setPace(10 ** p) });
    this.chips("languages", names, spoken, (code) => app.setLanguage(code));
  }

  beside() {
    const { app } = this;
    this.chips("besideWhat", textsOf("besides"), app.besideChoice ?? "stop", (name) => app.compare(name));
  }

  keep() {
    const { app } = this, [source] = app.sources;
    const column = this.buttons({ link: () => copyLink(app), picture: () => savePicture(app),
      pulsesFile: () => save("pulses.csv", pulsesTable(source)), runFile: () => save("run.csv", runTable(source)) });
    const label = element(column, "label", { className: "file", textContent: say("open") });
    element(label, "input", { type: "file", accept: ".csv,text/csv",
      onchange: ({ target }) => app.openFile(target.files[0]) });
  }

  lesson() {
    this.buttons({ present: () => this.app.open("present") });
    const list = element(this.body, "ol", { className: "lesson" });
    textsOf("lessons").forEach(({ title, text }, i) => {
      const item = element(list, "li");
      element(item, "a", { href: `#${LESSON[i]}`, textContent: title });
      element(item, "p", { textContent: text });
    });
  }

  /** The parameters of a recording, and how the drawing differs. */
  details() {
    const { source, scene } = this.app.stages[0], { length, radius } = source.drawing, { parameters } = source;
    const known = parameters.length > 0, larger = length / (radius * scene.long);
    const sizes = { length: withPrefix(length, "m", 4), radius: withPrefix(radius, "m") };
    const notes = [source.name, say(known ? "sizes" : "sizesAssumed", sizes)];
    if (larger > 1.01) notes.push(say("enlarged", { times: rounded(larger, 2) }));
    for (const textContent of notes) element(this.body, "p", { textContent });
    if (known) this.terms("parameters",
      parameters.map(([name, value, unit, meaning]) => [name, `${value} ${unit}`.trim(), meaning]));
  }

  help() {
    const rows = Object.entries(textsOf("keys")).filter(([name]) => offers(this.app, name));
    this.terms("keys", rows.map(([, row]) => row));
    const column = this.buttons({ licences: async ({ target }) => {
      target.remove();
      element(column, "pre", { tabIndex: 0, textContent: await unpacked("licences").text() });
    } });
  }
}
