// What the page and the paper's report share: numbers as they are written, samples of a run, elements, and drawing.

const PREFIXES = { 9: "G", 6: "M", 3: "k", 0: "", "-3": "m", "-6": "µ", "-9": "n", "-12": "p", "-15": "f" };

/** The power of ten, a multiple of three, for a number of this size. */
function powerFor(size) {
  return size > 0 ? Math.min(9, Math.max(-15, 3 * Math.floor(Math.log10(size * 1.0001) / 3))) : 0;
}

/** A number with the SI prefix for this `size`, beside which what is below its digits is 0: 1.5e-7, "s" gives "150 ns";
 *  0.5, "kg m/s" gives "500 g m/s". */
export function withPrefix(value, unit, digits = 3, size = Math.abs(value)) {
  if (!Number.isFinite(value)) return `– ${unit}`;
  if (unit.startsWith("kg")) return withPrefix(1000 * value, unit.slice(1), digits, 1000 * size);
  const power = powerFor(size), seen = Math.abs(value) < 0.5 * size / 10 ** digits ? 0 : value;
  const number = Number((seen / 10 ** power).toPrecision(digits));
  return `${String(number).replace("-", "−")} ${PREFIXES[power]}${unit}`;
}

/** The smallest of 1, 2 or 5 (`factors`), times a power of ten, that is not below `least`, except by rounding. */
export function roundStep(least, factors = [1, 2, 5, 10]) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * factors.find((factor) => factor * power >= 0.999 * least);
}

/** Number of elements of the rising `array` (or of their values `of`) that are not above `value`. */
export function countUpTo(array, value, of = (number) => number) {
  let low = 0, high = array.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (of(array[middle]) <= value) low = middle + 1; else high = middle;
  }
  return low;
}

/** The largest absolute value in some columns; 0 where there is none. */
export function largest(columns) {
  return columns.reduce((most, column) => column.reduce((a, b) => Math.max(a, Math.abs(b)), most), 0);
}

/** The smallest value in some columns, if it is below this one. */
export function smallest(columns, least = 0) {
  return columns.reduce((low, column) => column.reduce((a, b) => Math.min(a, b), low), least);
}

/** The place of `t` among rising times: the sample before it, and the part of the way to the next one. */
export function placeIn(times, t) {
  const i = Math.min(Math.max(countUpTo(times, t) - 1, 0), times.length - 2), h = times[i + 1] - times[i];
  return { i, h, part: Math.min(Math.max((t - times[i]) / h, 0), 1) };
}

/** A sampled quantity at a place between its samples. */
export function linear(column, { i, part }) { return column[i] + part * (column[i + 1] - column[i]); }

/** A position: the cubic through both samples' positions and velocities (Hermite). */
export function cubic(x, v, { i, h, part }) {
  const rest = 1 - part;
  return x[i] * (1 + 2 * part) * rest * rest + x[i + 1] * (3 - 2 * part) * part * part
    + h * part * rest * (v[i] * rest - v[i + 1] * part);
}

/** A new element with these properties, at the end of another one. */
export function element(parent, name, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(name), properties));
}

/** Sets ARIA attributes of an element; Firefox has properties such as `ariaLabel` only since version 119. */
export function aria(item, words) {
  for (const [kind, word] of Object.entries(words)) {
    if (item.getAttribute(`aria-${kind}`) !== String(word)) item.setAttribute(`aria-${kind}`, word);
  }
  return item;
}

/** Decompresses base64 data of this format. */
function inflated(text, format) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format)));
}

/** The unpacked content of an element of the page. */
export function unpacked(id) { return inflated(document.getElementById(id).textContent, "gzip"); }

/** Undoes `packed` of page.py, base64, deflate, planes of bytes: columns by their names. */
export async function columnsOf({ names, kind, data }) {
  const planes = new Uint8Array(await inflated(data, "deflate").arrayBuffer()), mixed = new Uint8Array(planes.length);
  const [Kind, size] = kind === "f8" ? [Float64Array, 8] : [Float32Array, 4], count = planes.length / size;
  planes.forEach((byte, k) => { mixed[(k % count) * size + Math.floor(k / count)] = byte; });
  const numbers = new Kind(mixed.buffer), long = numbers.length / names.length;
  return new Map(names.map((name, i) => [name, numbers.subarray(i * long, (i + 1) * long)]));
}

/** Writes a text, if it differs. */
export function write(item, text) { if (item && item.textContent !== text) item.textContent = text; }

/** The canvas, made this wide and high (pixels). */
export function sized(canvas, ...sizes) {
  const [width, height] = sizes.map(Math.round);
  return canvas.width === width && canvas.height === height ? canvas : Object.assign(canvas, { width, height });
}

/** A canvas's 2D context, cleared, scaled so that one unit is one CSS pixel: {context, width, height, ratio}. */
export function prepared(canvas, most = Infinity) {
  const ratio = Math.min(devicePixelRatio || 1, most), { clientWidth: width, clientHeight: height } = canvas;
  const context = sized(canvas, width * ratio, height * ratio).getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  return { context, width, height, ratio };
}

/** A context whose path leads through these points [x, y]. */
export function through(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  return context;
}

/** The points [px of a time, py of a sample] of a curve between two times, of the samples that are `shown`; where many
 *  share a pixel column, the first, the lowest, the highest and the last; one, if these differ by less than a pixel. */
export function thinned(times, left, right, px, py, shown = () => true) {
  const last = Math.min(countUpTo(times, right), times.length - 1), points = [];
  for (let i = Math.max(0, countUpTo(times, left) - 1), next, x = px(times[i]); i <= last; i = next) {
    const column = Math.floor(x), begun = points.length, first = py(i);
    let lowest = first, highest = first, y = first;
    if (shown(i)) points.push([x, first]);
    for (next = i + 1; next <= last && (x = px(times[next])) < column + 1; next++) {
      y = py(next);
      if (y < lowest) lowest = y; else if (y > highest) highest = y;
      if (shown(next)) points.push([x, y]);
    }
    const few = highest - lowest < 1 ? [y] : [first, lowest, highest, y];
    if (next - i > few.length) points.splice(begun, Infinity, ...few.map((level) => [column + 0.5, level]));
  }
  return points;
}

/** Draws a line through these points and, with this opacity, the area between it and the height `foot`. */
export function line(context, points, colour, width = 1, opacity = 0, foot = 0) {
  Object.assign(context, { strokeStyle: colour, fillStyle: colour, lineWidth: width, lineJoin: "round" });
  through(context, points).stroke();
  if (!opacity || !points.length) return;
  context.lineTo(points.at(-1)[0], foot);
  context.lineTo(points[0][0], foot);
  context.globalAlpha = opacity;
  context.fill();
  context.globalAlpha = 1;
}

/** Fills a circle, or an ellipse so `tall`, around a place, or draws it as a line of this width. */
export function circle(c, { x, y }, radius, colour, width = 0, tall = radius) {
  c.beginPath();
  c.ellipse(x, y, radius, tall, 0, 0, 2 * Math.PI);
  Object.assign(c, width ? { strokeStyle: colour, lineWidth: width } : { fillStyle: colour });
  if (width) c.stroke(); else c.fill();
}

export const RIM = 3; // px around what stands out from what is behind it

/** Writes a text with a rim of another colour, through which nothing is seen. */
export function rimmed(c, text, x, y, colour, rim) {
  Object.assign(c, { fillStyle: colour, strokeStyle: rim, lineWidth: RIM, lineJoin: "round" });
  c.strokeText(text, x, y);
  c.fillText(text, x, y);
}

/** The gradient with these stops: [place, colour], or colours at even distances. */
export function shaded(gradient, stops) {
  stops.forEach((stop, i) => gradient.addColorStop(...(Array.isArray(stop) ? stop : [i / (stops.length - 1), stop])));
  return gradient;
}
