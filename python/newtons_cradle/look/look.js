// What all pages share: the colours of look.css, and how numbers are written.

const DARK = matchMedia("(prefers-color-scheme: dark)"), STILL = matchMedia("(prefers-reduced-motion: reduce)");
const PREFIXES = { 9: "G", 6: "M", 3: "k", 0: "", "-3": "m", "-6": "µ", "-9": "n", "-12": "p", "-15": "f" };

const COLOURS = new Map(); // as looked up, until the page turns dark or light
DARK.addEventListener("change", () => COLOURS.clear());

/** The value of a colour of look.css, such as "--ink"; a colour by its number is lightened where the page is dark. */
function colour(name) {
  if (!name.startsWith("--")) return DARK.matches ? mixed(name, "#ffffff", 0.4) : name;
  if (!COLOURS.has(name)) COLOURS.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return COLOURS.get(name);
}

/** The colour `part` of the way from #rrggbb to another. */
function mixed(from, to, part) {
  const channel = (text, i) => parseInt(text.slice(1 + 2 * i, 3 + 2 * i), 16);
  return `#${[0, 1, 2].map((i) => Math.round(channel(from, i) + part * (channel(to, i) - channel(from, i))).toString(16).padStart(2, "0")).join("")}`;
}

/** Colour of ball or contact i (from 0) of `count`: its own where there are enough, else one from blue over green to red. */
function seriesColour(i, count) {
  if (count <= 6) return colour(`--series-${i + 1}`);
  const stops = [1, 3, 5, 2].map((number) => colour(`--series-${number}`));
  const place = (stops.length - 1) * i / (count - 1), below = Math.min(Math.floor(place), stops.length - 2);
  return mixed(stops[below], stops[below + 1], place - below);
}

/** The power of ten, a multiple of three, that a number of this size is written with. */
function powerFor(size) {
  return size > 0 ? Math.min(9, Math.max(-15, 3 * Math.floor(Math.log10(size * 1.0001) / 3))) : 0;
}

/** A number with an SI prefix: 1.5e-7, "s" gives "150 ns". */
function withPrefix(value, unit, digits = 3) {
  if (value === 0) return `0 ${unit}`;
  const power = powerFor(Math.abs(value)), number = Number((value / 10 ** power).toPrecision(digits));
  return `${String(number).replace("-", "−")} ${PREFIXES[power]}${unit}`;
}

/** A canvas's 2D context, cleared, scaled so that one unit is one CSS pixel: {context, width, height}. */
function prepared(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  return { context, width, height };
}
