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
