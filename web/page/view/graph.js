// What runs along: velocities, forces, energy and momentum by time, over some seconds or over one click.

const HISTORY = 900;  // samples that are kept
const SECONDS = 7;    // s on the viewer's clock that are shown
const ENERGY_PARTS = ["kinetic", "gravity", "elastic"];

class Graph {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  /** Forgets what was recorded. */
  clear(balls) {
    this.width = 3 + 2 * balls + 3;
    this.rows = new Float64Array(HISTORY * this.width);
    Object.assign(this, { balls, count: 0, next: 0, fastest: 1e-9, strongest: 1e-9, largest: 1e-12, momentum: 1e-12 });
  }

  /** Notes what a source shows at the time of the page's clock. */
  record(time, state, pulses) {
    if (state.balls !== this.balls) this.clear(state.balls);
    const { rows, width, balls } = this, sum = (values) => values.reduce((a, b) => a + b, 0);
    const row = rows.subarray(this.next * width, (this.next + 1) * width);
    row[0] = time;
    row[1] = state.momentum;
    row[2] = pulses.reduce((most, { peak }) => Math.max(most, peak), 0);
    row.set(state.v, 3);
    row.set(state.F, 3 + balls);
    row.set(ENERGY_PARTS.map((part) => sum(state[part])), 3 + 2 * balls);
    this.next = (this.next + 1) % HISTORY;
    this.count = Math.min(this.count + 1, HISTORY);
    for (const v of state.v) this.fastest = Math.max(this.fastest, Math.abs(v));
    for (const F of state.F) this.strongest = Math.max(this.strongest, F);
    this.strongest = Math.max(this.strongest, row[2]);
    this.largest = Math.max(this.largest, state.energy);
    this.momentum = Math.max(this.momentum, Math.abs(state.momentum));
  }

  /** Where things are by time: the last `HISTORY` samples, oldest first. */
  *samples() {
    const first = this.count < HISTORY ? 0 : this.next;
    for (let k = 0; k < this.count; k++) {
      const at = ((first + k) % HISTORY) * this.width;
      yield this.rows.subarray(at, at + this.width);
    }
  }

  /** Where the scales of the rows end: at the most of a click, or of what was recorded. */
  scales(click) { return { velocity: (click ?? this).fastest, force: (click ?? this).strongest, momentum: this.momentum }; }

  /** Draws these kinds of rows, from time `left` to `right`; inside a click with all that is known of it. */
  draw(kinds, { left, right, now, click, offset, theme }) {
    const { canvas, context: c } = this, density = Math.min(window.devicePixelRatio || 1, 2);
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    canvas.width = Math.round(width * density);
    canvas.height = Math.round(height * density);
    c.setTransform(density, 0, 0, density, 0, 0);
    c.clearRect(0, 0, width, height);
    const tall = height / kinds.length;
    const place = (time) => ((time - left) / (right - left)) * width;
    kinds.forEach((kind, i) => {
      c.save();
      c.translate(0, i * tall);
      c.beginPath();
      c.rect(0, 0, width, tall);
      c.clip();
      if (i) this.line([[0, 0.5], [width, 0.5]], theme.grid);
      this.drawRow(kind, { place, tall, width, click, offset, theme });
      c.restore();
    });
    this.line([[place(now), 0], [place(now), height]], theme.accent, 1.5);
  }

  drawRow(kind, { place, tall, width, click, offset, theme }) {
    const top = kind === "force" && click ? 34 : 22, foot = tall - 6, middle = 0.5 * (top + foot), half = 0.5 * (foot - top), { balls } = this;
    if (kind === "energy") return this.drawEnergy(place, top, foot, theme);
    const several = kind === "velocity" ? balls : kind === "force" ? balls - 1 : 1;
    const at = kind === "velocity" ? 3 : kind === "force" ? 3 + balls : 1;
    const largest = this.scales(click)[kind];
    const level = (value) => (kind === "force" ? foot - (value / largest) * (foot - top) : middle - (value / largest) * half);
    this.line([[0, level(0)], [width, level(0)]], theme.grid);
    const known = kind === "momentum" ? null : click?.samples;
    for (let i = 0; i < several; i++) {
      const points = [];
      if (known) known.time.forEach((time, k) => points.push([place(time + offset), level(known[kind === "force" ? "F" : "v"][k][i])]));
      else for (const row of this.samples()) points.push([place(row[0]), level(row[at + i])]);
      const colour = kind === "momentum" ? theme.ink : ballColour(i, balls, theme.dark);
      this.line(points, colour, 1.6, known && kind === "force" ? foot : null);
    }
    if (kind === "force" && known) this.drawPairs(click, { place, offset, level, theme });
    // Pulses that lasted less than from one picture to the next.
    if (kind === "force" && !known) {
      for (const row of this.samples()) if (row[2] > 0) this.line([[place(row[0]), foot], [place(row[0]), level(row[2])]], theme.spike, 2);
    }
  }

  /** Which balls each pulse is between, at its peak. */
  drawPairs({ pulses, samples }, { place, offset, level, theme }) {
    if (pulses.length > 16) return;
    const { context: c } = this;
    c.font = `600 11px ${FONT}`;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    const labels = [];
    for (const { contact, onset, release, peak } of pulses) {
      let top = 0;
      samples.time.forEach((time, k) => {
        if (time >= onset && time <= release && samples.F[k][contact] > (samples.F[top][contact] || 0)) top = k;
      });
      labels.push({ x: place(samples.time[top] + offset), y: level(peak) - 2, text: `${contact + 1}–${contact + 2}`, contact });
    }
    labels.sort((a, b) => a.x - b.x);
    for (let i = 0; i < labels.length; i++) {
      const { x, y, text, contact } = labels[i], next = labels[i + 1];
      // Pulses at the same time have one label.
      if (next && next.x - x < 30) {
        Object.assign(next, { x: 0.5 * (x + next.x), y: Math.min(y, next.y), text: `${text}, ${next.text}` });
        continue;
      }
      c.fillStyle = text.includes(",") ? theme.ink : ballColour(contact, this.balls, theme.dark);
      c.fillText(text, Math.max(16, Math.min(this.canvas.clientWidth - 20, x)), y);
    }
  }

  /** Energies on top of one another. */
  drawEnergy(place, top, foot, theme) {
    const { context: c, balls } = this, at = 3 + 2 * balls;
    const rows = [...this.samples()], level = (value) => foot - (value / this.largest) * (foot - top);
    const sums = rows.map(() => 0);
    ENERGY_PARTS.forEach((_, part) => {
      c.fillStyle = theme.energies[part];
      c.beginPath();
      rows.forEach((row, k) => c.lineTo(place(row[0]), level(sums[k])));
      rows.forEach((row, k) => { sums[k] += Math.max(0, row[at + part]); });
      for (let k = rows.length - 1; k >= 0; k--) c.lineTo(place(rows[k][0]), level(sums[k]));
      c.fill();
    });
  }

  line(points, colour, width = 1, foot = null) {
    const { context: c } = this;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.lineJoin = "round";
    c.beginPath();
    for (const [x, y] of points) c.lineTo(x, y);
    c.stroke();
    if (foot === null || !points.length) return;
    c.lineTo(points.at(-1)[0], foot);
    c.lineTo(points[0][0], foot);
    c.globalAlpha = 0.16;
    c.fillStyle = colour;
    c.fill();
    c.globalAlpha = 1;
  }
}
