// For classes: the lesson in large letters, and the question what will fly out before balls are let go.

import { LESSON } from "#engine/setup.js";
import { outcome } from "#view/captions.js";
import { element } from "#view/common.js";
import { say, textsOf } from "#view/texts.js";

const ASKING = [0, 3, 5]; // steps of the lesson in which the class is asked
const FLIES = 0.1;        // of the incoming speed: a ball that is faster has flown out
const LATER = 0.15;       // s after a click at which it is said what flew out

export class Lesson {
  /** `step`: the one presented, from 0, or null; `phase` of the question: "asks", "waits" for the click, "knows". */
  constructor(app) { Object.assign(this, { app, step: null, asks: false, phase: null }); }

  /** Presents the step with this number, from 1. */
  turnTo(number) {
    this.step = Math.min(LESSON.length, Math.max(1, Math.round(number) || 1)) - 1;
    this.asks = ASKING.includes(this.step);
    this.app.panels.close();
    this.app.controls.nextStep.hidden = this.step + 1 === LESSON.length;
    return LESSON[this.step];
  }

  next() {
    if (this.step !== null && this.step + 1 < LESSON.length) this.app.open(`present=${this.step + 2}`);
  }

  leave(asks = false) {
    Object.assign(this, { step: null, asks });
    this.enter(null);
  }

  /** Title and text at the head of the page while the lesson is presented, without the answer before it is
   *  seen, but with what is new. */
  get heading() {
    if (this.step === null) return null;
    const { title, text, asked } = textsOf("lessons")[this.step], hidden = ["asks", "waits"].includes(this.phase);
    return { title: `${this.step + 1}/${LESSON.length} ${hidden ? say("ask") : title}`, text: hidden ? asked : text };
  }

  enter(phase) {
    this.phase = phase;
    this.app.show();
  }

  /** When balls are let go: if the class is to be asked, pauses until it has answered. */
  ask() {
    const { app } = this, [{ live, setup }] = app.sources, { guesses } = app.controls;
    this.enter(this.asks && live && setup.release ? "asks" : null);
    if (!this.phase) return;
    app.setRunning(false);
    guesses.replaceChildren();
    setup.values.x_start.forEach((_, i) =>
      element(guesses, "button", { type: "button", textContent: i + 1, onclick: () => this.answer(i + 1) }));
  }

  /** Takes the class's answer; returns whether it was asked. */
  answer(guess) {
    if (this.phase !== "asks" || guess > this.app.sources[0].setup.balls) return false;
    Object.assign(this, { guess, click: null });
    this.enter("waits");
    this.app.setRunning(true);
    return true;
  }

  /** Takes a ball (from 0) that hangs as the answer, with those beyond it; returns whether it is one. */
  point(ball) {
    if (this.phase !== "asks" || ball < 0) return false;
    const { release: { x_start, v_start }, balls } = this.app.sources[0].setup;
    const away = x_start.map((x, i) => Math.abs(x) + Math.abs(v_start[i])), least = 0.1 * Math.max(...away);
    if (away[ball] > least) return false;
    return this.answer(away.findIndex((far) => far > least) < ball ? balls - ball : ball + 1);
  }

  /** Watches the first click until it is known and seen. A hand, or time that runs on, ends the question. */
  follow() {
    const { app, phase } = this, [source] = app.sources;
    if (phase && (source.holds?.size || (phase === "asks" && app.clock.running))) this.enter(null);
    if (this.phase !== "waits") return;
    source.ahead(performance.now() + 2);
    if (source.click?.done) this.click ??= source.click;
    if (source.run.time > this.click?.end + LATER && !app.clock.inside) this.enter("knows");
  }

  /** The caption below the balls: the question, or whether the class was right: {text, detail}. */
  get said() {
    const { phase, guess, click } = this;
    if (phase === "asks") return { text: say("askCount") };
    if (phase !== "knows") return null;
    const incoming = click.speeds.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a));
    const count = click.after.filter((v) => v / incoming > FLIES).length;
    return { text: say(count === guess ? "askedRight" : "askedWrong", { count, guess }), detail: outcome(click) };
  }
}
