// Charts of strips above a common axis, zoomable over any number of decades; those side by side move together.

const MARGIN = { left: 70, right: 14, top: 26, bottom: 44, gap: 14 };

/** An element with these properties and children. */
function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
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
    this.mates = [this]; // the charts that show the same range
    this.reading = null; // where values are read
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
    const { title, xunit } = this.column, bar = make("div", { className: "bar" }, make("span", { textContent: title }));
    const zooms = xunit !== "" || this.views.length > 1;
    this.buttons = this.views.filter(() => zooms).map((view) => this.button(bar, view.label, () => this.show(view)));
    if (zooms) {
      for (const [text, name, factor] of [["+", "zoom in", 0.5], ["−", "zoom out", 2]]) {
        this.button(bar, text, () => this.zoom(factor)).setAttribute("aria-label", name);
      }
    }
    const named = this.strips.flatMap(({ traces }) => traces).filter(({ label }) => label);
    this.legend = make("p", { className: "legend" }, ...named.map(({ label, colour: shade }) => {
      const patch = make("i");
      patch.style.background = shade.startsWith("--") ? `var(${shade})` : shade;
      return make("span", {}, patch, label);
    }));
    this.canvas = make("canvas", { tabIndex: 0, role: "img" });
    this.canvas.ariaLabel = `${title}: ${this.strips.map((strip) => strip.label).join(", ")}`;
    const count = this.strips.length, inner = count * this.stripHeight + (count - 1) * MARGIN.gap;
    this.canvas.style.height = `${MARGIN.top + inner + MARGIN.bottom}px`;
    this.spoken = make("p", { className: "spoken", ariaLive: "polite" });
    const above = [...(zooms || title ? [bar] : []), ...(named.length ? [this.legend] : [])];
    parent.append(make("figure", { className: "chart" }, ...above, this.canvas, this.spoken));
    this.listen();
  }

  button(bar, textContent, onclick) {
    return bar.appendChild(make("button", { type: "button", textContent, onclick }));
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      this.zoom(Math.exp(event.deltaY * 0.002), this.timeAt(event.offsetX));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      this.grip = event.offsetX;
      canvas.setPointerCapture(event.pointerId);
      this.read(this.timeAt(event.offsetX));
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { this.grip = null; });
    canvas.addEventListener("pointermove", (event) => {
      if (this.grip != null) {
        const shift = this.timeAt(this.grip) - this.timeAt(event.offsetX);
        this.grip = event.offsetX;
        this.set(this.left + shift, this.right + shift);
      }
      this.read(this.timeAt(event.offsetX));
    });
    canvas.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") this.read(null); });
    canvas.addEventListener("blur", () => this.read(null));
    canvas.addEventListener("dblclick", () => this.show(this.views[0]));
    canvas.addEventListener("keydown", (event) => this.key(event));
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
    const at = this.reading, finest = (this.right - this.left) / Math.max(1, this.inner);
    const values = this.strips.map((strip) => {
      const [low, high] = strip.range, way = notation(low, high, strip.unit);
      return strip.traces.flatMap(({ x, y, colour, style, label }) => {
        const value = Chart.valueAt(x, y, at, style === "points");
        if (value === null) return [];
        return [{ name: label || strip.label, colour, text: written(value, way, (high - low) / 2000) }];
      });
    });
    return { at: written(at, notation(this.left, this.right, this.column.xunit), finest), values };
  }

  /** A curve's value at x = `at`, of points that of the nearest one; null beside the data. */
  static valueAt(x, y, at, nearest) {
    const place = placeIn(x, at);
    if (nearest) return y[place.i + Math.round(place.part)];
    return at < x[0] || at > x[x.length - 1] ? null : linear(y, place);
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
    const { context, height } = prepared(this.canvas), inner = this.inner;
    const read = this.reading === null ? null : this.readings();
    const across = ticks(this.left, this.right, Math.max(2, inner / 110), this.column.xunit);
    this.strips.forEach((strip, number) => {
      const top = MARGIN.top + number * (this.stripHeight + MARGIN.gap);
      this.drawStrip(context, strip, top, inner, across, read?.values[number]);
    });
    this.drawAxis(context, across, inner, height);
    if (read) this.drawReading(context, read.at, inner, height);
    this.buttons.forEach((button, i) => {
      const { left, right } = this.views[i];
      button.setAttribute("aria-pressed", String(left === this.left && right === this.right));
    });
  }

  drawStrip(context, strip, top, inner, across, values) {
    const [low, high] = strip.range, bottom = top + this.stripHeight;
    const px = (x) => MARGIN.left + inner * (x - this.left) / (this.right - this.left);
    const py = (y) => bottom - (bottom - top) * (y - low) / (high - low);
    context.lineWidth = 1;
    context.strokeStyle = colour("--line");
    context.fillStyle = colour("--soft");
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
    this.drawTexts(context, strip, top, inner, values);
  }

  drawTrace(context, { x, y, colour: shade, style }, px, py, inner) {
    const first = Math.max(0, countUpTo(x, this.left) - 1), last = Math.min(x.length - 1, countUpTo(x, this.right));
    context.strokeStyle = context.fillStyle = colour(shade);
    if (style === "points") {
      for (let i = first; i <= last; i++) {
        context.beginPath();
        context.arc(px(x[i]), py(y[i]), 3.2, 0, 2 * Math.PI);
        context.fill();
      }
      return;
    }
    const path = this.path(x, y, first, last, px, py, inner);
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
  path(x, y, first, last, px, py, inner) {
    const path = new Path2D();
    path.moveTo(px(x[first]), py(y[first]));
    if (last - first < 4 * inner) {
      for (let i = first + 1; i <= last; i++) path.lineTo(px(x[i]), py(y[i]));
      return path;
    }
    for (let i = first; i <= last;) {
      const column = Math.floor(px(x[i])), begin = i;
      let low = y[i], high = y[i];
      for (; i <= last && Math.floor(px(x[i])) === column; i++) {
        low = Math.min(low, y[i]);
        high = Math.max(high, y[i]);
      }
      for (const value of [y[begin], low, high, y[i - 1]]) path.lineTo(column + 0.5, py(value));
    }
    return path;
  }

  /** Name of the strip, and the values that are read. */
  drawTexts(context, strip, top, inner, values) {
    context.textBaseline = "top";
    this.plate(context, strip.label, MARGIN.left + 6, top + 1, "left", colour("--ink"));
    (values ?? []).forEach(({ colour: shade, text }, i) => {
      const y = top + 1 + 15 * i, right = MARGIN.left + inner - 6;
      const left = this.plate(context, text, right, y, "right", colour("--ink"));
      context.fillStyle = colour(shade);
      context.fillRect(left - 12, y + 2, 9, 9);
    });
  }

  /** A text that stays readable on the curves; returns its left end. */
  plate(context, text, x, y, align, shade) {
    const wide = context.measureText(text).width, left = x - wide * { left: 0, center: 0.5, right: 1 }[align];
    context.fillStyle = colour("--card");
    context.globalAlpha = 0.85;
    context.fillRect(left - (align === "right" ? 14 : 2), y - 1, wide + (align === "right" ? 16 : 4), 15);
    context.globalAlpha = 1;
    context.textAlign = "left";
    context.textBaseline = "top";
    context.fillStyle = shade;
    context.fillText(text, left, y);
    return left;
  }

  /** The line at which values are read, and where that is. */
  drawReading(context, text, inner, height) {
    const pixel = MARGIN.left + inner * (this.reading - this.left) / (this.right - this.left);
    if (pixel < MARGIN.left || pixel > MARGIN.left + inner) return;
    context.fillStyle = colour("--edge");
    context.fillRect(pixel - 0.5, MARGIN.top - 4, 1, height - MARGIN.bottom - MARGIN.top + 4);
    const half = context.measureText(text).width / 2;
    const middle = Math.min(Math.max(pixel, MARGIN.left + half), MARGIN.left + inner - half);
    this.plate(context, text, middle, 6, "center", colour("--ink"));
  }

  drawAxis(context, across, inner, height) {
    const y = height - MARGIN.bottom;
    context.strokeStyle = colour("--edge");
    context.lineWidth = 1;
    through(context, [[MARGIN.left, y + 0.5], [MARGIN.left + inner, y + 0.5]]).stroke();
    context.fillStyle = colour("--soft");
    context.textBaseline = "top";
    context.textAlign = "center";
    for (const { at, text } of across.list) {
      context.fillText(text, MARGIN.left + inner * (at - this.left) / (this.right - this.left), y + 6);
    }
    const label = across.name ? `${this.column.xlabel}: ${across.name}` : this.column.xlabel;
    const half = Math.min(context.measureText(label).width / 2, this.canvas.clientWidth / 2);
    context.fillText(label, Math.min(MARGIN.left + inner / 2, this.canvas.clientWidth - half), y + 25);
  }
}

window.report = (() => {
  const { figures, arrays } = JSON.parse(document.getElementById("data").textContent);
  const numbers = arrays.map(decoded), charts = {};
  for (const figure of figures) {
    const parent = document.querySelector(`#${figure.name} .charts`);
    const row = figure.columns.map((column) => new Chart(parent, column, figure.height, numbers));
    const ranges = (chart) => JSON.stringify(chart.views.map(({ left, right }) => [left, right]));
    for (const chart of row) chart.mates = row.filter((other) => ranges(other) === ranges(chart));
    charts[figure.name] = row;
  }
  DARK.addEventListener("change", () => { for (const chart of Object.values(charts).flat()) chart.draw(); });
  return { charts };
})();
