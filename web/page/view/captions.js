// What happens inside a click, in sentences made from its pulses.

import { withPrefix } from "#view/common.js";
import { contactName, inWords, rounded, say } from "#view/texts.js";

export const TOGETHER = 1e-3; // of a click's length, within which events are told as one

/** The caption of the last event at `now` (s of the run): {text, detail}. */
export function captionOf(click, now, state) {
  if (now < click.begin) {
    const first = click.pulses.filter(({ onset }) => onset - click.begin <= TOGETHER * click.length);
    if (!first.length) return { text: "" };
    const { contact } = fastest(first, click);
    return { text: say("approaching", { ...pair(contact), time: withPrefix(click.begin - now, "s", 2) }) };
  }
  const { length, pulses } = click;
  if (now < click.end) {
    const since = say("sinceTouch", { time: withPrefix(now - click.begin, "s", 3, length) });
    const detail = [since, strongest(click, state)].filter(Boolean).join("\u00a0· ");
    return { text: sentence(click, now, state), detail };
  }
  const text = say(length ? "over" : "overRigid", { time: withPrefix(length, "s"), count: pulses.length });
  return { text, detail: outcome(click) };
}

/** The balls of a contact, counted from 1. */
const pair = (contact) => ({ a: contact + 1, b: contact + 2 });

/** Which contact presses hardest now, or which ones, and how hard; nothing where none does. */
function strongest({ most }, { F }) {
  const [told, highest] = [(force) => withPrefix(force, "N", 3, most.force), Math.max(0, ...F)];
  const contacts = [...F.keys()].filter((i) => told(F[i]) === told(highest)).map(contactName).join(", ");
  return highest > 0 && say("strongest", { contacts, force: told(highest) }).replaceAll(" ", "\u00a0");
}

/** The pulse or event whose balls approached each other fastest. */
function fastest(events, { speeds }) {
  const closing = ({ contact }) => speeds[contact] - speeds[contact + 1];
  return events.reduce((best, event) => (closing(event) > closing(best) ? event : best));
}

/** A sentence on the last onsets or releases at `now`, and the other contacts. Balls are counted from 1. */
function sentence(click, now, state) {
  const events = click.pulses.flatMap(({ contact, onset, release }) => [
    ...(release > onset ? [{ contact, time: release, text: "part" }] : []), { contact, time: onset, text: "touch" },
  ]).filter(({ time }) => time <= now);
  const last = events.reduce((a, b) => (b.time >= a.time ? b : a), { time: -Infinity });
  const { contact, text } = last, begins = text === "touch";
  const group = events.filter((event) => event.text === text && last.time - event.time <= TOGETHER * click.length)
    .sort((a, b) => a.contact - b.contact);
  const others = [...state.closed.keys()].filter((i) => state.closed[i] && !group.some((event) => event.contact === i));
  if (group.length === 1 && others.length) {
    const away = (i) => Math.abs(i - contact), nearest = others.reduce((a, b) => (away(b) < away(a) ? b : a));
    const [first, second] = [contact, nearest].sort((a, b) => a - b);
    if (!begins) return say("partWhile", { leaver: nearest === first ? second + 2 : first + 1, ...pair(nearest) });
    if (second === first + 1)
      return say(nearest === first ? "touchWhile" : "touchWhileRight", { ...pair(first), c: first + 3 });
  }
  const told = (group.length > 2 ? [fastest(group, click)] : group).map((event) => say(text, pair(event.contact)));
  const pressed = others.length + (begins ? group.length : 0);
  if (begins && pressed > told.length && pressed === state.closed.length)
    return say("allPress", { count: pressed, number: inWords(pressed) });
  if (!begins || pressed > told.length)
    told.push(pressed ? say("pressed", { count: pressed, number: inWords(pressed) }) : say("apart"));
  return told.join(" ");
}

/** The balls that move after a click, with speeds in percent of the fastest incoming one. */
export function outcome({ speeds, after }) {
  const fastest = Math.max(...speeds.map(Math.abs)) || 1;
  const list = after.flatMap((v, i) => {
    const percent = (100 * v) / fastest, size = Math.abs(percent);
    const shown = percent.toFixed(size > 99 && size < 99.95 ? 1 : 0).replace("-", "−");
    return size < 0.5 ? [] : [say("leaver", { ball: i + 1, percent: shown })];
  });
  return list.length ? say("outcome", { list: list.join(", ") }) : say("all");
}

/** How a parameter of losses is told: its title, and the text of a value. */
export const LOSSES = {
  "contact.damping": ["loss", (value) => (value ? `${rounded(value)} N s/m` : say("none"))],
  "contact.huntCrossley": ["loss", (value) => (value ? `${rounded(value)} s/m` : say("none"))],
  "contact.relaxationTime": ["loss", (value) => (value ? withPrefix(value, "s") : say("none"))],
  "contact.restitution": ["restitution", (value) => `${rounded(100 * value)} %`],
};

/** What contacts lose, of each contact where they differ; nothing where nothing is lost. */
function lossText({ losses, lossName }) {
  const [title, told] = LOSSES[lossName], texts = losses.map(told), alike = new Set(texts).size === 1;
  return texts.length && `${say(title)}: ${alike ? texts[0] : texts.join(" : ")}`;
}

/** A set-up in a few words. */
export function describeSetup(setup) {
  const band = setup.get("contact.deadBand"), ratios = setup.get("ball.massRatio");
  return [say(`laws.${setup.law}`),
    setup.law !== "rigid" && `${say("deadBand")}: ${band ? withPrefix(band, "m") : say("none")}`,
    lossText(setup),
    setup.get("pendulum.model") === "linear" && say("besides.linear"),
    ratios.some((ratio) => ratio !== 1) && ratios.map((ratio) => rounded(ratio)).join(" : "),
  ].filter(Boolean).join(" · ");
}
