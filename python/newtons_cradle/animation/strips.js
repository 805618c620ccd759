// Energy and contact forces around the time shown, and the whole run as one line with its impacts.

const ENERGY_COLOURS = { kinetic: "#5cc8ff", gravity: "#7a86f0", contact: "#ffb454", total: "#5cc8ff" };
const GROUND = "#10151c", RULE = "#2a3542", TEXT = "#93a1b1", HEAD = "#ffb454";

/** Colour of contact i of `count`, from blue over green to red. */
function contactColour(i, count) {
  return `hsl(${215 - 205 * (count > 1 ? i / (count - 1) : 0)} 80% 62%)`;
}

/** A number with an SI prefix: 1.5e-7, "s" gives "150 ns". */
function withPrefix(value, unit, digits = 3) {
  const prefixes = { 9: "G", 6: "M", 3: "k", 0: "", "-3": "m", "-6": "µ", "-9": "n", "-12": "p" };
  if (value === 0) return `0 ${unit}`;
  const power = Math.min(9, Math.max(-12, 3 * Math.floor(Math.log10(Math.abs(value)) / 3 + 1e-9)));
  return `${Number((value / 10 ** power).toPrecision(digits))} ${prefixes[power]}${unit}`;
}

/** A canvas's 2D context, scaled so that one unit is one CSS pixel. */
function prepared(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = GROUND;
  context.fillRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  return { context, width, height };
}

class Strips {
  constructor(canvas, whole, run) {
    Object.assign(this, { canvas, whole, run });
    const parts = Object.values(run.energy);
    this.energyTop = 0;
    for (let i = 0; i < run.time.length; i++) this.energyTop = Math.max(this.energyTop, parts.reduce((sum, part) => sum + part[i], 0));
    this.energyTop = 1.05 * this.energyTop || 1;
    this.wholePicture = null;
  }

  /** Draws `span` seconds around t, and the whole run below. */
  draw(t, span) {
    const { context, width, height } = prepared(this.canvas), split = Math.round(0.42 * height), bottom = height - 17;
    const left = t - span / 2, scale = width / span, time = (pixel) => left + pixel / scale;
    this.drawTicks(context, left, span, scale, bottom);
    this.drawEnergy(context, time, width, 4, split - 4);
    this.drawForces(context, time, scale, left, width, split + 4, bottom);
    context.strokeStyle = HEAD;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(width / 2, 0);
    context.lineTo(width / 2, bottom);
    context.stroke();
    context.fillStyle = "#ffffff";
    context.textAlign = "left";
    context.fillText(`energy, up to ${withPrefix(this.energyTop, "J")}`, 6, 14);
    const [name, unit] = this.run.strength;
    context.fillText(`${name}, up to ${withPrefix(this.run.largest, unit)}`, 6, split + 16);
    this.drawWhole(t);
  }

  /** Grid lines, named by their distance from the time shown. */
  drawTicks(context, left, span, scale, bottom) {
    const raw = span / 8, power = 10 ** Math.floor(Math.log10(raw)), step = power * [1, 2, 5, 10].find((f) => f * power >= raw);
    const middle = left + span / 2;
    context.fillStyle = TEXT;
    context.strokeStyle = RULE;
    context.lineWidth = 1;
    context.textAlign = "center";
    context.beginPath();
    for (let k = -4; k <= 4; k++) {
      const pixel = (middle + k * step - left) * scale;
      context.moveTo(pixel, 0);
      context.lineTo(pixel, bottom);
      if (k && pixel > 28 && pixel < this.canvas.clientWidth - 28) context.fillText(`${k > 0 ? "+" : "−"}${withPrefix(Math.abs(k * step), "s")}`, pixel, bottom + 13);
    }
    context.stroke();
  }

  /** What is stored where, on top of each other. */
  drawEnergy(context, time, width, top, bottom) {
    const { run } = this, columns = Math.ceil(width / 2) + 1, below = new Float64Array(columns);
    const places = Array.from({ length: columns }, (_, i) => time(2 * i)).map((t) => (t < run.start || t > run.stop ? null : run.place(t)));
    const first = places.findIndex((place) => place), last = places.findLastIndex((place) => place);
    if (first < 0) return;
    const y = (value) => bottom - (bottom - top) * value / this.energyTop;
    for (const [name, values] of Object.entries(run.energy)) {
      context.beginPath();
      for (let i = last; i >= first; i--) context.lineTo(2 * i, y(below[i]));
      for (let i = first; i <= last; i++) {
        below[i] += run.linear(values, places[i]);
        context.lineTo(2 * i, y(below[i]));
      }
      context.fillStyle = ENERGY_COLOURS[name];
      context.globalAlpha = 0.75;
      context.fill();
      context.globalAlpha = 1;
    }
  }

  /** Curves of the forces; where a pulse is narrower than some pixels, a line as high as its peak. */
  drawForces(context, time, scale, left, width, top, bottom) {
    const { run } = this, y = (value) => bottom - (bottom - top) * value / (1.05 * run.largest), right = time(width);
    context.lineWidth = 1.4;
    run.pulses.forEach(({ onset, release, peak }, contact) => {
      context.strokeStyle = contactColour(contact, run.pulses.length);
      context.beginPath();
      let pixel = -2;
      for (let k = Math.max(0, countUpTo(onset, left) - 1); k < onset.length && onset[k] <= right; k++) {
        const from = (onset[k] - left) * scale, to = (release[k] - left) * scale;
        if (to < 0 || to < pixel + 1) continue;
        pixel = to;
        if (to - from < 4) {
          context.moveTo(from, bottom);
          context.lineTo(from, y(peak[k]));
        } else this.tracePulse(context, contact, Math.max(0, from), Math.min(width, to), time, y, bottom);
      }
      context.stroke();
    });
    context.strokeStyle = RULE;
    context.lineWidth = 1;
    context.strokeRect(-1, top - 5, width + 2, bottom - top + 5.5);
  }

  tracePulse(context, contact, from, to, time, y) {
    for (let pixel = from; ; pixel = Math.min(pixel + 2, to)) {
      const value = y(this.run.linear(this.run.F[contact], this.run.place(time(pixel))));
      if (pixel === from) context.moveTo(pixel, value); else context.lineTo(pixel, value);
      if (pixel >= to) return;
    }
  }

  /** The run from start to stop; drawn once, then only the mark moves. */
  drawWhole(t) {
    const { context, width, height } = prepared(this.whole), { run } = this, scale = width / (run.stop - run.start);
    if (this.wholePicture?.width !== this.whole.width) {
      context.fillStyle = RULE;
      context.fillRect(0, height / 2 - 1, width, 2);
      context.fillStyle = TEXT;
      for (const { begin, end } of run.impacts) context.fillRect((begin - run.start) * scale - 0.5, 5, Math.max(1.2, (end - begin) * scale), height - 10);
      this.wholePicture = document.createElement("canvas");
      this.wholePicture.width = this.whole.width;
      this.wholePicture.height = this.whole.height;
      this.wholePicture.getContext("2d").drawImage(this.whole, 0, 0);
    } else context.drawImage(this.wholePicture, 0, 0, width, height);
    context.fillStyle = HEAD;
    context.beginPath();
    context.arc((t - run.start) * scale, height / 2, 6, 0, 2 * Math.PI);
    context.fill();
  }
}
