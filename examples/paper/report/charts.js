"use strict";
// Charts of strips above a common axis, drawn on a canvas, zoomable over any number of decades.

const MARGIN = { left: 70, right: 14, top: 8, bottom: 44, gap: 14 };
const PREFIXES = { 9: "G", 6: "M", 3: "k", 0: "", "-3": "m", "-6": "µ", "-9": "n", "-12": "p", "-15": "f" };
const INK = "#1c2430", SOFT = "#5b6675", GRID = "#e8ebef", FONT = "12px system-ui, sans-serif";

/** Bytes in base64 as an array of numbers; kind: f4 or f8. */
function decoded({ kind, data }) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  return kind === "f8" ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer);
}

/** 1, 2 or 5 times a power of ten, such that about `count` steps make up `span`. */
function niceStep(span, count) {
  const raw = span / count, power = 10 ** Math.floor(Math.log10(raw));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= raw * 0.999);
}

/** Ticks of an axis from a to b: where they are, their texts, and what the texts are counted from.
 *
 *  Deep in a zoom all numbers begin alike. Then `origin` names a round value below a, and the texts count from there.
 */
function ticks(a, b, count, unit) {
  const span = b - a, step = niceStep(span, count), largest = Math.max(Math.abs(a), Math.abs(b));
  let origin = 0, name = "";
  if (span < 1e-3 * largest) {
    const round = 10 ** Math.ceil(Math.log10(span));
    origin = Math.floor(a / round) * round;
    name = `${origin.toFixed(Math.max(0, -Math.round(Math.log10(round))))} ${unit} + …`;
  }
  const extent = Math.max(Math.abs(a - origin), Math.abs(b - origin));
  const power = unit ? 3 * Math.floor(Math.log10(extent * 1.0001) / 3) : 0;
  const scale = power in PREFIXES ? 10 ** power : 1, prefix = power in PREFIXES ? PREFIXES[power] : "";
  const digits = Math.max(0, -Math.floor(Math.log10(step / scale) + 1e-9));
  const list = [];
  for (let k = Math.ceil((a - origin) / step - 1e-9); k * step <= (b - origin) * (1 + 1e-12) + 1e-9 * step; k++) {
    const short = digits > 5 ? (k * step / scale).toPrecision(2) : (k * step / scale).toFixed(digits);
    list.push({ at: origin + k * step, text: unit ? `${short} ${prefix}${unit}` : short });
  }
  return { list, name };
}

/** First index of a rising array whose value is not below `value`. */
function lowerBound(array, value) {
  let low = 0, high = array.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (array[middle] < value) low = middle + 1; else high = middle;
  }
  return low;
}

class Chart {
  constructor(parent, column, height, arrays) {
    this.column = column;
    this.stripHeight = height;
    this.views = column.views.map(([label, left, right]) => ({ label, left, right }));
    this.strips = column.strips.map((strip) => ({
      ...strip,
      traces: strip.traces.map((trace) => ({ ...trace, x: arrays[trace.x], y: arrays[trace.y] })),
    }));
    for (const strip of this.strips) strip.range = strip.limits ?? Chart.range(strip.traces);
    this.left = this.views[0].left;
    this.right = this.views[0].right;
    this.build(parent);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  /** From the smallest to the largest value, with some air. */
  static range(traces) {
    let low = Infinity, high = -Infinity;
    for (const { y } of traces) for (const value of y) { low = Math.min(low, value); high = Math.max(high, value); }
    const air = 0.06 * (high - low || Math.abs(high) || 1);
    return [low === 0 ? 0 : low - air, high + air];
  }

  build(parent) {
    const figure = document.createElement("figure"), bar = document.createElement("div"), title = document.createElement("span");
    figure.className = "chart";
    bar.className = "bar";
    title.textContent = this.column.title;
    bar.append(title);
    const zooms = this.column.xunit !== "" || this.views.length > 1;
    this.buttons = this.views.filter(() => zooms).map((view) => this.button(bar, view.label, () => this.show(view)));
    if (zooms) {
      this.button(bar, "+", () => this.zoom(0.5)).title = "zoom in";
      this.button(bar, "−", () => this.zoom(2)).title = "zoom out";
    }
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${this.column.title}: ${this.strips.map((strip) => strip.label).join(", ")}`);
    this.canvas.style.height = `${this.height()}px`;
    figure.append(...(zooms || title.textContent ? [bar] : []), this.canvas);
    parent.append(figure);
    this.listen();
  }

  button(bar, text, action) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = text;
    button.addEventListener("click", action);
    bar.append(button);
    return button;
  }

  height() {
    const count = this.strips.length;
    return MARGIN.top + count * this.stripHeight + (count - 1) * MARGIN.gap + MARGIN.bottom;
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY * 0.002), this.timeAt(event.offsetX));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => { this.grip = event.offsetX; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointerup", () => { this.grip = null; });
    canvas.addEventListener("pointermove", (event) => {
      this.pointer = event.offsetX;
      if (this.grip != null) {
        const shift = this.timeAt(this.grip) - this.timeAt(event.offsetX);
        this.grip = event.offsetX;
        this.set(this.left + shift, this.right + shift);
      } else this.draw();
    });
    canvas.addEventListener("pointerleave", () => { this.pointer = null; this.draw(); });
    canvas.addEventListener("dblclick", () => this.show(this.views[0]));
    canvas.addEventListener("keydown", (event) => {
      const step = 0.1 * (this.right - this.left);
      if (event.key === "ArrowLeft") this.set(this.left - step, this.right - step);
      else if (event.key === "ArrowRight") this.set(this.left + step, this.right + step);
      else if (event.key === "+") this.zoom(0.5);
      else if (event.key === "-") this.zoom(2);
      else return;
      event.preventDefault();
    });
  }

  timeAt(pixel) {
    const width = this.canvas.clientWidth - MARGIN.left - MARGIN.right;
    return this.left + (this.right - this.left) * (pixel - MARGIN.left) / width;
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
    [this.left, this.right] = [left, right];
    this.draw();
  }

  /** Moves to a view so that the eye can follow: the width shrinks or grows by the same factor in each frame. */
  show(view) {
    const from = { left: this.left, right: this.right }, begin = performance.now();
    const [w0, w1] = [from.right - from.left, view.right - view.left];
    const decades = Math.abs(Math.log10(w0 / w1));
    const duration = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 300 + 220 * decades;
    const turn = this.turn = {};
    const frame = (now) => {
      if (this.turn !== turn) return;
      const part = Math.min(1, (now - begin) / duration || 1), eased = part * part * (3 - 2 * part);
      const width = w0 * (w1 / w0) ** eased, rest = w0 === w1 ? 1 - eased : (width - w1) / (w0 - w1);
      this.left = part === 1 ? view.left : view.left + (from.left - view.left) * rest;
      this.right = part === 1 ? view.right : this.left + width;
      this.draw();
      if (part < 1) requestAnimationFrame(frame);
    };
    frame(begin);
  }

  draw() {
    const ratio = devicePixelRatio || 1, canvas = this.canvas, width = canvas.clientWidth, height = this.height();
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = FONT;
    const inner = width - MARGIN.left - MARGIN.right;
    const across = ticks(this.left, this.right, Math.max(2, inner / 110), this.column.xunit);
    this.strips.forEach((strip, number) => {
      const top = MARGIN.top + number * (this.stripHeight + MARGIN.gap);
      this.drawStrip(context, strip, top, inner, across);
    });
    this.drawAxis(context, across, inner, height);
    this.buttons.forEach((button, i) => {
      const { left, right } = this.views[i];
      button.setAttribute("aria-pressed", String(left === this.left && right === this.right));
    });
  }

  drawStrip(context, strip, top, inner, across) {
    const [low, high] = strip.range, bottom = top + this.stripHeight;
    const px = (x) => MARGIN.left + inner * (x - this.left) / (this.right - this.left);
    const py = (y) => bottom - (bottom - top) * (y - low) / (high - low);
    context.lineWidth = 1;
    context.strokeStyle = GRID;
    context.fillStyle = SOFT;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.beginPath();
    for (const { at } of across.list) { context.moveTo(px(at), top); context.lineTo(px(at), bottom); }
    for (const { at, text } of ticks(low, high, Math.max(2.4, this.stripHeight / 34), strip.unit).list) {
      context.moveTo(MARGIN.left, py(at));
      context.lineTo(MARGIN.left + inner, py(at));
      context.fillText(text, MARGIN.left - 6, py(at));
    }
    context.stroke();
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, top - 2, inner, bottom - top + 4);
    context.clip();
    for (const trace of strip.traces) this.drawTrace(context, trace, px, py, inner);
    context.restore();
    this.drawTexts(context, strip, top, inner);
  }

  drawTrace(context, { x, y, colour, style }, px, py, inner) {
    const first = Math.max(0, lowerBound(x, this.left) - 1), last = Math.min(x.length - 1, lowerBound(x, this.right));
    context.strokeStyle = context.fillStyle = colour;
    if (style === "points") {
      for (let i = first; i <= last; i++) {
        context.beginPath();
        context.arc(px(x[i]), py(y[i]), 3.2, 0, 2 * Math.PI);
        context.fill();
      }
      return;
    }
    const path = Chart.path(x, y, first, last, px, py, inner);
    if (style === "area") {
      const area = new Path2D(path);
      area.lineTo(px(x[last]), py(0));
      area.lineTo(px(x[first]), py(0));
      context.globalAlpha = 0.22;
      context.fill(area);
      context.globalAlpha = 1;
    }
    context.setLineDash(style === "dashed" ? [5, 4] : []);
    context.lineWidth = style === "dashed" ? 1.1 : 1.6;
    context.lineJoin = "round";
    context.stroke(path);
    context.setLineDash([]);
  }

  /** The polyline; where many points share a pixel column, only its first, lowest, highest and last. */
  static path(x, y, first, last, px, py, inner) {
    const path = new Path2D();
    path.moveTo(px(x[first]), py(y[first]));
    if (last - first < 4 * inner) {
      for (let i = first + 1; i <= last; i++) path.lineTo(px(x[i]), py(y[i]));
      return path;
    }
    for (let i = first; i <= last;) {
      const column = Math.floor(px(x[i])), begin = i;
      let low = y[i], high = y[i];
      for (; i <= last && Math.floor(px(x[i])) === column; i++) { low = Math.min(low, y[i]); high = Math.max(high, y[i]); }
      for (const value of [y[begin], low, high, y[i - 1]]) path.lineTo(column + 0.5, py(value));
    }
    return path;
  }

  /** Name of the strip or its legend, and the values under the pointer. */
  drawTexts(context, strip, top, inner) {
    context.textBaseline = "top";
    context.textAlign = "left";
    context.fillStyle = INK;
    context.fillText(strip.label, MARGIN.left + 6, top + 1);
    const named = strip.traces.filter((trace) => trace.label);
    named.forEach(({ colour, label }, i) => {
      context.fillStyle = colour;
      context.textAlign = "right";
      context.fillText(label, MARGIN.left + inner - 6, top + 1 + 15 * i);
    });
    if (this.pointer == null || this.pointer < MARGIN.left || named.length) return;
    const trace = strip.traces[0], at = this.timeAt(this.pointer);
    const i = lowerBound(trace.x, at);
    if (i < 1 || i >= trace.x.length) return;
    const part = (at - trace.x[i - 1]) / (trace.x[i] - trace.x[i - 1]);
    const value = trace.y[i - 1] + part * (trace.y[i] - trace.y[i - 1]);
    context.strokeStyle = "#9aa4b0";
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(this.pointer, top);
    context.lineTo(this.pointer, top + this.stripHeight);
    context.stroke();
    context.textAlign = "right";
    context.fillStyle = trace.colour;
    context.fillText(`${value.toPrecision(4)} ${strip.unit}`, MARGIN.left + inner - 6, top + 1);
  }

  drawAxis(context, across, inner, height) {
    const y = height - MARGIN.bottom;
    context.strokeStyle = "#aab3be";
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(MARGIN.left, y + 0.5);
    context.lineTo(MARGIN.left + inner, y + 0.5);
    context.stroke();
    context.fillStyle = SOFT;
    context.textBaseline = "top";
    context.textAlign = "center";
    for (const { at, text } of across.list) {
      context.fillText(text, MARGIN.left + inner * (at - this.left) / (this.right - this.left), y + 6);
    }
    const label = across.name ? `${this.column.xlabel}: ${across.name}` : this.column.xlabel;
    context.fillText(label, MARGIN.left + inner / 2, y + 25);
  }
}

window.report = (() => {
  const { figures, arrays } = JSON.parse(document.getElementById("data").textContent);
  const numbers = arrays.map(decoded), charts = {};
  for (const figure of figures) {
    const parent = document.querySelector(`#${figure.name} .charts`);
    charts[figure.name] = figure.columns.map((column) => new Chart(parent, column, figure.height, numbers));
  }
  return { charts };
})();
