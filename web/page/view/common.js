// What the page and the paper's report share: numbers as they are written, samples of a run, and drawing.

const PREFIXES = { 9: "G", 6: "M", 3: "k", 0: "", "-3": "m", "-6": "µ", "-9": "n", "-12": "p", "-15": "f" };

/** The power of ten, a multiple of three, for a number of this size. */
function powerFor(size) {
  return size > 0 ? Math.min(9, Math.max(-15, 3 * Math.floor(Math.log10(size * 1.0001) / 3))) : 0;
}

/** A number with the SI prefix for this `size`: 1.5e-7, "s" gives "150 ns"; 0.5, "kg m/s" gives "500 g m/s". */
export function withPrefix(value, unit, digits = 3, size = Math.abs(value)) {
  if (value === 0 || !Number.isFinite(value)) return `${value === 0 ? 0 : "–"} ${unit}`;
  if (unit.startsWith("kg")) return withPrefix(1000 * value, unit.slice(1), digits, 1000 * size);
  const power = powerFor(size), number = Number((value / 10 ** power).toPrecision(digits));
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

/** The gradient with these stops: [place, colour], or colours at even distances. */
export function shaded(gradient, stops) {
  stops.forEach((stop, i) => gradient.addColorStop(...(Array.isArray(stop) ? stop : [i / (stops.length - 1), stop])));
  return gradient;
}
