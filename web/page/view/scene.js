// The cradle, drawn: frame, strings, balls, and the glow of the forces between them.

const LONGEST_STRING = 4.7, SHORTEST_STRING = 3.2; // lengths as drawn, in diameters of a ball
const AFTERGLOW = 0.5; // s on the viewer's clock that a contact shines after its pulse

/** Distinct colours for up to 20 balls: around the circle, the same lightness. */
function ballColour(i, balls, dark) {
  return `oklch(${dark ? 0.78 : 0.52} 0.13 ${(25 + (330 * i) / Math.max(balls, 5)) % 360})`;
}

class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.glow = [];
    this.sprites = new Map();
  }

  /** Fits the picture into the canvas: where everything hangs. `near`: 0 for the whole cradle, 1 for the balls close by;
   *  `swingAngle` (rad): how far balls swing. */
  layout({ radius, ratio, length }, near = 0, swingAngle = 0.56) {
    // Never quite nothing, whatever is around it.
    const width = Math.max(60, this.canvas.clientWidth), height = Math.max(60, this.canvas.clientHeight), density = Math.min(window.devicePixelRatio || 1, 2);
    if (this.canvas.width !== Math.round(width * density) || this.canvas.height !== Math.round(height * density)) {
      this.canvas.width = Math.round(width * density);
      this.canvas.height = Math.round(height * density);
    }
    const sizes = ratio.map((mass) => Math.min(2.2, Math.max(0.35, Math.cbrt(mass)))); // of a radius
    const row = sizes.reduce((sum, size) => sum + 2 * size, 0), largest = Math.max(...sizes); // radii
    const drawn = Math.min(LONGEST_STRING, Math.max(SHORTEST_STRING, length / (2 * radius))); // diameters
    // From afar: room for a swing to both sides, strings, balls and base. Close by: only for the balls and what is above them.
    const swing = 2 * drawn * Math.sin(swingAngle), far = Math.min(width / (row + 2 * swing + 1), (height - 8) / (2 * drawn + 2.7 * largest + 1.2), 64);
    const close = Math.max(far, Math.min(width / (row + 2.4), height / (7 * largest), 110));
    const unit = far ** (1 - near) * close ** near, string = 2 * drawn * unit;
    const hanging = (1 - near) * (8 + 0.5 * far + 2 * drawn * far + 0.45 * Math.max(0, height - far * (2 * drawn + 2.7 * largest + 1.7)))
      + near * (height - 2.1 * largest * close);
    const positions = [];
    let x = 0.5 * (width - row * unit);
    for (const size of sizes) {
      positions.push(x + size * unit);
      x += 2 * size * unit;
    }
    Object.assign(this, { width, height, density, near, unit, string, top: hanging - string, sizes, positions, length });
    return this;
  }

  /** Where ball `i` is on the canvas when its displacement is x (m). */
  place(i, x) {
    const angle = x / this.length;
    return { x: this.positions[i] + this.string * Math.sin(angle), y: this.top + this.string * Math.cos(angle) };
  }

  /** The displacement (m) of ball `i` that is nearest to a point on the canvas. */
  displacement(i, { x, y }) { return this.length * Math.atan2(x - this.positions[i], Math.max(y - this.top, 0.15 * this.string)); }

  /** The ball at a point on the canvas, with a margin for fingers (px); -1 for none. */
  ballAt(point, state, margin = 0) {
    let best = -1, least = Infinity;
    for (let i = 0; i < this.positions.length; i++) {
      const { x, y } = this.place(i, state.x[i]), away = Math.hypot(x - point.x, y - point.y) - this.sizes[i] * this.unit;
      if (away < Math.min(margin, least)) [best, least] = [i, away];
    }
    return best;
  }

  /** Lets contacts shine: by their force now, or by what is left of their last pulses after `passed` s of the viewer's clock. */
  shine(state, pulses, strongest, passed, still) {
    while (this.glow.length < state.F.length) this.glow.push(0);
    this.glow.length = state.F.length;
    const fade = still ? 1 : Math.exp((-3 * passed) / AFTERGLOW);
    for (let i = 0; i < this.glow.length; i++) this.glow[i] = Math.max(this.glow[i] * fade, Math.max(0, state.F[i]) / strongest);
    for (const { contact, peak } of pulses) {
      if (contact < this.glow.length) this.glow[contact] = Math.max(this.glow[contact], Math.min(1, peak / strongest));
    }
  }

  draw(state, { theme, labels, held, selected, arrows }) {
    const { context: c, density, width, height } = this;
    c.setTransform(density, 0, 0, density, 0, 0);
    c.clearRect(0, 0, width, height);
    this.drawFrame(theme);
    this.drawShadows(state, theme);
    const places = Array.from(state.x, (x, i) => this.place(i, x));
    this.drawStrings(places, theme);
    places.forEach((place, i) => this.drawBall(place, i, theme, held.has(i)));
    this.drawGlow(places, theme);
    if (arrows) this.drawArrows(places, state, arrows, theme);
    if (labels) this.drawLabels(places, theme);
    if (selected >= 0 && places[selected]) this.drawRing(places[selected], selected, theme);
  }

  /** The rail, on posts that stand on a base. */
  drawFrame(theme) {
    const { context: c, unit, top, string } = this, thick = Math.max(5, 0.2 * unit), edge = 1.9 * unit;
    const left = this.positions[0] - edge, right = this.positions.at(-1) + edge;
    const floor = top + string + 1.75 * Math.max(...this.sizes) * unit;
    const slab = (y, from, to, height, shades) => {
      const shade = c.createLinearGradient(0, y, 0, y + height);
      shades.forEach((colour, i) => shade.addColorStop(i / (shades.length - 1), colour));
      c.fillStyle = shade;
      c.beginPath();
      c.roundRect(from, y, to - from, height, Math.min(height / 2, 0.12 * unit));
      c.fill();
    };
    slab(floor, left - 0.7 * unit, right + 0.7 * unit, 0.42 * unit, theme.base);
    for (const x of [left, right]) {
      const shade = c.createLinearGradient(x - thick / 2, 0, x + thick / 2, 0);
      theme.rail.forEach((colour, i) => shade.addColorStop(i / (theme.rail.length - 1), colour));
      c.fillStyle = shade;
      c.fillRect(x - thick / 2, top - 0.5 * thick, thick, floor - top + 0.5 * thick);
    }
    slab(top - thick, left - thick / 2, right + thick / 2, thick, theme.rail);
  }

  /** A soft shadow for each ball on what the cradle stands on. */
  drawShadows(state, theme) {
    const { context: c, unit, string, top } = this, floor = top + string + 1.75 * Math.max(...this.sizes) * unit + 0.1 * unit;
    for (let i = 0; i < this.positions.length; i++) {
      const { x, y } = this.place(i, state.x[i]), up = Math.max(0, (top + string - y) / string), size = this.sizes[i] * unit;
      c.save();
      c.translate(x, floor);
      c.scale(1, 0.13);
      const shade = c.createRadialGradient(0, 0, 0, 0, 0, size * (1.15 + up));
      shade.addColorStop(0, theme.shadow);
      shade.addColorStop(1, theme.noShadow);
      c.globalAlpha = Math.max(0.15, 1 - 1.6 * up);
      c.fillStyle = shade;
      c.beginPath();
      c.arc(0, 0, size * (1.15 + up), 0, 2 * Math.PI);
      c.fill();
      c.restore();
    }
  }

  drawStrings(places, theme) {
    const { context: c, unit, top } = this;
    c.lineWidth = Math.max(1, 0.028 * unit);
    places.forEach(({ x, y }, i) => {
      const size = this.sizes[i] * unit, angle = Math.atan2(x - this.positions[i], y - top);
      const eye = { x: x - size * Math.sin(angle), y: y - size * Math.cos(angle) };
      c.strokeStyle = theme.string;
      c.beginPath();
      c.moveTo(this.positions[i] - 0.16 * unit, top - 0.04 * unit);
      c.lineTo(eye.x, eye.y);
      c.lineTo(this.positions[i] + 0.16 * unit, top - 0.04 * unit);
      c.stroke();
    });
  }

  drawBall(place, i, theme, held) {
    const { context: c, unit, density } = this, radius = this.sizes[i] * unit;
    const key = `${theme.name} ${radius.toFixed(2)} ${density}`;
    let sprite = this.sprites.get(key);
    if (!sprite) {
      if (this.sprites.size > 60) this.sprites.clear();
      this.sprites.set(key, (sprite = ballSprite(radius, density, theme)));
    }
    c.drawImage(sprite, place.x - radius - 2, place.y - radius - 2, 2 * radius + 4, 2 * radius + 4);
    if (held) {
      c.strokeStyle = theme.accent;
      c.lineWidth = 2;
      c.beginPath();
      c.arc(place.x, place.y, radius + 2.5, 0, 2 * Math.PI);
      c.stroke();
    }
  }

  drawGlow(places, theme) {
    const { context: c, unit } = this;
    c.save();
    c.globalCompositeOperation = theme.glowMode;
    this.glow.forEach((glow, i) => {
      if (glow < 0.004 || !places[i + 1]) return;
      const a = places[i], b = places[i + 1], from = this.sizes[i], to = this.sizes[i + 1], part = from / (from + to);
      const x = a.x + part * (b.x - a.x), y = a.y + part * (b.y - a.y);
      // What has parted does not shine any more.
      const away = Math.hypot(b.x - a.x, b.y - a.y) / ((from + to) * unit) - 1, strength = Math.sqrt(glow) * Math.max(0, 1 - 4 * away);
      if (strength <= 0.05) return;
      const radius = unit * (0.35 + 1.15 * strength), shade = c.createRadialGradient(x, y, 0, x, y, radius);
      shade.addColorStop(0, theme.glow(Math.min(1, 0.25 + strength)));
      shade.addColorStop(0.25, theme.glow(0.55 * strength));
      shade.addColorStop(1, theme.glow(0));
      c.fillStyle = shade;
      c.beginPath();
      c.arc(x, y, radius, 0, 2 * Math.PI);
      c.fill();
    });
    c.restore();
  }

  /** Velocities as arrows below the balls; the longest is `arrows` m/s. */
  drawArrows(places, state, fastest, theme) {
    const { context: c, unit } = this, longest = 1.75 * unit;
    places.forEach(({ x, y }, i) => {
      const length = (longest * state.v[i]) / fastest, under = y + this.sizes[i] * unit + 0.32 * unit;
      if (Math.abs(length) < 1.5) return;
      const head = Math.sign(length) * Math.min(Math.abs(length), 0.24 * unit);
      c.strokeStyle = c.fillStyle = ballColour(i, places.length, theme.dark);
      c.lineWidth = Math.max(2, 0.085 * unit);
      c.beginPath();
      c.moveTo(x, under);
      c.lineTo(x + length - 0.7 * head, under);
      c.stroke();
      c.beginPath();
      c.moveTo(x + length, under);
      c.lineTo(x + length - head, under - 0.13 * unit);
      c.lineTo(x + length - head, under + 0.13 * unit);
      c.fill();
    });
  }

  drawLabels(places, theme) {
    const { context: c, unit } = this, size = Math.max(10, 0.42 * unit);
    c.font = `600 ${size}px ${FONT}`;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillStyle = theme.label;
    places.forEach(({ x, y }, i) => c.fillText(String(i + 1), x, y + 0.02 * unit));
  }

  drawRing({ x, y }, i, theme) {
    const { context: c, unit } = this;
    c.strokeStyle = theme.focus;
    c.lineWidth = 3;
    c.beginPath();
    c.arc(x, y, this.sizes[i] * unit + 5, 0, 2 * Math.PI);
    c.stroke();
  }
}

/** A polished ball, drawn once for each size. */
function ballSprite(radius, density, theme) {
  const canvas = document.createElement("canvas"), size = Math.ceil((2 * radius + 4) * density);
  canvas.width = canvas.height = size;
  const c = canvas.getContext("2d"), shades = theme.ball;
  c.scale(density, density);
  c.translate(radius + 2, radius + 2);
  c.beginPath();
  c.arc(0, 0, radius, 0, 2 * Math.PI);
  c.clip();
  // What a polished ball mirrors: the sky above, a horizon, the table below.
  const sky = c.createLinearGradient(0, -radius, 0, radius);
  shades.forEach(([stop, colour]) => sky.addColorStop(stop, colour));
  c.fillStyle = sky;
  c.fillRect(-radius, -radius, 2 * radius, 2 * radius);
  const rim = c.createRadialGradient(-0.18 * radius, -0.25 * radius, 0.35 * radius, 0, 0, radius);
  rim.addColorStop(0, "rgba(0, 0, 0, 0)");
  rim.addColorStop(0.72, "rgba(0, 0, 0, 0.06)");
  rim.addColorStop(1, theme.rim);
  c.fillStyle = rim;
  c.fillRect(-radius, -radius, 2 * radius, 2 * radius);
  const light = c.createRadialGradient(-0.36 * radius, -0.46 * radius, 0, -0.36 * radius, -0.46 * radius, 0.55 * radius);
  light.addColorStop(0, "rgba(255, 255, 255, 0.95)");
  light.addColorStop(0.25, "rgba(255, 255, 255, 0.45)");
  light.addColorStop(1, "rgba(255, 255, 255, 0)");
  c.fillStyle = light;
  c.fillRect(-radius, -radius, 2 * radius, 2 * radius);
  return canvas;
}
