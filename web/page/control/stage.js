// One cradle on the page: its picture, what is said about it, and what runs along.

import { Hand, Sliders } from "#control/hand.js";
import { Strips } from "#control/strips.js";
import { aria, element, write } from "#view/common.js";
import { captionOf, describeSetup } from "#view/captions.js";
import { drawLenses, Scene } from "#view/scene.js";
import { Scene3D } from "#view/scene3d.js";
import { say } from "#view/texts.js";

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
    this.changed();
  }

  changed() {
    this.scene.glow = [];
    this.sliders.fit();
  }

  close() {
    this.source.forget();
    this.scene.close();
    this.figure.remove();
  }

  get named() { return this.source.live ? describeSetup(this.source.setup) : this.source.name; }

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
    const inside = this.app.clock.inside && source.shownClick?.most.force;
    this.scene.shine(source.state, pulses, Math.max(source.track.most.force, inside || 0), passed);
    return pulses;
  }

  draw(theme) {
    const { source, scene, app, sliders: { chosen: selected } } = this, { state, drawing } = source;
    const { shows, clock } = app, held = source.held ?? new Map(), click = clock.inside ? source.shownClick : null;
    scene.layout(drawing, this.nearness(), this.room(drawing)).draw(state, {
      theme, held, selected, labels: shows.numbers || Boolean(click) || selected >= 0,
      arrows: shows.velocity || click ? Math.max((click ?? source.track).most.velocity, 1e-3) : 0,
    });
    if (click?.most.overlap) {
      const reach = 1.3 * Math.max(click.most.overlap, source.setup.get("contact.deadBand")); // m, half of a lens
      drawLenses(scene, state, { reach, theme, opacity: drawing.rigid ? 0 : Math.min(1, 2 * this.near - 1) });
    }
    const { text = "", detail = "" } = click?.done ? captionOf(click, source.now, state) : app.hintFor(this);
    write(this.sentence, text);
    write(this.detail, detail);
    aria(this.canvas, { label: say("stageName", { name: this.named }) });
    this.strips.draw(click, theme);
  }

  /** How close the viewer is: nearer as time slows at a click. */
  nearness() {
    const { clock, still } = this.app;
    const wanted = clock.slow === "no" ? 0 : Math.log10((0.02 * clock.base) / clock.rate) / 1.3;
    const part = Math.min(1, Math.max(0, wanted)), eased = part * part * (3 - 2 * part), { near = 0 } = this;
    this.near = still ? Math.round(eased) : Math.abs(near - eased) < 1e-3 ? eased : near + 0.12 * (eased - near);
    return this.near;
  }

  /** Room for the swing, as an angle (rad). It changes gently, and not while somebody holds a ball. */
  room({ reach }) {
    const wanted = Math.min(1.4, Math.max(0.3, 1.08 * reach));
    const { swing = wanted } = this, held = this.source.holds?.size;
    if (!held) this.swing = this.app.still ? wanted : swing + 0.08 * (wanted - swing);
    return this.swing ?? wanted;
  }
}
