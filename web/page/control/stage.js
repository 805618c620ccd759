// One cradle on the page: its picture, what is said about it, and what runs along.

import { Hand, Sliders } from "#control/hand.js";
import { withPrefix, write } from "#view/common.js";
import { captionOf } from "#view/captions.js";
import { aria, element } from "#view/elements.js";
import { ENERGY_PARTS, Graph, SECONDS } from "#view/graph.js";
import { drawLenses, Scene } from "#view/scene.js";
import { Scene3D } from "#view/scene3d.js";
import { power, rounded, say } from "#view/texts.js";

const MARGIN = 0.06; // of a click's length, before and after it in the graph

export class Stage {
  constructor(source, app) {
    Object.assign(this, { source, app, named: "" });
    this.figure = element(app.controls.stages, "figure", { className: "stage" });
    this.heading = element(this.figure, "figcaption", { className: "name" });
    this.canvas = element(this.figure, "canvas", { className: "cradle", role: "img" });
    const caption = element(this.figure, "div", { className: "caption" });
    this.sentence = aria(element(caption, "p", { className: "sentence" }), { live: "polite" });
    this.detail = element(caption, "p", { className: "detail" });
    this.strips = element(this.figure, "div", { className: "strips", hidden: true });
    this.graphCanvas = element(this.strips, "canvas", { className: "graph", role: "img" });
    this.titles = element(this.strips, "div", { className: "titles" });
    this.scene = new Scene(this.canvas);
    this.graph = new Graph(this.graphCanvas);
    this.hand = new Hand(this, app);
    this.sliders = new Sliders(this, app);
    this.graphCanvas.onpointerdown = ({ pointerId, offsetX }) => {
      this.graphCanvas.setPointerCapture(pointerId);
      this.seek(offsetX);
    };
    this.graphCanvas.onpointermove = ({ pointerId, offsetX }) => {
      if (this.graphCanvas.hasPointerCapture(pointerId)) this.seek(offsetX);
    };
    this.changed();
  }

  /** The source has become another one, or has another drawing. */
  changed() {
    this.sliders.fit();
    this.graph.clear(this.source.drawing.balls);
  }

  /** Shows the cradle in 3D, or flat; false where that cannot be. */
  setSpace(on) {
    if (on === this.scene instanceof Scene3D) return true;
    const { app, canvas } = this;
    const scene = on ? Scene3D.open(canvas, app.eye, () => app.loseSpace()) : new Scene(canvas);
    if (!scene) return false;
    this.scene.close();
    this.scene = scene;
    return true;
  }

  /** A click can be gone through by hand, along the graph. */
  seek(pixel) {
    if (!this.source.shownClick || !this.window || this.app.stages.length > 1) return;
    const { left, right } = this.window;
    this.app.seek(left + (pixel / this.graphCanvas.clientWidth) * (right - left) - this.source.origin);
  }

  /** Takes note of what happened since the last picture. */
  follow(passed) {
    const { source, graph } = this, { state } = source, pulses = source.takePulses();
    if (passed > 0 || !graph.rows.length) graph.record(source.time, state, pulses);
    const inside = this.app.clock.inside && source.shownClick?.strongest;
    this.scene.shine(state, pulses, Math.max(graph.strongest, inside || 0), passed);
    return pulses;
  }

  /** The picture. */
  draw(theme) {
    const { source, scene, app } = this, { state } = source, { shows, clock } = app, drawing = source.drawing;
    const held = source.held ?? new Map(), click = clock.inside ? source.shownClick : null;
    scene.layout(drawing, this.nearness(), this.room(drawing)).draw(state, {
      theme, held, labels: shows.numbers || Boolean(click) || this.sliders.chosen >= 0, selected: this.sliders.chosen,
      arrows: shows.velocity || click ? Math.max(click?.fastest ?? this.graph.fastest, 1e-3) : 0,
    });
    if (click?.widest) {
      // Half of what a lens shows (m): the play, or the deepest overlap.
      const reach = 1.3 * Math.max(click.widest, source.setup.get("contact.deadBand"));
      drawLenses(scene, state, { reach, theme, opacity: drawing.rigid ? 0 : Math.min(1, 2 * this.near - 1) });
    }
    this.describe(click);
    this.drawGraph(click, theme);
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
    const wanted = Math.min(1.1, Math.max(0.3, 1.08 * reach));
    const { swing = wanted } = this, held = this.source.holds?.size;
    if (!held) this.swing = this.app.still ? wanted : swing + 0.08 * (wanted - swing);
    return this.swing ?? wanted;
  }

  describe(click) {
    const { source, app } = this;
    const { text = "", detail = "" } = click?.done ? captionOf(click, source.run.time, source.state)
      : app.hintFor(this);
    write(this.sentence, text);
    write(this.detail, detail);
    const name = say("stageName", { name: this.named });
    if (this.canvas.getAttribute("aria-label") !== name) aria(this.canvas, { label: name });
  }

  /** What a row shows, in words. */
  title(kind, click) {
    const { source, graph } = this, { state } = source, { force, velocity } = graph.scales(click);
    if (kind === "force") return say("rows.force", { most: withPrefix(force, "N") });
    if (kind === "velocity") return say("rows.velocity", { most: withPrefix(velocity, "m/s") });
    if (kind === "momentum") {
      const momentum = say("rows.momentum", { now: `${rounded(state.momentum, 4)} kg m/s` });
      return `${momentum} · ${say("support", { force: withPrefix(state.supportForce, "N") })}`;
    }
    const parts = ENERGY_PARTS.map((part) => `<span class="${part}">${say(`energies.${part}`)}</span>`).join(" · ");
    if (!source.account) return `${say("rows.energy", { now: say("inHand") })} ${parts}`;
    const exact = say("exact", { lost: withPrefix(state.dissipated, "J"), residual: power(state.residual) });
    return `${say("rows.energy", { now: withPrefix(state.energy, "J", 6) })} · ${exact} ${parts}`;
  }

  drawGraph(click, theme) {
    const { source, app } = this, { clock } = app;
    const kinds = ["force", "velocity", "energy", "momentum"].filter((kind) => app.shows[kind]
      || (kind === "force" && click && !source.drawing.rigid));
    this.strips.style.setProperty("--rows", kinds.length);
    this.strips.hidden = !kinds.length;
    if (!kinds.length) return;
    const known = click?.sampled && click.length > 0 ? click : null, { origin, time: now } = source;
    const margin = MARGIN * known?.length;
    this.window = known ? { left: origin + known.begin - margin, right: origin + known.end + margin }
      : { left: now - SECONDS * clock.base, right: now };
    this.graph.draw(kinds, { ...this.window, now, click: known, offset: origin, theme });
    this.graphCanvas.style.cursor = known ? "ew-resize" : "";
    const titles = kinds.map((kind) => `<p>${this.title(kind, known)}</p>`).join("");
    if (this.shownTitles !== titles) this.titles.innerHTML = this.shownTitles = titles;
    if (performance.now() - (this.told ?? -Infinity) > 1000) {
      aria(this.graphCanvas, { label: this.titles.textContent });
      this.told = performance.now();
    }
  }
}
