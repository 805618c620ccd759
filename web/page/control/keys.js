// What buttons and single keys do, and what there is to be done.

import { SECONDS } from "#view/graph.js";

const INSIDE_STEP = 0.01; // of a click's length
const TIME_STEP = 0.02 * SECONDS; // on the viewer's clock
const SYMBOLS = { ArrowLeft: "←", ArrowRight: "→", Escape: "⎋" };

const toggle = (app, key, name) => app.panels.toggle(name);
const way = (key) => (",←".includes(key) ? -1 : 1);

/** Keys, condition and action, by the name of their text, button or panel. */
const ACTS = {
  ball: ["", "live"], pull: ["", "live"], letGo: ["", "live"], // of the sliders in hand.js
  play: [" ", "any", (app) => app.setRunning(!app.clock.running)],
  lift: ["123456789", "live", (app, key) => app.lesson.answer(Number(key)) || app.lift(Number(key))],
  inside: ["i", "clicks", (app) => app.inside()],
  every: ["e", "clicks", (app) => app.set("every", app.clock.slow !== "always")],
  step: [",.", "clicks", (app, key) => app.step(way(key) * INSIDE_STEP)],
  again: ["a", "live", (app) => app.again()],
  rest: ["0", "live", (app) => app.stopAll()],
  jump: ["", "recorded"],
  previous: ["[", "recorded", (app) => app.timeline.jump(-1)],
  next: ["]", "recorded", (app) => app.timeline.jump(1)],
  goOn: ["", "both", (app) => app.timeline.goOn()],
  time: ["←→", "recorded", (app, key) => app.seek(app.sources[0].now + way(key) * TIME_STEP * app.clock.rate)],
  space: ["d", "any", (app) => app.set("space", !app.space)],
  view: ["v", "any", (app) => { if (app.space) app.eye.look(); }],
  details: ["r", "recorded", toggle], change: ["c", "engine", toggle], show: ["s", "any", toggle],
  beside: ["b", "live", toggle], keep: ["k", "any", toggle], help: ["?h", "any", toggle],
  lesson: ["l", "engine", toggle],
  present: ["p", "engine", (app) => app.open("present")],
  nextStep: ["n", "engine", (app) => app.lesson.next()],
  endLesson: ["", "engine", (app) => app.lesson.leave()],
  leave: ["⎋", "any", ({ panels, lesson }) => {
    if (panels.kind) panels.close();
    else if (lesson.step !== null) lesson.leave();
  }],
  ask: ["", "engine"], link: ["", "setup"],
};

/** Whether the action of this name is possible now. */
export function offers({ engine, sources: [{ live, openable, setup }] }, name) {
  const runs = Boolean(engine && setup), [, need] = ACTS[name] ?? ["", "any"];
  return { any: true, live, recorded: !live, clicks: live || openable.length > 0, engine: Boolean(engine), setup: runs,
    both: runs && !live }[need];
}

export function listenToUser(app) {
  for (const [name, [, , act]] of Object.entries(ACTS))
    if (app.controls[name]?.matches("button")) app.controls[name].onclick = () => act(app);
  addEventListener("keydown", (event) => press(app, event));
  addEventListener("hashchange", () => app.open(location.hash));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    app.openFile(event.dataTransfer.files[0]);
  });
  // A button that was clicked does not take the space bar, which pauses; one that the keyboard has come to does.
  addEventListener("click", ({ detail }) =>
    { if (detail && document.activeElement?.matches("button")) document.activeElement.blur(); });
}

/** Does the action of a pressed key, unless an element of the page takes it. */
function press(app, event) {
  const key = SYMBOLS[event.key] ?? event.key.toLowerCase(), taken = { " ": "button, #panel input" }[key];
  if (event.ctrlKey || event.metaKey || event.altKey || key.length !== 1) return;
  if (key !== "⎋" && event.target.matches?.(taken ?? ("←→".includes(key) ? "input" : "#panel input"))) return;
  if (!app.keys && key !== "⎋") return;
  const [name, [, , act]] = Object.entries(ACTS).find(([, [keys]]) => keys.includes(key)) ?? ["", []];
  if (!act || !offers(app, name)) return;
  event.preventDefault();
  act(app, key, name);
}
