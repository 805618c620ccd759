// Microscopes above the contacts: the gap between two balls, or how far they are pressed together, in micrometres.

import { circle, rimmed, shaded, through, withPrefix } from "#view/common.js";
import { contactColour, SMALL } from "#view/scene.js";
import { FONT, say } from "#view/texts.js";

const LEAST = 12, LARGEST = 84; // px, the radius of a lens
const BLIND = 3.6;  // half widths of a lens: surfaces that far apart are out of its sight
const FAR = 0.25;   // of the distance between touching balls: so far apart they have no lens
const FITS = [0.85, 0.92]; // parts of the distance between contacts that numbers, and words, may take

/** Draws a lens for each contact, with its numbers; `reach` (m) is half of what it shows. */
export function drawLenses(scene, state, { reach, theme, opacity }) {
  const { context: c, unit } = scene, touches = scene.contacts(scene.places(state));
  const apart = touches.slice(1).map(({ x, y }, i) => Math.hypot(x - touches[i].x, y - touches[i].y));
  const room = Math.min(...apart), radius = Math.min(0.9 * unit, LARGEST, 0.48 * room);
  if (radius < LEAST || opacity <= 0) return;
  c.save();
  const letters = parseFloat(getComputedStyle(scene.canvas).fontSize);
  const size = Math.max(SMALL, 0.66 * letters, Math.min(18, 0.41 * unit)), font = `600 ${size}px ${FONT}`;
  Object.assign(c, { globalAlpha: opacity, font, textAlign: "center", textBaseline: "alphabetic" });
  const gaps = Array.from(state.overlap, (depth) => -depth); // m until the law acts; negative while it does
  const captions = captionsOf(c, gaps, reach, room);
  touches.forEach(({ x, y, away }, i) => {
    if (away > FAR) return;
    const gap = gaps[i] / reach, seen = gap < BLIND, centre = { x, y: y - scene.largest * unit - radius - 0.55 * unit };
    if (seen) {
      Object.assign(c, { strokeStyle: theme.lensLine, lineWidth: 1 });
      through(c, [[x, y], [x, centre.y + radius]]).stroke();
      const colour = contactColour(i, touches.length + 1, theme.dark);
      drawLens(c, centre, radius, { gap, glows: state.F[i] > 0, colour }, theme);
    }
    const foot = centre.y + (seen ? -radius - 6 : 0.4 * size), colour = gap < 0 ? theme.accent : theme.ink;
    captions[i].forEach(({ text, aside }, line) =>
      rimmed(c, text, x + aside, foot - 1.2 * line * size, colour, theme.back));
  });
  c.restore();
}

/** What is written above each lens, from the lowest line up, {text, how far `aside` (px)}: the gap, or the overlap, and
 *  which of both, as far as there is `room` (px); where that is too little for units, the last number has that of all. */
function captionsOf(c, gaps, reach, room) {
  const wide = (text) => c.measureText(text).width, last = gaps.length - 1;
  const all = gaps.map((gap) =>
    [withPrefix(Math.abs(gap), "m", 2, reach), say(gap < 0 ? "lensPressed" : "lensGap")]);
  const [units, words] = [0, 1].map((k) => all.every((texts) => wide(texts[k]) < FITS[k] * room));
  return all.map(([length, word], i) => {
    const [number] = length.split(" "), aside = units || i < last ? 0 : 0.5 * (wide(length) - wide(number));
    return [{ text: units || i === last ? length : number, aside }, ...(words ? [{ text: word, aside: 0 }] : [])];
  });
}

/** One lens with a rim of this colour: `gap` in its half widths, drawn so that one half width is half of its radius.
 *  What is farther apart is out of its sight. */
function drawLens(c, centre, radius, { gap, glows, colour }, theme) {
  const { x, y } = centre, shift = 0.5 * gap * radius, bend = 2.6 * radius;
  c.save();
  circle(c, centre, radius, theme.lens);
  c.clip();
  // Two surfaces that bulge towards each other; where they overlap, they flatten.
  for (const side of [-1, 1]) {
    const face = x + side * Math.max(0, 0.5 * shift);
    circle(c, { x: face + side * bend, y }, bend,
      shaded(c.createLinearGradient(face, y, face + side * radius, y), theme.lensBall));
  }
  if (shift < 0) {
    // The patch that is pressed: as high as the chord in which the undeformed surfaces would overlap.
    const depth = -0.5 * shift, half = Math.min(0.8 * radius, Math.sqrt(2 * bend * depth)), width = 2 + 0.5 * depth;
    const glow = shaded(c.createRadialGradient(x, y, 0, x, y, half + 8), [theme.glow(0.95), theme.glow(0)]);
    if (glows) circle(c, centre, width + 0.4 * half, glow, 0, half + 8);
    circle(c, centre, 0.5 * width, theme.patch, 0, half);
  }
  c.restore();
  circle(c, centre, radius, colour, 2.5);
}
