// Microscopes above the contacts: the gap between two balls, or how far they are pressed together, in micrometres.

/** Draws a lens for each contact; `reach` (m) is half of what it shows. */
function drawLenses(scene, state, { reach, theme, opacity }) {
  const { context: c, unit } = scene, radius = Math.min(0.9 * unit, 84);
  if (radius < 15 || opacity <= 0) return;
  c.save();
  c.globalAlpha = opacity;
  for (let i = 0; i < state.F.length; i++) {
    const touch = scene.contact(i, scene.place(i, state.x[i]), scene.place(i + 1, state.x[i + 1]));
    const gap = -state.overlap[i]; // m until the law acts; negative while it does
    if (touch.away > 0.25) continue;
    const centre = { x: touch.x, y: touch.y - Math.max(...scene.sizes) * unit - radius - 0.55 * unit };
    c.strokeStyle = theme.lensLine;
    c.lineWidth = 1;
    through(c, [[touch.x, touch.y], [centre.x, centre.y + radius]]).stroke();
    drawLens(c, centre, radius, gap / reach, Math.max(0, state.F[i]), theme);
    c.fillStyle = gap < 0 ? theme.accent : theme.ink; // pressed, or apart
    const size = Math.max(10, Math.min(15, 0.3 * unit));
    c.font = `600 ${size}px ${FONT}`;
    c.textAlign = "center";
    c.textBaseline = "alphabetic";
    if (radius < 22) continue;
    c.fillText(say(gap < 0 ? "lensPressed" : "lensGap"), centre.x, centre.y - radius - 6 - 1.2 * size);
    c.fillText(withPrefix(Math.abs(gap), "m", 2), centre.x, centre.y - radius - 6);
  }
  c.restore();
}

/** One lens: `gap` in its half widths, drawn so that one half width is half of its radius. What is farther apart is out of its sight. */
function drawLens(c, { x, y }, radius, gap, force, theme) {
  c.save();
  disc(c, x, y, radius, theme.lens);
  c.clip();
  const shift = 0.5 * gap * radius, bend = 2.6 * radius;
  // Two surfaces that bulge towards each other; where they overlap, they flatten.
  for (const side of [-1, 1]) {
    const face = x + side * Math.max(0, 0.5 * shift), centre = face + side * bend;
    disc(c, centre, y, bend, shaded(c.createLinearGradient(face, y, face + side * radius, y), theme.lensBall));
  }
  if (shift < 0) {
    // The patch that is pressed: as high as the chord in which the undeformed surfaces would overlap.
    const depth = -0.5 * shift, half = Math.min(0.8 * radius, Math.sqrt(2 * bend * depth)), width = 2 + 0.5 * depth;
    if (force > 0) {
      c.fillStyle = shaded(c.createRadialGradient(x, y, 0, x, y, half + 8), [theme.glow(0.95), theme.glow(0)]);
      c.beginPath();
      c.ellipse(x, y, width + 0.4 * half, half + 8, 0, 0, 2 * Math.PI);
      c.fill();
    }
    c.fillStyle = theme.patch;
    c.beginPath();
    c.roundRect(x - width / 2, y - half, width, 2 * half, width / 2);
    c.fill();
  }
  c.restore();
  ring(c, { x, y }, radius, theme.lensLine, 1.5);
}
