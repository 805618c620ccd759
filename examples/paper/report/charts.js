// Charts of strips above a common axis, zoomable over any number of decades; those side by side move together.
// In the report it stands behind common.js of the cradle's page, whose functions it uses.

const MARGIN = { left: 70, right: 14, top: 26, bottom: 44, gap: 14 };
const DARK = matchMedia("(prefers-color-scheme: dark)"), STILL = matchMedia("(prefers-reduced-motion: reduce)");

/** The value of a colour of look.css, such as "--ink"; one given as #rrggbb is lightened where the page is dark. */
function colour(name) {
  if (name.startsWith("--")) return getComputedStyle(document.documentElement).getPropertyValue(name);
  return DARK.matches ? `color-mix(in srgb, ${name}, white 40%)` : name;
}

/** How numbers from a to b are written: from which origin they are counted, in which unit.
 *
 *  Deep in a zoom all numbers begin alike. Then `origin` is a round value below a, `name` says so; texts count from it.
 */
function notation(a, b, unit) {
  const span = b - a, largest = Math.max(Math.abs(a), Math.abs(b));
  let origin = 0, name = "";
  if (span < 1e-3 * largest) {
    const round = 10 ** Math.ceil(Math.log10(span));
    origin = Math.floor(a / round) * round;
    name = `${origin.toFixed(Math.max(0, -Math.round(Math.log10(round))))} ${unit}`;
  }
  const power = unit ? powerFor(Math.max(Math.abs(a - origin), Math.abs(b - origin))) : 0;
  return { origin, name, scale: 10 ** power, unit: unit && ` ${PREFIXES[power]}${unit}` };
}

/** Ticks of an axis from a to b: where they are, their texts, and what they are counted from. */
function ticks(a, b, count, unit) {
  const way = notation(a, b, unit), { origin, scale } = way, step = roundStep((b - a) / count);
  const digits = Math.max(0, -Math.floor(Math.log10(step / scale) + 1e-9)), list = [];
  for (let k = Math.ceil((a - origin) / step - 1e-9); k * step <= (b - origin) * (1 + 1e-12) + 1e-9 * step; k++) {
    const short = digits > 5 ? (k * step / scale).toPrecision(2) : (k * step / scale).toFixed(digits);
    list.push({ at: origin + k * step, text: short.replace("-", "−") + way.unit });
  }
  return { list, name: way.name && `${way.name} + …` };
}

/** A value in the axis's unit, to about `finest`. */
function written(value, { origin, name, scale, unit }, finest) {
  const digits = Math.max(0, Math.ceil(-Math.log10(finest / scale) - 1e-9)), number = (value - origin) / scale;
  const text = (digits > 6 ? number.toExponential(3) : number.toFixed(digits)).replace(/^-/, "−");
  return `${name && `${name} + `}${text}${unit}`;
}

/** From the smallest to the largest value, with some air. */
function rangeOf(traces) {
  let low = Infinity, high = -Infinity;
  for (const { y } of traces) for (const value of y) { low = Math.min(low, value); high = Math.max(high, value); }
  const air = 0.06 * (high - low || Math.abs(high) || 1);
  return [low === 0 ? 0 : low - air, high + air];
}

/** A curve's value at x = `at`, of points that of the nearest one; null beside the data. */
function valueAt({ x, y, style }, at) {
  const place = placeIn(x, at);
  if (style === "points") return y[place.i + Math.round(place.part)];
  return at < x[0] || at > x[x.length - 1] ? null : linear(y, place);
}

class Chart {
  /** `mates`: the charts of its figure, which show the same range; `reading`: where values are read. */
  constructor(parent, column, height, arrays, mates) {
    this.views = Object.entries(column.views).map(([label, [left, right]]) => ({ label, left, right }));
    Object.assign(this, this.views[0], { column, stripHeight: height, mates, reading: null, grip: null });
    this.strips = column.strips.map((strip) => {
      const traces = strip.traces.map((trace) => ({ ...trace, x: arrays[trace.x], y: arrays[trace.y] }));
      return { ...strip, traces, range: strip.limits ?? rangeOf(traces) };
    });
    this.build(element(parent, "figure", { className: "chart" }));
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  build(figure) {
    const { strips, views, stripHeight, column: { title, xunit } } = this, zooms = xunit !== "" || views.length > 1;
    const bar = element(figure, "div", { className: "bar" }), legend = element(figure, "p", { className: "legend" });
    if (title) element(bar, "span", { textContent: title });
    const button = (textContent, onclick) => element(bar, "button", { type: "button", textContent, onclick });
    this.buttons = zooms ? views.map((view) => button(view.label, () => this.show(view))) : [];
    for (const [text, label, factor] of zooms ? [["+", "zoom in", 0.5], ["−", "zoom out", 2]] : [])
      aria(button(text, () => this.zoom(factor)), { label });
    for (const { label, colour: shade } of strips.flatMap(({ traces }) => traces).filter(({ label }) => label)) {
      const item = element(legend, "span");
      element(item, "i").style.background = shade.startsWith("--") ? `var(${shade})` : shade;
      item.append(label);
    }
    for (const part of [bar, legend]) if (!part.textContent) part.remove();
    this.canvas = element(figure, "canvas", { tabIndex: 0, role: "img" });
    aria(this.canvas, { label: `${title}: ${strips.map((strip) => strip.label).join(", ")}` });
    const inner = strips.length * (stripHeight + MARGIN.gap) - MARGIN.gap;
    this.canvas.style.height = `${MARGIN.top + inner + MARGIN.bottom}px`;
    this.spoken = aria(element(figure, "p", { className: "spoken" }), { live: "polite" });
  }

  listen() {
    const { canvas } = this;
    canvas.onwheel = (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY * 0.002), this.timeAt(event.offsetX));
    };
    canvas.onpointerdown = ({ pointerId, offsetX }) => {
      canvas.setPointerCapture(pointerId);
      this.grip = this.timeAt(offsetX);
      this.read(this.grip);
    };
    canvas.onpointerup = canvas.onpointercancel = () => { this.grip = null; };
    canvas.onpointermove = ({ offsetX }) => {
      const shift = this.grip === null ? 0 : this.grip - this.timeAt(offsetX);
      if (shift) this.set(this.left + shift, this.right + shift);
      this.read(this.timeAt(offsetX));
    };
    canvas.onpointerleave = ({ pointerType }) => { if (pointerType === "mouse") this.read(null); };
    canvas.onblur = () => this.read(null);
    canvas.ondblclick = () => this.show(this.views[0]);
    canvas.onkeydown = (event) => this.key(event);
  }

  key(event) {
    const span = this.right - this.left, side = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (side && event.shiftKey) {
      const next = (this.reading ?? 0.5 * (this.left + this.right)) + 0.01 * side * span;
      this.read(Math.min(this.right, Math.max(this.left, next)));
      const { at, values } = this.readings();
      this.spoken.textContent = [at, ...values.flat().map(({ name, text }) => `${name} ${text}`)].join("; ");
    } else if (side) this.set(this.left + 0.1 * side * span, this.right + 0.1 * side * span);
    else if (event.key === "+" || event.key === "=") this.zoom(0.5);
    else if (event.key === "-") this.zoom(2);
    else if (event.key === "0" || event.key === "Home") this.show(this.views[0]);
    else if (event.key === "Escape") this.read(null);
    else return;
    event.preventDefault();
  }

  /** Reads all strips at a place on the axis, null for none. */
  read(at) { this.share({ reading: at }); }

  /** Draws with new properties, here and in the charts beside it. */
  share(properties) { for (const mate of this.mates) Object.assign(mate, properties).draw(); }

  /** What is read, in the units of the axes: the place, and for each strip its traces' values: {name, colour, text}. */
  readings() {
    const { reading, left, right, column } = this, finest = (right - left) / Math.max(1, this.inner);
    const values = this.strips.map(({ range: [low, high], unit, traces, label }) => traces.flatMap((trace) => {
      const value = valueAt(trace, reading), way = notation(low, high, unit);
      const told = { name: trace.label || label, colour: trace.colour };
      return value === null ? [] : [{ ...told, text: written(value, way, (high - low) / 2000) }];
    }));
    return { at: written(reading, notation(left, right, column.xunit), finest), values };
  }

  /** Width of the strips in pixels. */
  get inner() { return this.canvas.clientWidth - MARGIN.left - MARGIN.right; }

  timeAt(pixel) {
    return this.left + (this.right - this.left) * (pixel - MARGIN.left) / this.inner;
  }

  /** Narrows (factor < 1) or widens what is shown around `fixed`. */
  zoom(factor, fixed = 0.5 * (this.left + this.right)) {
    this.set(fixed + (this.left - fixed) * factor, fixed + (this.right - fixed) * factor);
  }

  /** Shows the range from `left` to `right` at once, as far as the data and double precision go. */
  set(left, right) {
    const finest = Math.max(1e-12 * Math.max(Math.abs(left), Math.abs(right)), 1e-15);
    const widest = 1.5 * Math.max(...this.views.map((view) => view.right - view.left));
    if (right - left < finest || right - left > widest) return;
    this.turn = null;
    this.share({ left, right });
  }

  /** Moves to a view so that the eye can follow: the width shrinks or grows by the same factor in each frame. */
  show(view) {
    const from = { left: this.left, right: this.right }, begin = performance.now();
    const [w0, w1] = [from.right - from.left, view.right - view.left];
    const decades = Math.abs(Math.log10(w0 / w1));
    const duration = STILL.matches ? 0 : 300 + 220 * decades, turn = {};
    for (const mate of this.mates) mate.turn = turn;
    const frame = (now) => {
      if (this.turn !== turn) return;
      const part = Math.min(1, (now - begin) / duration || 1), eased = part * part * (3 - 2 * part);
      const width = w0 * (w1 / w0) ** eased, rest = w0 === w1 ? 1 - eased : (width - w1) / (w0 - w1);
      const left = part === 1 ? view.left : view.left + (from.left - view.left) * rest;
      this.share({ left, right: part === 1 ? view.right : left + width });
      if (part < 1) requestAnimationFrame(frame);
    };
    frame(begin);
  }

  draw() {
    if (!this.canvas.clientWidth) return;
    const { strips, stripHeight, left, right, inner, column, reading, canvas } = this;
    const { context, height } = prepared(canvas), bottom = height - MARGIN.bottom;
    const across = ticks(left, right, Math.max(2, inner / 110), column.xunit);
    const px = (x) => MARGIN.left + inner * (x - left) / (right - left);
    const read = reading === null ? null : this.readings();
    Object.assign(this, { context, px, end: MARGIN.left + inner });
    strips.forEach((strip, number) => {
      const top = MARGIN.top + number * (stripHeight + MARGIN.gap);
      this.drawStrip(strip, top, across.list, read?.values[number] ?? []);
    });
    this.drawAxis(across, bottom);
    if (read) this.drawReading(read.at, bottom);
    this.buttons.forEach((button, i) =>
      aria(button, { pressed: this.views[i].left === left && this.views[i].right === right }));
  }

  drawStrip(strip, top, across, values) {
    const { context, px, end, stripHeight } = this, [low, high] = strip.range, bottom = top + stripHeight;
    const py = (y) => bottom - stripHeight * (y - low) / (high - low);
    const grid = colour("--line");
    for (const { at } of across) line(context, [[px(at), top], [px(at), bottom]], grid);
    const style = { fillStyle: colour("--soft"), textAlign: "right", textBaseline: "middle" };
    for (const { at, text } of ticks(low, high, Math.max(2.4, stripHeight / 34), strip.unit).list) {
      line(context, [[MARGIN.left, py(at)], [end, py(at)]], grid);
      Object.assign(context, style).fillText(text, MARGIN.left - 6, py(at));
    }
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, top - 2, end - MARGIN.left, stripHeight + 4);
    context.clip();
    for (const trace of strip.traces) this.drawTrace(trace, py);
    context.restore();
    // Name of the strip, and the values that are read.
    this.plate(strip.label, MARGIN.left + 6, top + 1);
    values.forEach(({ colour: shade, text }, i) => {
      const y = top + 1 + 15 * i, edge = this.plate(text, end - 6, y, 1, 14);
      context.fillStyle = colour(shade);
      context.fillRect(edge - 12, y + 2, 9, 9);
    });
  }

  drawTrace({ x, y, colour: name, style }, py) {
    const { context, px, left, right } = this, shade = colour(name), dashed = style === "dashed";
    const points = thinned(x, left, right, px, (i) => py(y[i]));
    context.setLineDash(dashed ? [5, 4] : []);
    if (style === "points") for (const [x, y] of points) circle(context, { x, y }, 3.2, shade);
    else line(context, points, shade, dashed ? 1.1 : 1.6, style === "area" ? 0.22 : 0, py(0));
    context.setLineDash([]);
  }

  /** A text that stays readable on the curves, with a `part` of it to the left of `x` and `air` (px) before it; returns
   *  its left end. */
  plate(text, x, y, part = 0, air = 2) {
    const { context } = this, wide = context.measureText(text).width, left = x - part * wide;
    Object.assign(context, { fillStyle: colour("--card"), globalAlpha: 0.85 });
    context.fillRect(left - air, y - 1, wide + air + 2, 15);
    Object.assign(context, { fillStyle: colour("--ink"), globalAlpha: 1, textAlign: "left", textBaseline: "top" });
    context.fillText(text, left, y);
    return left;
  }

  /** The line at which values are read, and where that is. */
  drawReading(text, bottom) {
    const { context, end } = this, pixel = this.px(this.reading), half = context.measureText(text).width / 2;
    if (pixel < MARGIN.left || pixel > end) return;
    context.fillStyle = colour("--edge");
    context.fillRect(pixel - 0.5, MARGIN.top - 4, 1, bottom - MARGIN.top + 4);
    this.plate(text, Math.min(Math.max(pixel, MARGIN.left + half), end - half), 6, 0.5);
  }

  drawAxis({ list, name }, y) {
    const { context, end, column: { xlabel }, canvas: { clientWidth } } = this;
    line(context, [[MARGIN.left, y + 0.5], [end, y + 0.5]], colour("--edge"));
    Object.assign(context, { fillStyle: colour("--soft"), textAlign: "center", textBaseline: "top" });
    for (const { at, text } of list) context.fillText(text, this.px(at), y + 6);
    const label = name ? `${xlabel}: ${name}` : xlabel;
    const half = Math.min(context.measureText(label).width, clientWidth) / 2;
    context.fillText(label, Math.min((MARGIN.left + end) / 2, clientWidth - half), y + 25);
  }
}

const { figures, arrays } = JSON.parse(document.getElementById("data").textContent), charts = {};
const numbers = await Promise.all(arrays.map(async (packed) => (await columnsOf(packed)).get("")));
for (const { name, columns, height } of figures) {
  const parent = document.querySelector(`#${name} .charts`);
  const row = charts[name] = [];
  for (const column of columns) row.push(new Chart(parent, column, height, numbers, row));
}
DARK.onchange = () => { for (const chart of Object.values(charts).flat()) chart.draw(); };
window.report = { charts };
