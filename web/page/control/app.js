// The page: what is on it, and what its buttons and keys do.

import { Clock } from "#control/clock.js";
import { Guide } from "#control/guide.js";
import { listenToUser, offers } from "#control/keys.js";
import { Lesson } from "#control/lesson.js";
import { keep, kept, openLink, showLink } from "#control/link.js";
import { Panels } from "#control/panels.js";
import { Stage } from "#control/stage.js";
import { Timeline } from "#control/timeline.js";
import { Engine, Refusal } from "#engine/engine.js";
import { Live } from "#engine/live.js";
import { Recording } from "#engine/recording.js";
import { FILES, learnDefaults, PRESETS } from "#engine/setup.js";
import { aria, unpacked, write } from "#view/common.js";
import { Eye } from "#view/eye.js";
import { Sound } from "#view/sound.js";
import { learn, paceText, say, speak, textsOf, unbroken } from "#view/texts.js";
import { DAY, NIGHT } from "#view/themes.js";

const LIFT = 0.25; // of the strings' length, by the button and the keys
const FAST = 25;   // ms that a picture in 3D may take where it is offered
const WAIT = 1500; // ms before that time is measured

class App {
  /** `engine`, `recording`: null where the page has none; it has at least one of them. */
  constructor(engine, recording) {
    const asked = location.hash; // before the page writes there what it shows
    // `keys`: whether single keys do anything; `space`: whether all is shown in 3D.
    Object.assign(this, { engine, clock: new Clock(), sound: new Sound(), eye: new Eye(), side: "right", keys: true,
      space: false, stages: [], preset: "textbook" });
    this.shows = Object.fromEntries(Object.keys(textsOf("shows")).map((kind) => [kind, false]));
    this.controls = Object.fromEntries([...document.querySelectorAll("[id]")].map((item) => [item.id, item]));
    const light = matchMedia("(prefers-color-scheme: light)");
    light.onchange = () => this.setTheme(light.matches);
    light.onchange();
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.panels = new Panels(this);
    this.lesson = new Lesson(this);
    this.addStage(recording ?? new Live(engine, PRESETS.textbook.setup()));
    this.timeline = new Timeline(this);
    this.guide = new Guide(this);
    listenToUser(this);
    this.setRunning(true);
    if (recording) this.timeline.present(recording);
    else this.choose("textbook");
    if (asked && engine) this.open(asked);
    this.offerSpace();
    this.frame(performance.now());
  }

  get sources() { return this.stages.map(({ source }) => source); }
  get liveSources() { return this.sources.filter(({ live }) => live); }
  get changedSource() { return this.sources.at(this.side === "left" ? 0 : -1); }

  addStage(source) {
    this.stages.push(new Stage(source, this));
    if (this.space) this.setSpace(true);
  }

  dropStage() {
    this.besideChoice = null;
    if (this.stages.length > 1) this.stages.pop().close();
  }

  replace(source) {
    const [stage] = this.stages;
    if (stage.source !== source) stage.source.forget();
    stage.source = source;
  }

  /** Updates the page for changed sources. `released`: balls are let go anew, so the lesson may ask. */
  changed(released = true) {
    this.clock.reset();
    for (const stage of this.stages) stage.changed();
    if (released) this.lesson.ask();
    this.show();
    this.timeline.changed(this.sources[0]);
    this.panels.refresh();
  }

  /** Shows what is set: names, which buttons there are, the address. */
  show() {
    const { lesson, stages, controls, sources: [{ live }] } = this, { title, text } = lesson.heading ?? {};
    controls.title.textContent = title ?? say("title");
    const about = live ? this.preset ?? "own" : "recorded";
    const several = stages.length > 1, asks = lesson.phase === "asks";
    controls.about.textContent = text ?? (several ? "" : say(`about.${about}`, { name: stages[0].named }));
    for (const { heading, named } of stages) heading.textContent = several ? unbroken(named) : "";
    for (const name of ["again", "rest", "inside", "goOn"]) controls[name].hidden = !offers(this, name);
    controls.inside.hidden ||= asks; // it would tell the answer
    controls.space.hidden = !this.offersSpace;
    write(controls.space, say(this.space ? "flat" : "others.space"));
    controls.view.hidden = !this.space;
    controls.guesses.hidden = !asks;
    for (const [name, on] of Object.entries({ two: several, present: lesson.step !== null, asks }))
      document.body.classList.toggle(name, on);
    showLink(this);
  }

  /** Does something that the engine may refuse; then shows the reason, and nothing changes. */
  attempt(act) {
    try {
      act();
      return true;
    } catch (problem) {
      if (!(problem instanceof Refusal)) throw problem;
      this.tell(problem.message);
      return false;
    }
  }

  tell(text, lasting = 6) {
    this.controls.status.textContent = text;
    clearTimeout(this.silence);
    this.silence = setTimeout(() => { this.controls.status.textContent = ""; }, 1000 * lasting);
  }

  choose(name) { this.attempt(() => this.begin(PRESETS[name].setup(), name)); }

  begin(setup, preset) {
    const live = new Live(this.engine, setup), { warnings } = live.run;
    this.replace(live);
    // With values from an address, it may be this preset no more.
    this.preset = preset && setup.toLink(preset).startsWith("preset=") ? preset : null;
    if (this.besideChoice) this.compare(this.besideChoice);
    this.lifted = setup.release;
    this.clock.calm();
    this.setRunning(true);
    this.changed();
    if (warnings && !this.preset) this.tell(say("warnings", { text: warnings }), 20);
  }

  /** Changes values at the next instant at which no balls touch. */
  change(values) {
    const sources = this.side === "both" ? this.sources : [this.changedSource];
    if (this.attempt(() => sources.forEach((source) => source.change(values, () => this.changed(false))))) {
      this.preset = null;
      this.show();
      if (sources.some(({ pending }) => pending)) this.tell(say("waiting"), 2);
    } else this.panels.refresh();
  }

  /** Starts another run in each source; `known`: properties of the app that change with it. */
  renew(begin, known = {}) {
    this.attempt(() => this.liveSources.forEach(begin));
    Object.assign(this, known);
    this.changed();
  }

  resize(balls) {
    this.renew((source) => source.begin(source.setup.resized(balls)), { preset: null, lifted: null });
  }

  letGo(lifted) {
    this.setRunning(true);
    this.renew((source) => source.restart(source.setup, lifted.x_start, lifted.v_start), { lifted });
  }

  lift(count) {
    const { live, setup } = this.sources[0];
    if (!live || count > setup.balls) return;
    const x = -Math.round(LIFT * setup.get("pendulum.length") * 1e3) / 1e3, rest = Array(setup.balls).fill(0);
    this.letGo({ x_start: rest.map((_, i) => (i < count ? x : 0)), v_start: rest });
  }

  again() { if (this.lifted) this.letGo(this.lifted); else this.lift(1); }

  stopAll() { this.renew((source) => source.begin(source.setup.atRest())); }

  /** Shows a second cradle beside the first, different by `name` or by `values`; "stop": none. */
  compare(name, values) {
    const [{ live, setup }] = this.sources;
    this.dropStage();
    if (name !== "stop" && live) this.attempt(() => {
      const again = setup.with(this.lifted ?? {}); // from the same release
      const second = new Live(this.engine, again.with(values ?? setup.compared(name, this.preset)));
      this.replace(new Live(this.engine, again));
      this.addStage(second);
      this.besideChoice = name;
    });
    this.changed();
  }

  setRunning(on) {
    const [{ time, end }] = this.sources;
    if (on && !this.clock.running && time >= end) this.seek(0);
    this.clock.running = on;
  }

  /** Slows down at the next click, or leaves it; with reduced motion, a recording pauses at its beginning. */
  inside() {
    const { clock, still, sources: [source] } = this;
    if (clock.slow === "next" || clock.inside) return clock.slowAt("no");
    clock.slowAt("next");
    this.stages[0].heard.wait();
    if (!source.live && !source.ahead()) this.seek(source.openable.at(-1).begin);
    this.setRunning(source.live || !still);
    if (!this.clock.running) this.seek(source.now + source.ahead().distance);
  }

  /** Goes to any time of a recording, or of a live run within a click, and pauses. */
  seek(time) {
    const { clock, sources: [source] } = this;
    if (source.live) this.setRunning(false);
    clock.reset();
    source.seek(time);
    const ahead = source.ahead();
    if (!ahead && clock.slow === "next") clock.slowAt("no"); // there is no click any more to wait for
    clock.land(ahead ? [ahead] : []);
  }

  /** Goes back or on within a click, by a part of its length. */
  step(part) {
    const [{ now, shownClick: click }, other] = this.sources;
    if (click?.length && !other) this.seek(now + part * click.length);
  }

  take(who, ball, x) {
    this.attempt(() => this.sources.forEach((source) => source.hold(who, ball, x)));
    this.clock.calm();
    this.clock.reset();
  }

  move(who, ball, x) {
    for (const source of this.sources) source.hold(who, ball, x);
    if (!this.clock.running) this.attempt(() => this.sources.forEach((source) => source.place()));
  }

  drop(who, speed) {
    this.renew((source) => source.release(who, this.clock.running ? speed : 0));
    this.lifted = this.sources[0].setup.release;
  }

  frame(now) {
    requestAnimationFrame((later) => this.frame(later));
    const seconds = (now - (this.last ?? now)) / 1000, passed = Math.min(seconds, 0.1);
    this.last = now;
    try {
      if (this.clock.running) this.attempt(() => this.clock.frame(seconds, this.sources)) || this.setRunning(false);
      else for (const source of this.liveSources) source.shownClick?.work();
      if (this.sources[0].time >= this.sources[0].end) this.setRunning(false);
    } catch (problem) {
      this.setRunning(false);
      const why = problem instanceof WebAssembly.RuntimeError ? this.engine.text : problem.message;
      this.tell(`${say("problem")}: ${why}. ${say("reload")}`, 600);
    }
    this.guide.follow(passed);
    this.eye.glide(this.still);
    this.lesson.follow();
    for (const stage of this.stages) {
      const pulses = stage.follow(this.clock.running ? passed : 0);
      if (stage === this.stages[0]) this.sound.click(pulses, stage.source.drawing.mass);
      stage.draw(this.theme);
    }
    this.showClock();
  }

  showClock() {
    const { clock, controls: { time, pace, play, inside, view }, sources: [source] } = this;
    this.timeline.show(source);
    const digits = Math.max(2, Math.min(11, Math.ceil(-Math.log10(clock.rate)) + 2));
    time.textContent = `${source.now.toFixed(digits)} s`;
    const slow = clock.rate < 0.5;
    pace.textContent = clock.running || slow ? paceText(clock.rate) : say("paused");
    pace.classList.toggle("slow", slow);
    write(play, say(clock.running ? "pause" : "play"));
    write(view, say(`views.${this.eye.next}`));
    write(inside, say(clock.inside ? "insideNow" : "inside"));
    inside.classList.toggle("on", clock.slow === "next" || clock.inside);
    aria(inside, { pressed: clock.slow === "next" && !clock.inside }); // then its text says what it does
    const percent = clock.late > 0.25 && clock.running ? Math.min(90, Math.round(10 * clock.late) * 10) : null;
    if (percent && percent !== this.lateTold) this.tell(say("late", { percent }), 4);
    this.lateTold = percent;
  }

  /** The caption below the balls outside clicks: {text, detail}. */
  hintFor({ source }) {
    const { running, inside } = this.clock, { lesson, guide, stages } = this;
    if (!source.live) return { text: inside ? "" : this.timeline.clickOf(source) };
    if (source === stages[0].source && lesson.said) return lesson.said;
    if (stages.length > 1) return {};
    const rests = guide.phase || source.state.v.every((v) => v === 0);
    const hint = source.holds.size && !guide.phase ? "hintHeld" : rests ? "hint" : "";
    return running ? { text: hint && say(hint) } : { text: inside ? "" : say("hintPaused") };
  }

  /** Switches something that is shown, or another option. */
  set(kind, on) {
    if (kind in this.shows) this.shows[kind] = on;
    if (kind === "every") this.clock.slowAt(on ? "always" : "no");
    if (kind === "space") {
      this.setSpace(on);
      keep({ space: this.space });
    }
    if (kind === "sound") this.sound.switchOn(on);
    if (kind === "light") this.setTheme(on);
    if (kind === "keys") this.keys = on;
    if (kind === "ask") this.lesson.asks = on;
    this.show();
  }

  /** Offers 3D where a picture takes little time, shown if it was chosen before. */
  offerSpace() {
    const known = kept();
    this.spaceTime = known.picture ?? undefined; // JSON keeps null where there is no 3D, which is tried again
    if (known.space && !this.space) this.setSpace(true, false);
    if (this.spaceTime === undefined) setTimeout(() => {
      this.spaceTime = this.stages[0].timeOfSpace(this.theme);
      keep({ picture: this.spaceTime });
      this.show();
    }, WAIT);
    this.show();
  }

  /** Whether 3D is offered beside what else can be done. */
  get offersSpace() { return this.space || this.spaceTime < FAST; }

  /** Shows all in 3D, or flat; `tells` what came of it. */
  setSpace(on, tells = on && !this.space) {
    this.space = on && this.stages.every((stage) => stage.setSpace(true));
    if (!this.space) for (const stage of this.stages) stage.setSpace(false);
    if (tells) this.tell(say(this.space ? "turn" : "noSpace"));
    this.panels.refresh();
    this.show();
  }

  setPace(rate) {
    this.clock.base = rate;
    if (this.clock.slow === "no") this.clock.rate = rate;
  }

  setTheme(light) {
    this.theme = light ? DAY : NIGHT;
    document.documentElement.classList.toggle("light", light);
  }

  setLanguage(code) {
    speak(code);
    this.language = code;
    this.show();
    this.panels.refresh();
  }

  open(hash) { if (this.engine) this.attempt(() => openLink(this, hash)); }

  async openFile(file) {
    const text = await file?.text();
    if (file) this.attempt(() => this.timeline.present(Recording.read(file.name, text)));
  }
}

async function start() {
  if (document.querySelector("link[rel=manifest]")) navigator.serviceWorker?.register("worker.js"); // on its own site
  const data = (id) => JSON.parse(document.getElementById(id).textContent);
  learn(data("texts"), navigator.languages);
  try {
    Object.assign(FILES, data("presets"));
    learnDefaults(data("sizes")); // where no engine tells them
    const packed = document.getElementById("engine"), recorded = data("recording");
    const engine = packed && await Engine.load(await unpacked("engine").arrayBuffer());
    if (engine) learnDefaults(engine.defaults());
    const recording = recorded && await Recording.load(recorded, engine);
    for (const id of ["engine", "recording"]) document.getElementById(id)?.remove();
    window.cradle = new App(engine, recording);
  } catch (problem) {
    document.getElementById("status").textContent = `${say("problem")}: ${problem.message}`;
    throw problem;
  }
}

start();
