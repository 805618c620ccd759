// What buttons and single keys do.

import { SECONDS } from "#view/graph.js";

const INSIDE_STEP = 0.01; // of a click's length
const TIME_STEP = 0.02;   // of what the strips show of a recording
const PANELS = { c: "change", r: "details", s: "show", b: "beside", k: "keep", l: "lesson", "?": "help", h: "help" };
const ACTS = {
  " ": (app) => app.setRunning(!app.clock.running), i: (app) => app.inside(), a: (app) => app.again(),
  0: (app) => app.stopAll(), e: (app) => app.setOther("every", app.clock.slow !== "always"),
  d: (app) => app.setOther("space", !app.space), v: (app) => { if (app.space) app.eye.lookOn(); },
  p: (app) => app.open("present"), n: (app) => app.lesson.next(),
  ",": (app) => stepInside(app, -1), ".": (app) => stepInside(app, 1),
  "[": (app) => app.timeline.jump(-1), "]": (app) => app.timeline.jump(1),
  ArrowLeft: (app) => stepTime(app, -1), ArrowRight: (app) => stepTime(app, 1),
  Escape: ({ panels, lesson }) => { if (panels.kind) panels.close(); else if (lesson.step !== null) lesson.leave(); },
};

const BUTTONS = { play: " ", again: "a", rest: 0, inside: "i", view: "v" };

export function listenToUser(app) {
  for (const [name, key] of Object.entries(BUTTONS)) app.controls[name].onclick = () => ACTS[key](app);
  addEventListener("keydown", (event) => press(app, event));
  // A button that was clicked does not take the space bar, which pauses; one that the keyboard has come to does.
  addEventListener("click", ({ detail }) =>
    { if (detail && document.activeElement?.matches("button")) document.activeElement.blur(); });
}

/** Does what a key that was pressed stands for, unless something of the page takes it itself. */
function press(app, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const at = (selector) => event.target.matches?.(selector), typing = at("#panel input");
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, taken = { " ": "button" }[key] ?? "input";
  if (typing || ((key === " " || key.startsWith("Arrow")) && at(taken)) || !(app.keys || key === "Escape")) return;
  const act = /^[1-9]$/.test(key) ? () => app.lesson.answer(Number(key)) || app.lift(Number(key))
    : PANELS[key] ? () => app.panels.toggle(PANELS[key]) : ACTS[key];
  if (act) event.preventDefault();
  act?.(app);
}

/** Back or on within a click. */
function stepInside(app, direction) {
  const { source } = app.stages[0], click = source.shownClick;
  if (click?.length && app.stages.length === 1) app.seek(source.now + direction * INSIDE_STEP * click.length);
}

/** Back or on in a recording. */
function stepTime(app, direction) {
  const [source] = app.sources;
  if (!source.live) app.seek(source.now + direction * TIME_STEP * SECONDS * app.clock.rate);
}
