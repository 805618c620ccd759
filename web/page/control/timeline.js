// What a recording has besides: a slider with its clicks, the way from one to the next, and into a live run.

import { TOGETHER } from "#view/captions.js";
import { aria, write } from "#view/common.js";
import { paceText, say } from "#view/texts.js";

const SLOWEST = 1e-6; // seconds of the run per second of the viewer's, at the slider's end

export class Timeline {
  constructor(app) {
    this.app = app;
    const { whole, speed } = app.controls;
    whole.oninput = () => app.seek(Number(whole.value));
    speed.oninput = () => app.setPace(SLOWEST ** (1 - Number(speed.value)));
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

  /** From the recording into a live run, from the state that is shown. */
  goOn() {
    const { app } = this, [{ setup, state: { x, v } }] = app.sources;
    app.clock.slowAt("no");
    app.attempt(() => app.begin(setup.moving(x, v), null));
  }

  /** To the next click, or the one before; inside a click, to where balls touch or part. */
  jump(direction) {
    const { app } = this, [{ shownClick: click, now, clicks = [] }] = app.sources;
    const inside = app.clock.inside && click?.done, away = inside ? TOGETHER * click.length : 0;
    const all = inside ? click.pulses.flatMap(({ onset, release }) => [onset, release]).sort((a, b) => a - b)
      : clicks.map(({ begin }) => begin);
    const times = all.filter((time, k) => !(all[k + 1] - time <= away)); // of times that are told as one, the last
    const time = direction > 0 ? times.find((time) => time > now) : times.findLast((time) => time < now - away);
    if (inside) app.setRunning(false);
    if (time !== undefined) app.seek(time);
  }

  /** Number of the click shown, or of the last one, and why one cannot look inside. */
  clickOf({ clicks, lastClick, openable, drawing }) {
    if (!clicks.length) return say("noClicks");
    const which = lastClick ? say("clickOf", { click: lastClick.number + 1, clicks: clicks.length }) : "";
    return openable.length ? which : `${which} ${say(drawing.rigid ? "noInside" : "notResolved")}`.trim();
  }

  /** For another source: marks its clicks, as close as a slider can show. */
  changed({ live, begin, end, clicks }) {
    const { whole, marks, timeline } = this.app.controls;
    timeline.hidden = live;
    if (live) return;
    Object.assign(whole, { min: begin, max: end });
    const places = new Set(clicks.map((click) => Math.round((1000 * (click.begin - begin)) / (end - begin)) / 10));
    const stops = [...places].map((place) => `#0000 ${place}%, var(--soft) 0 calc(${place}% + 1.5px), #0000 0`);
    marks.style.backgroundImage = `linear-gradient(to right, ${stops.join() || "#0000, #0000"})`;
  }

  show({ live, now }) {
    const { clock, controls: { whole, speed, factor, previous, next } } = this.app;
    if (live) return;
    whole.value = now;
    speed.value = 1 - Math.log(clock.rate) / Math.log(SLOWEST);
    speed.disabled = clock.rate < clock.base; // a click sets it
    write(factor, paceText(clock.rate));
    aria(whole, { valuetext: `${now.toFixed(2)} s` });
    aria(speed, { valuetext: factor.textContent });
    write(previous, say(clock.inside ? "previousEvent" : "previousClick"));
    write(next, say(clock.inside ? "nextEvent" : "nextClick"));
  }
}
