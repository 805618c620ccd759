// The colours of look.css.

const DARK = matchMedia("(prefers-color-scheme: dark)"), STILL = matchMedia("(prefers-reduced-motion: reduce)");

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
  const mixed = (i) => Math.round(channel(from, i) + part * (channel(to, i) - channel(from, i)));
  return `#${[0, 1, 2].map((i) => mixed(i).toString(16).padStart(2, "0")).join("")}`;
}

/** Colour of ball or contact i (from 0) of `count`: its own where there are enough, else one from blue over green to
 *  red. */
function seriesColour(i, count) {
  if (count <= 6) return colour(`--series-${i + 1}`);
  const stops = [1, 3, 5, 2].map((number) => colour(`--series-${number}`));
  const place = (stops.length - 1) * i / (count - 1), below = Math.min(Math.floor(place), stops.length - 2);
  return mixed(stops[below], stops[below + 1], place - below);
}
