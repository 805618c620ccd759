// One cradle on the page: its picture, what is said about it, and what runs along.

const MARGIN = 0.06; // of a click's length, before and after it in the graph

class Stage {
  constructor(source, app) {
    Object.assign(this, { source, app, strongest: 1e-9, named: "" });
    const make = (name, kind, parent) => Object.assign(parent.appendChild(document.createElement(name)), { className: kind });
    this.figure = document.createElement("figure");
    this.figure.className = "stage";
    this.heading = make("figcaption", "name", this.figure);
    this.canvas = make("canvas", "cradle", this.figure);
    this.canvas.setAttribute("role", "img");
    this.caption = make("div", "caption", this.figure);
    this.sentence = make("p", "sentence", this.caption);
    this.sentence.setAttribute("aria-live", "polite");
    this.detail = make("p", "detail", this.caption);
    this.strips = make("div", "strips", this.figure);
    this.strips.hidden = true;
    this.graphCanvas = make("canvas", "graph", this.strips);
    this.graphCanvas.setAttribute("role", "img");
    this.titles = make("div", "titles", this.strips);
    this.scene = new Scene(this.canvas);
    this.graph = new Graph(this.graphCanvas);
    this.hand = new Hand(this, app);
    this.sliders = new Sliders(this, app);
    this.listen();
    this.changed();
  }

  /** The source has become another one, or has another drawing. */
  changed() {
    this.sliders.fit();
    this.graph.clear(this.source.drawing.balls);
    this.strongest = 1e-9;
  }

  /** A click can be gone through by hand. */
  listen() {
    const to = (event) => {
      const click = this.source.shownClick;
      if (!click || !this.window || this.app.stages.length > 1) return;
      const part = event.offsetX / this.graphCanvas.clientWidth, { left, right } = this.window;
      this.app.seek(left + part * (right - left) - this.source.origin);
    };
    this.graphCanvas.addEventListener("pointerdown", (event) => { this.graphCanvas.setPointerCapture(event.pointerId); this.scrubbing = true; to(event); });
    this.graphCanvas.addEventListener("pointermove", (event) => { if (this.scrubbing) to(event); });
    for (const name of ["pointerup", "pointercancel"]) this.graphCanvas.addEventListener(name, () => { this.scrubbing = false; });
  }

  /** Takes note of what happened since the last picture. */
  follow(passed) {
    const { source, graph } = this, { state } = source, pulses = source.takePulses();
    for (const { peak } of pulses) this.strongest = Math.max(this.strongest, peak);
    if (this.app.clock.inside && source.shownClick?.strongest) this.strongest = Math.max(this.strongest, source.shownClick.strongest);
    for (const force of state.F) this.strongest = Math.max(this.strongest, force);
    this.scene.shine(state, pulses, this.strongest, passed, passed === 0);
    if (passed > 0 || !graph.count) graph.record(source.time, state, pulses);
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
    const opacity = click && !drawing.rigid ? Math.min(1, Math.max(0, (this.near ?? 0) * 2 - 1)) : 0;
    if (click?.sampled && click.widest) drawLenses(scene, state, { reach: this.lensReach(click), theme, opacity });
    this.describe(click);
    this.drawGraph(click, theme);
  }

  /** How close the viewer is: nearer as time slows at a click. */
  nearness() {
    const { clock, still } = this.app, wanted = clock.slow === "no" ? 0 : Math.log10((0.02 * clock.base) / clock.rate) / 1.3;
    const eased = Math.min(1, Math.max(0, wanted)) ** 2 * (3 - 2 * Math.min(1, Math.max(0, wanted)));
    this.near = still ? Math.round(eased) : (this.near ?? 0) + 0.12 * (eased - (this.near ?? 0));
    if (Math.abs(this.near - eased) < 1e-3) this.near = eased;
    return this.near;
  }

  /** Room for the swing, as an angle (rad). It changes gently, and not while somebody holds a ball. */
  room({ reach }) {
    const wanted = Math.min(1.1, Math.max(0.3, 1.08 * reach));
    if (!this.source.holds?.size) this.swing = this.app.still ? wanted : (this.swing ?? wanted) + 0.08 * (wanted - (this.swing ?? wanted));
    return this.swing ?? wanted;
  }

  /** Half of what a lens shows (m): the play, or the deepest overlap. */
  lensReach(click) {
    const { setup } = this.source;
    return 1.3 * Math.max(click.widest, setup ? setup.get("contact.deadBand") : 0);
  }

  describe(click) {
    const { source, app } = this;
    const { text, detail } = click?.done ? captionOf(click, source.run.time, source.state) : app.hintFor(this);
    if (this.sentence.textContent !== text) this.sentence.textContent = text;
    if (this.detail.textContent !== detail) this.detail.textContent = detail;
    const name = say("stageName", this.named);
    if (this.canvas.getAttribute("aria-label") !== name) this.canvas.setAttribute("aria-label", name);
  }

  /** What the rows show, in words. */
  titlesOf(kinds, click) {
    const { source, graph } = this, { state } = source, { force, velocity } = graph.scales(click);
    return kinds.map((kind) => {
      if (kind === "energy") {
        const parts = ENERGY_PARTS.map((part) => `<span class="${part}">${say(`energies.${part}`)}</span>`).join(" · ");
        if (!source.account) return `${say("rows.energy", say("inHand"))} ${parts}`;
        return `${say("rows.energy", quantity(state.energy, "J", 6))} · ${say("exact", quantity(state.dissipated, "J"), power(state.residual))} ${parts}`;
      }
      if (kind === "momentum") return `${say("rows.momentum", `${rounded(state.momentum, 4)} kg m/s`)} · ${say("support", quantity(state.supportForce, "N"))}`;
      return kind === "force" ? say("rows.force", quantity(force, "N")) : say("rows.velocity", quantity(velocity, "m/s"));
    });
  }

  drawGraph(click, theme) {
    const { source, app } = this, { clock } = app;
    const kinds = ["force", "velocity", "energy", "momentum"].filter((kind) => app.shows[kind] || (kind === "force" && click && !source.drawing.rigid));
    this.strips.style.setProperty("--rows", kinds.length);
    this.strips.hidden = !kinds.length;
    if (!kinds.length) return;
    const known = click?.sampled && click.length > 0, now = source.time, span = SECONDS * clock.base;
    this.window = known
      ? { left: source.origin + click.begin - MARGIN * click.length, right: source.origin + click.end + MARGIN * click.length }
      : { left: now - span, right: now };
    this.graph.draw(kinds, { ...this.window, now, click: known ? click : null, offset: source.origin ?? 0, theme });
    this.graphCanvas.style.cursor = known ? "ew-resize" : "";
    const titles = this.titlesOf(kinds, known ? click : null), rows = this.titles.children;
    while (rows.length > titles.length) rows[rows.length - 1].remove();
    while (rows.length < titles.length) this.titles.append(document.createElement("p"));
    titles.forEach((title, i) => { if (rows[i].innerHTML !== title) rows[i].innerHTML = title; });
    const plain = this.titles.textContent;
    if (performance.now() - (this.told ?? -Infinity) > 1000) { this.graphCanvas.setAttribute("aria-label", plain); this.told = performance.now(); }
  }
}
