// What runs below a cradle: rows of curves, their values at the time shown or at the pointer, dragging in time.

import { aria, element, roundStep, withPrefix, write } from "#view/common.js";
import { colourOf, FINE, Graph, SECONDS, THIN, UNITS } from "#view/graph.js";
import { contactName, rounded, say } from "#view/texts.js";

const MARGIN = 0.06; // of a click's length, before and after it
const MOST_VALUES = 6; // of one row; of more curves the value that is furthest from 0 is told
const NEAR = 3;      // px from the pointer within which a spike is read

export class Strips {
  constructor(stage) {
    Object.assign(this, { stage, app: stage.app, pointer: null, heights: [] }); // `heights`: of titles, px
    // What scrolls can be reached by the keyboard.
    this.box = element(stage.figure, "div", { className: "strips", hidden: true, role: "group", tabIndex: 0 });
    const canvas = this.canvas = element(this.box, "canvas", { className: "graph", role: "img" });
    this.titles = element(this.box, "div", { className: "titles" });
    this.more = element(stage.figure, "p", { className: "more" });
    this.graph = new Graph(canvas);
    canvas.onpointerdown = ({ pointerId, offsetX }) => {
      if (!this.canSeek) return;
      canvas.setPointerCapture(pointerId);
      this.frozen = this.window;
      this.seek(offsetX);
    };
    canvas.onpointermove = ({ pointerId, offsetX }) => {
      this.pointer = offsetX;
      if (canvas.hasPointerCapture(pointerId)) this.seek(offsetX);
    };
    canvas.onpointerup = canvas.onpointercancel = () => { this.frozen = null; };
    canvas.onpointerleave = () => { this.pointer = null; };
  }

  /** Whether dragging in time is possible: in a recording, or in a live run within a known click. */
  get canSeek() {
    const { source } = this.stage;
    return this.window && this.app.stages.length === 1 && Boolean(!source.live || source.shownClick);
  }

  seek(pixel) {
    this.app.setRunning(false);
    this.app.seek(this.graph.timeAt(pixel, this.window));
  }

  draw(click, theme) {
    const { stage: { source }, app, graph, canvas } = this, known = click?.sampled && click.length > 0 ? click : null;
    const track = known?.samples ?? source.track, { origin, [known ? "now" : "time"]: now } = source; // in its run
    const kinds = ["force", "velocity", "energy", "momentum"].filter((kind) => track.curves[kind].length
      && (app.shows[kind] || (kind === "force" && click)) && !(kind === "force" && source.drawing.rigid));
    this.box.style.setProperty("--rows", kinds.length);
    this.box.hidden = !kinds.length || app.lesson.phase === "asks"; // nothing has moved yet
    aria(this.box, { label: say("showWhat") });
    if (this.box.hidden) return write(this.more, "");
    this.window = this.frozen ?? this.around(known);
    const pointer = this.pointer === null ? null : graph.timeAt(this.pointer, this.window);
    const [most, lowest] = ["most", "lowest"].map((end) => (kind) => this.stage[end](kind, Boolean(known)));
    const titles = kinds.map((_, i) => Math.max(...app.stages.map(({ strips }) => strips.heights[i] ?? 0))); // in all
    graph.draw(kinds, track, { ...this.window, now, pointer, most, lowest, titles, click: known,
      origin: known?.begin ?? origin, theme });
    canvas.style.cursor = this.canSeek ? "ew-resize" : "";
    write(this.more, this.hiddenOf(kinds)); // before what is written would have to be laid out for it
    this.write(kinds.map((kind) => this.title(kind, track, pointer ?? now, roundStep(most(kind), FINE), theme)));
    const { clientWidth: width } = canvas, { shape, told } = this;
    if (told?.shape === shape && told.width === width && performance.now() - told.time < 1000) return;
    aria(canvas, { label: this.titles.textContent });
    this.heights = [...this.titles.children].map(({ firstChild }) => firstChild.offsetHeight);
    this.told = { shape, width, time: performance.now() };
  }

  /** The rows that are scrolled out of view, in words. */
  hiddenOf(kinds) {
    const { scrollTop, clientHeight, scrollHeight } = this.box, row = scrollHeight / kinds.length;
    const hidden = kinds.filter((_, i) => (i + 0.5) * row < scrollTop || (i + 0.5) * row > scrollTop + clientHeight);
    return hidden.length ? say("scroll", { list: hidden.map((kind) => say(`shows.${kind}`)).join(", ") }) : "";
  }

  /** The time shown, {left, right} (s): a click, a recording around now, or a live run up to now. */
  around(click) {
    const { stage: { source }, app: { clock } } = this, { live, begin, end, time: now } = source;
    const span = SECONDS * clock.base, margin = MARGIN * click?.length;
    if (click) return { left: click.begin - margin, right: click.end + margin };
    const left = live ? Math.max(now - span, source.track.times[0])
      : Math.max(begin, Math.min(now - span / 2, end - span));
    return { left, right: live ? Math.max(now, left + clock.base) : Math.min(left + span, end) };
  }

  /** The parts of a row's title, with its values at this time and the unit of its scale, which ends at `most`: [text],
   *  or [name, value, colours]. */
  title(kind, track, at, most, theme) {
    const curves = track.times.length > 1 ? track.curves[kind] : [], { left, right } = this.window;
    const pixel = (right - left) / this.canvas.clientWidth;
    const several = curves.map((_, i) => track.valueAt(kind, i, at, NEAR * pixel));
    const thin = this.canvas.clientWidth <= THIN;
    const names = { velocity: (i) => (thin ? String(i + 1) : say("ball", { ball: i + 1 })), force: contactName,
      momentum: () => "", energy: (i) => say(`energies.${track.parts[i]}`) }[kind];
    const largest = several.reduce((best, value, i) => (Math.abs(value) > Math.abs(several[best]) ? i : best), 0);
    const told = several.length > MOST_VALUES ? [largest] : [...several.keys()];
    const parts = (value) => /^(\S+) (.*)$/.exec(withPrefix(value, UNITS[kind], 3, most)).slice(1);
    const [, unit] = parts(0), color = kind === "energy" || theme.dark ? theme.label : theme.halo;
    const values = told.map((i) =>
      [names(i), parts(several[i])[0], { background: colourOf(kind, i, track, theme), color }]);
    return [[`${say(`shows.${kind}`)} (${unit})`], ...values, [this.sum(kind)]];
  }

  /** Writes the titles of rows; where only texts have changed, only these. */
  write(titles) {
    const shape = titles.map((parts) => parts.length).join();
    if (this.shape !== shape) this.titles.replaceChildren(...titles.map(emptyTitle));
    this.shape = shape;
    titles.forEach((parts, row) => parts.forEach(([text, value, colours], i) => {
      const part = this.titles.children[row].firstChild.childNodes[2 * i];
      if (value === undefined) return write(part, text);
      write(part.firstChild, text);
      Object.assign(part.firstChild.style, colours);
      write(part.lastChild, text ? `: ${value}` : value);
    }));
  }

  /** Further text about energy and momentum of a live run. */
  sum(kind) {
    const { live, account, state, track } = this.stage.source;
    if (live && kind === "momentum") return `· ${say("support", { force: withPrefix(state.supportForce, "N") })}`;
    if (!live || kind !== "energy") return "";
    const [total, lost] = [state.energy, state.dissipated]
      .map((sum) => withPrefix(sum, "J", 6, roundStep(track.most.energy, FINE)));
    if (!account) return `· ${say("inHand")}`;
    const sums = `· ${say("sums", { total, lost })}`, residual = rounded(state.residual, 2);
    return this.canvas.clientWidth > THIN ? `${sums} · ${say("error", { residual })}` : sums;
  }
}

/** A row's title with room for these parts, and a space after each: names as chips, and values. */
function emptyTitle(parts) {
  const row = document.createElement("div"), line = element(row, "p");
  for (const [, value] of parts) {
    const part = value === undefined ? line.appendChild(new Text()) : element(line, "span");
    if (value !== undefined) for (const name of ["i", "b"]) element(part, name);
    line.append(" ");
  }
  return row;
}
