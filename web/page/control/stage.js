// One cradle on the page: its picture, what is said about it, and what runs along.

import { Hand, Sliders } from "#control/hand.js";
import { Heard } from "#control/heard.js";
import { Strips } from "#control/strips.js";
import { aria, element, write } from "#view/common.js";
import { captionOf, describeSetup } from "#view/captions.js";
import { drawLenses } from "#view/lenses.js";
import { Scene } from "#view/scene.js";
import { Scene3D } from "#view/scene3d.js";
import { say, unbroken } from "#view/texts.js";

const MOVES = 0.05; // of the fastest ball's speed: a slower ball is not said to move
const STILL = 1e-6; // m/s
const PIXEL = new Uint8Array(4);

export class Stage {
  constructor(source, app) {
    Object.assign(this, { source, app });
    this.figure = element(app.controls.stages, "figure", { className: "stage" });
    this.heading = element(this.figure, "figcaption", { className: "name" });
    this.canvas = element(this.figure, "canvas", { className: "cradle", role: "img" });
    const caption = element(this.figure, "div", { className: "caption" });
    this.sentence = aria(element(caption, "p", { className: "sentence" }), { live: "polite" });
    this.detail = element(caption, "p", { className: "detail" });
    this.strips = new Strips(this);
    this.scene = new Scene(this.canvas);
    this.hand = new Hand(this);
    this.sliders = new Sliders(this);
    this.heard = new Heard(this);
    this.changed();
  }

  changed() {
    this.scene.glow = [];
    this.sliders.fit();
    this.heard.changed();
  }

  close() {
    this.source.forget();
    this.scene.close();
    this.figure.remove();
  }

  get named() {
    const { live, setup, name } = this.source, preset = live ? null : setup?.preset;
    return live ? describeSetup(setup) : [preset && say(`presets.${preset}`), name].filter(Boolean).join(" · ");
  }

  /** What moves now, in words. */
  get moving() {
    const { state: { v } } = this.source, most = Math.max(...v.map(Math.abs));
    const list = Array.from(v, (speed, i) => (Math.abs(speed) > MOVES * most ? i + 1 : 0)).filter(Boolean);
    return most > STILL ? say("moves", { count: list.length, list: list.join(", ") }) : say("all");
  }

  /** Shows the cradle in 3D, or flat; false if that is impossible. */
  setSpace(on) {
    if (on === this.scene instanceof Scene3D) return true;
    const { app, canvas } = this, lost = () => app.setSpace(false, true);
    const scene = on ? Scene3D.open(canvas, app.eye, lost) : new Scene(canvas);
    if (!scene) return false;
    this.scene.close();
    this.scene = scene.layout(this.source.drawing); // hands ask for places before it is drawn
    return true;
  }

  follow(passed) {
    const { source } = this, pulses = source.takePulses();
    this.hand.follow();
    this.heard.follow();
    const { inside } = this.app.clock, click = inside ? source.shownClick?.most.force : 0;
    this.scene.shine(source.state, pulses, Math.max(source.track.most.force, click ?? 0), inside ? 0 : passed);
    return pulses;
  }

  /** The largest value of this kind that is shown, in all cradles that are compared; `inside`: in their clicks. */
  most(kind, inside) {
    const most = ({ shownClick, track }) => (inside ? shownClick?.most[kind] : null) ?? track.most[kind];
    return Math.max(...this.app.sources.map(most));
  }

  /** The lowest value of this kind, likewise; away from clicks, what goes to the right will come back. */
  lowest(kind, inside) {
    const lowest = ({ shownClick, track }) => (inside ? shownClick?.lowest[kind] : null) ?? -track.most[kind];
    return ["velocity", "momentum"].includes(kind) ? Math.min(...this.app.sources.map(lowest)) : 0;
  }

  draw(theme) {
    const { source, scene, app, sliders: { chosen: selected } } = this, { state, drawing } = source;
    const { shows, clock, lesson } = app, held = source.held ?? new Map();
    const click = clock.inside ? source.shownClick : null;
    const told = shows.velocity || shows.force || lesson.phase === "knows"; // numbers of balls
    scene.layout(drawing, this.nearness(), this.room(drawing)).draw(state, {
      theme, held, selected, labels: shows.numbers || told || Boolean(click) || selected >= 0,
      arrows: shows.velocity || click ? Math.max(this.most("velocity", Boolean(click)), 1e-3) : 0,
    });
    if (click?.most.overlap) {
      const reach = 1.3 * Math.max(click.most.overlap, source.setup.get("contact.deadBand")); // m, half of a lens
      drawLenses(scene, state, { reach, theme, opacity: drawing.rigid ? 0 : Math.min(1, 2 * this.near - 1) });
    }
    const { text = "", detail = "" } = click?.done ? captionOf(click, source.now, state) : app.hintFor(this);
    write(this.sentence, unbroken(text));
    write(this.detail, unbroken(detail));
    this.tell();
    this.strips.draw(click, theme);
  }

  /** Tells screen readers, once a second, what moves and where the balls are. */
  tell() {
    const now = performance.now();
    if (now - (this.told ?? -Infinity) < 1000) return;
    this.told = now;
    aria(this.canvas, { label: `${say("stageName", { name: this.named })}. ${this.moving}` });
    this.sliders.tellAll();
  }

  /** How long a picture in 3D takes (ms); Infinity where there is none. */
  timeOfSpace(theme) {
    if (!this.setSpace(true)) return Infinity;
    const { painter, painter: { gl } } = this.scene;
    const done = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, PIXEL);
    this.draw(theme);
    done();
    painter.drawn = null; // so that it is drawn again, with shaders that have been compiled
    const begun = performance.now();
    this.draw(theme);
    done();
    const time = performance.now() - begun;
    this.setSpace(this.app.space);
    return time;
  }

  /** How close the viewer is: nearer as time slows at a click. */
  nearness() {
    const { clock, still } = this.app;
    const wanted = clock.slow === "no" ? 0 : Math.log10((0.02 * clock.base) / clock.rate) / 1.3;
    const part = Math.min(1, Math.max(0, wanted)), eased = part * part * (3 - 2 * part), { near = 0 } = this;
    this.near = still ? Math.round(eased) : Math.abs(near - eased) < 1e-3 ? eased : near + 0.12 * (eased - near);
    return this.near;
  }

  /** Room for the swing, as an angle (rad). It changes gently and, while somebody holds a ball, grows only as far as
   *  that ball is taken. */
  room({ reach, swing: { angle } }) {
    const held = [...this.source.held?.values() ?? []].map((x) => Math.abs(angle(x)));
    const widest = held.length ? Math.max(...held) : reach;
    const wanted = Math.min(1.4, Math.max(0.3, 1.08 * widest)), { swing = wanted } = this;
    const gently = this.app.still ? wanted : swing + 0.08 * (wanted - swing);
    this.swing = held.length ? Math.max(swing, gently) : gently;
    return this.swing;
  }
}
