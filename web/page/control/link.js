// What an address asks for, and the address of what is shown.

import { Setup } from "#engine/setup.js";
import { languages, say, textsOf } from "#view/texts.js";

const KEPT = "cradle";

/** The address of this page with everything that is set. */
export function linkTo(app) {
  const [{ source }, other] = app.stages, shown = Object.keys(app.shows).filter((kind) => app.shows[kind]).join(",");
  const parts = app.lesson.step === null ? [
    source.setup.toLink(app.preset), app.besideChoice && `beside=${app.besideChoice}`,
    app.clock.slow === "always" && "slow=always", shown && `show=${shown}`, app.space && "view=3d",
    app.lesson.asks && "ask", app.language && `lang=${app.language}`,
    ...(other?.source.live ? other.source.setup.besides(source.setup) : []),
  ] : [`present=${app.lesson.step + 1}`];
  return `${location.href.replace(/#.*/, "")}#${parts.filter(Boolean).join("&")}`;
}

/** What this browser has kept of earlier visits, {space, picture}; some browsers keep nothing of files. */
export function kept() {
  try {
    return JSON.parse(localStorage.getItem(KEPT)) ?? {};
  } catch {
    return {};
  }
}

export function keep(values) {
  try {
    localStorage.setItem(KEPT, JSON.stringify({ ...kept(), ...values }));
  } catch {
    // Nothing is kept: the next visit measures and chooses anew.
  }
}

/** Keeps the address of the page up to date, for copying and bookmarks. */
export function showLink(app) {
  if (!app.stages[0].source.live) return;
  try {
    history.replaceState(null, "", linkTo(app));
  } catch {
    // Some browsers forbid it for files; the button that copies the link still works.
  }
}

export async function copyLink(app) {
  const link = linkTo(app), copied = await navigator.clipboard?.writeText(link).then(() => true, () => false);
  const local = location.protocol === "file:" ? ` ${say("linkLocal")}` : "";
  if (copied) app.tell(say("copied") + local);
  else app.tell(`${say("linkHere")} ${link}${local}`, 60);
}

/** Applies the part of an address behind #. Throws Refusal. */
export function openLink(app, hash) {
  const { present } = Setup.fromLink(hash).options;
  const link = present === undefined ? hash : app.lesson.turnTo(present);
  const { setup, options } = Setup.fromLink(link), besides = textsOf("besides");
  app.engine.start(setup.recipe()).forget();
  if (link === hash) app.lesson.leave("ask" in options);
  app.dropStage();
  app.clock.slowAt("no");
  for (const kind of Object.keys(app.shows)) app.shows[kind] = (options.show ?? "").split(",").includes(kind);
  app.begin(setup, options.preset ?? (link.includes("balls=") ? null : "textbook"));
  if (Object.hasOwn(languages()[0], options.lang)) app.setLanguage(options.lang);
  if (options.lift) app.lift(Number(options.lift));
  const known = Object.keys(besides).find((name) => name === options.beside && name !== "stop");
  if (options.right || known) app.compare(known ?? "usual", options.right);
  if (options.view === "3d") app.setSpace(true);
  if (options.slow === "always") app.set("every", true);
  if (options.slow === "next") app.clock.slowAt("next");
  const choices = { lang: languages()[0], beside: options.right ? null : besides, view: { "3d": "" },
    slow: { always: "", next: "" }, show: { ...app.shows, "": "" } };
  const unknown = Object.entries(choices).filter(([name, known]) => known && name in options
    && !options[name].split(",").every((one) => Object.hasOwn(known, one)));
  const parts = unknown.map(([name]) => `${name}=${options[name]}`).join(", ");
  if (parts) app.tell(say("ignored", { parts }));
}
