// Clicks in words, for people who do not see them: which ball pushed which, when, and how hard.

import { QUIET, QUIET_LEAST } from "#engine/click.js";
import { outcome } from "#view/captions.js";
import { element, withPrefix, write } from "#view/common.js";
import { say } from "#view/texts.js";

const MOST = 12;     // pushes that are told one by one
const ALIKE = 1e-3;  // of the fastest ball's speed: a difference that does not say who pushes
const ENDLESS = 200; // pulses after which the end of a click is not waited for

export class Heard {
  /** Of the cradle of a stage; screen readers read what is written. */
  constructor(stage) {
    this.stage = stage;
    this.line = element(stage.figure, "p", { className: "spoken", role: "status" });
    this.changed();
  }

  /** Another run: its first click will be told. */
  changed() { this.told = null; }

  /** Tells that a click is waited for. */
  wait() { write(this.line, say("insideNext")); }

  /** Tells the first click of a run, those that time slows down at, and those that somebody goes to. */
  follow() {
    const { source, app: { clock } } = this.stage, first = this.told === null;
    const asked = first || clock.slow !== "no" || !clock.running;
    const live = first && clock.slow === "no" ? firstClick : ({ shownClick }) => shownClick;
    const click = source.live ? live(source) : source.lastClick;
    if (!click?.pulses.length || click.begin === this.told || source.now < click.end) return;
    if (asked) write(this.line, summaryOf(click, source.drawing.masses));
    this.told = click.begin;
  }
}

/** The first click of a live run, once it is over. */
function firstClick({ pulses, state, run, track, origin, drawing: { masses } }) {
  if (!pulses.length || pulses.length > ENDLESS || !state.apart) return null;
  const begin = Math.min(...pulses.map(({ onset }) => onset)), end = Math.max(...pulses.map(({ release }) => release));
  if (run.time < end + Math.max(QUIET * (end - begin), QUIET_LEAST)) return null;
  const sorted = [...pulses].sort((a, b) => a.onset - b.onset || a.release - b.release);
  const after = track.curves.velocity.map((_, i) => track.valueAt("velocity", i, origin + end));
  const speeds = sorted.reduceRight((v, pulse) => pushed(v, pulse, masses, -1), after);
  return { begin, end, pulses: sorted, after, speeds };
}

/** The velocities after a pulse, or before it. */
function pushed(v, { contact, impulse }, masses, times = 1) {
  return v.map((speed, i) => speed + (i === contact ? -times : i === contact + 1 ? times : 0) * impulse / masses[i]);
}

/** A click in sentences. */
function summaryOf({ begin, end, pulses, speeds, after }, masses) {
  const length = end - begin, most = Math.max(...pulses.map(({ peak }) => peak));
  const rightwards = speeds.reduce((sum, speed, i) => sum + masses[i] * speed, 0) >= 0;
  const fastest = Math.max(...speeds.map(Math.abs));
  let v = Array.from(speeds);
  const told = pulses.slice(0, MOST).map((pulse) => {
    const { contact, onset, release, peak, impulse } = pulse;
    const [left, right] = [contact, contact + 1].map((i) => Math.abs(v[i])), pair = [contact + 1, contact + 2];
    const alike = Math.abs(left - right) < ALIKE * fastest;
    const [a, b] = (alike ? rightwards : left > right) ? pair : pair.reverse();
    v = pushed(v, pulse, masses);
    const time = withPrefix(onset - begin, "s", 3, length);
    return release > onset ? say("pushes", { a, b, time, force: withPrefix(peak, "N", 3, most) })
      : say("hits", { a, b, impulse: withPrefix(impulse, "N s") });
  });
  if (pulses.length > MOST) told.push(say("morePushes", { count: pulses.length - MOST }));
  const when = { time: `${begin.toFixed(3)} s`, length: withPrefix(length, "s") };
  const head = say(length ? "clickAt" : "clickOfRigid", when);
  return [head, ...told, outcome({ speeds, after })].join(" ");
}
