// Axes: ticks, and how values on an axis are written.

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
