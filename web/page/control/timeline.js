// What a recording has besides: a slider over the whole of it with a mark for each click, the way from click to click,
// how fast time runs, and the way into a live run.

import { Live } from "#engine/live.js";
import { TOGETHER } from "#view/captions.js";
import { prepared, write } from "#view/common.js";
import { aria } from "#view/elements.js";
import { paceText, say } from "#view/texts.js";

const THUMB = 16; // px of a slider's handle

export class Timeline {
  constructor(app) {
    this.app = app;
    const { whole, speed, previous, next, goon } = app.controls;
    whole.oninput = () => app.seek(Number(whole.value));
    speed.oninput = () => app.setPace(this.slowest ** (1 - Number(speed.value)));
    previous.onclick = () => this.jump(-1);
    next.onclick = () => this.jump(1);
    goon.onclick = () => app.attempt(() => this.goOn());
  }

  /** Shows a recording from its start on; its first click is slow, where motion need not be reduced. */
  present(recording) {
    const { app } = this;
    app.guide.leave();
    app.lesson.leave();
    app.dropStage();
    app.replace(recording);
    app.shows.numbers = true;
    app.clock.slowAt(app.still || !recording.openable.length ? "no" : "next");
    app.setRunning(!app.still);
    app.changed();
  }

  /** From the recording into a live run, from the state that is shown. Throws Refusal. */
  goOn() {
    const { app } = this, [{ made, state }] = app.sources, live = new Live(app.engine, made.atRest());
    live.restart(made, Array.from(state.x), Array.from(state.v));
    app.replace(live);
    Object.assign(app, { preset: null, lifted: live.setup.release });
    app.clock.slowAt("no");
    app.setRunning(true);
    app.changed();
  }

  /** Slows down at the next click; where motion is to be reduced, it stands still at its beginning. */
  inside() {
    const { app } = this, [source] = app.sources;
    if (!source.openable.length) return app.tell(this.clickOf(source));
    app.clock.slowAt("next");
    if (!source.ahead()) app.seek(source.openable.at(-1).begin);
    app.setRunning(!app.still);
    if (app.still) app.seek(source.now + source.ahead().distance);
  }

  /** To the next click, or the one before; inside a click, to where balls touch or part. */
  jump(direction) {
    const { app } = this, [{ shownClick: click, now, clicks = [] }] = app.sources;
    const inside = app.clock.inside && click?.done, away = inside ? TOGETHER * click.length : 0;
    const all = inside ? click.pulses.flatMap(({ onset, release }) => [onset, release]).sort((a, b) => a - b)
      : clicks.map(({ begin }) => begin);
    const times = all.filter((time, k) => !(all[k + 1] - time <= away)); // the last of those that are told as one
    const time = direction > 0 ? times.find((time) => time > now) : times.findLast((time) => time < now - away);
    if (time === undefined) return;
    if (inside) app.setRunning(false);
    app.seek(time);
  }

  /** Which click is shown, or was last, and why one cannot look inside. */
  clickOf({ clicks, lastClick, openable, drawing }) {
    if (!clicks.length) return say("noClicks");
    const why = openable.length ? "" : say(drawing.rigid ? "noInside" : "notResolved");
    const which = lastClick ? say("clickOf", { click: lastClick.number + 1, clicks: clicks.length }) : "";
    return `${which} ${why}`.trim();
  }

  /** Another source is shown. */
  changed({ live, begin, end, pulses, made }) {
    const { controls, engine } = this.app, { whole, timeline } = controls;
    timeline.hidden = live;
    for (const name of ["again", "rest"]) controls[name].hidden = !live;
    controls.goon.hidden = live || !made || !engine;
    if (live) return;
    Object.assign(whole, { min: begin, max: end });
    const shortest = pulses.reduce((least, { onset, release }) => Math.min(least, release - onset || least), 2e-3);
    this.slowest = 10 ** Math.floor(Math.log10(shortest / 2));
    this.drawn = null;
  }

  /** What changes with the time shown. */
  show({ live, now }) {
    const { clock, controls: { whole, speed, factor, previous, next } } = this.app;
    if (live) return;
    whole.value = now;
    speed.value = 1 - Math.log(clock.base) / Math.log(this.slowest);
    write(factor, paceText(clock.base));
    aria(whole, { valuetext: `${now.toFixed(2)} s` });
    aria(speed, { valuetext: factor.textContent });
    write(previous, say(clock.inside ? "previousEvent" : "previousClick"));
    write(next, say(clock.inside ? "nextEvent" : "nextClick"));
    this.drawMarks();
  }

  drawMarks() {
    const { theme, controls: { marks }, stages: [{ source }] } = this.app, key = `${marks.clientWidth} ${theme.dark}`;
    if (this.drawn === key) return;
    const { context, width, height } = prepared(marks), scale = (width - THUMB) / (source.end - source.begin);
    context.fillStyle = theme.soft;
    for (const { begin, length } of source.clicks)
      context.fillRect(THUMB / 2 + (begin - source.begin) * scale - 0.75, 0, Math.max(1.5, length * scale), height);
    this.drawn = key;
  }
}
