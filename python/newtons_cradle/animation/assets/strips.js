// Energy and contact forces around the time shown, what they are there, and where in the run the clicks are.

/** Drawn as the balls are: kinetic energy has the colour of the arrows. */
const ENERGIES = { kinetic: "kinetic", gravity: "gravity", contact: "in contacts", total: "total" };

class Strips {
  constructor(run) {
    this.run = run;
    for (const name of ["energy", "force", "marks", "energies", "forces"]) this[name] = document.getElementById(name);
    const parts = Object.values(run.energy);
    const totals = Array.from(run.time, (_, i) => parts.reduce((sum, part) => sum + part[i], 0));
    this.energyTop = 1.05 * totals.reduce((a, b) => Math.max(a, b), 0) || 1;
    this.energy.hidden = this.energies.hidden = !parts.length;
    this.force.hidden = this.forces.hidden = this.marks.hidden = run.balls < 2;
    this.pointer = null; // where over the curves it is, part of their width
    this.paint();
  }

  /** Takes the page's colours and writes the legends. */
  paint() {
    const { run } = this, contacts = run.pulses.length, [name] = run.strength;
    const head = name[0].toUpperCase() + name.slice(1);
    this.colours = run.pulses.map((_, i) => seriesColour(i, contacts));
    const ramp = [`contacts 1 to ${contacts}, the largest:`, `linear-gradient(90deg, ${this.colours.join(", ")})`,
      "ramp"];
    const each = this.colours.map((shade, i) => [`${i + 1}–${i + 2}`, shade]);
    this.values = {
      energies: this.legend(this.energies, "Energy", Object.keys(run.energy)
      .map((key) => [ENERGIES[key], colour(`--${key}`)])),
      forces: this.legend(this.forces, head, contacts > 6 ? [ramp] : each),
    };
    this.wholePicture = null;
  }

  /** Patches of colour with names, and a place for the value of each. */
  legend(parent, head, entries) {
    const items = entries.map(([name, shade, kind = ""]) =>
      `<span><i class="${kind}" style="background: ${shade}"></i>${name} <b></b></span>`);
    parent.innerHTML = [`<strong>${head}</strong>`, ...items].join(" ");
    return [...parent.querySelectorAll("b")];
  }

  /** Draws `span` seconds around t, and writes the values there or at the pointer. */
  draw(t, span) {
    const left = t - span / 2;
    this.reading = this.pointer === null ? t
      : Math.min(this.run.stop, Math.max(this.run.start, left + this.pointer * span));
    this.readOut();
    if (!this.energy.hidden) this.drawEnergy(left, span);
    if (!this.force.hidden) this.drawForces(t, left, span);
    this.drawMarks();
  }

  /** The values at `reading`, into the legends. */
  readOut() {
    const { run, reading } = this, place = run.place(reading), unit = run.strength[1];
    Object.values(run.energy).forEach((part, i) => write(this.values.energies[i],
      withPrefix(tidy(linear(part, place), this.energyTop), "J")));
    const now = run.pulses.map(({ onset, release, peak }, i) => {
      const last = countUpTo(onset, reading) - 1;
      if (unit === "N") return tidy(linear(run.F[i], place), run.largest);
      return last >= 0 && reading - release[last] < 1e-6 ? peak[last] : 0;
    });
    if (now.length <= 6) return now.forEach((value, i) => write(this.values.forces[i], withPrefix(value, unit)));
    const most = now.indexOf(Math.max(...now));
    return write(this.values.forces[0], now[most] > 0 ? `${most + 1}–${most + 2}: ${withPrefix(now[most], unit)}`
      : `0 ${unit}`);
  }

  /** The mark of the time shown in the middle, that of the pointer, and the upper end of the scale. */
  drawFrame(context, width, height, top) {
    context.fillStyle = colour("--ink");
    context.fillRect(width / 2 - 0.75, 0, 1.5, height);
    if (this.pointer !== null) {
      context.fillStyle = colour("--soft");
      context.fillRect(this.pointer * width - 0.5, 0, 1, height);
    }
    this.label(context, top, 4, 12, "left");
  }

  /** A text that stays readable on what is drawn below it. */
  label(context, text, x, y, align) {
    const wide = context.measureText(text).width + 6, left = align === "left" ? x - 3 : align === "right" ? x - wide + 3
      : x - wide / 2;
    context.fillStyle = colour("--card");
    context.globalAlpha = 0.9;
    context.fillRect(left, y - 11, wide, 14);
    context.globalAlpha = 1;
    context.fillStyle = colour("--soft");
    context.textAlign = align;
    context.fillText(text, x, y);
  }

  /** Grid lines, named by their distance from the time shown. */
  drawTicks(context, span, width, bottom) {
    const raw = span * 90 / width, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((f) => f * power >= raw);
    for (let k = -Math.floor(span / 2 / step); k * step <= span / 2; k++) {
      const pixel = width / 2 + k * step / span * width;
      context.fillStyle = colour("--line");
      context.fillRect(pixel - 0.5, 0, 1, bottom);
      if (k && pixel > 28 && pixel < width - 28)
        this.label(context, `${k > 0 ? "+" : "−"}${withPrefix(Math.abs(k * step), "s")}`, pixel, bottom + 13, "center");
    }
    if (this.pointer === null) return;
    const away = (this.pointer - 0.5) * span, side = this.pointer > 0.5 ? "right" : "left";
    this.label(context, `at ${away < 0 ? "−" : "+"}${withPrefix(Math.abs(away), "s")}`, this.pointer * width
      + (side === "left" ? 6 : -6), 12, side);
  }

  /** What is stored where, on top of each other. */
  drawEnergy(from, span) {
    const { context, width, height } = prepared(this.energy), { run } = this, columns = Math.ceil(width / 2) + 1;
    const below = new Float64Array(columns);
    const places = Array.from({ length: columns }, (_, i) => from + 2 * i * span / width)
      .map((t) => (t < run.start || t > run.stop ? null : run.place(t)));
    const first = places.findIndex((place) => place), last = places.findLastIndex((place) => place);
    const y = (value) => height * (1 - value / this.energyTop);
    for (const [name, values] of first < 0 ? [] : Object.entries(run.energy)) {
      context.beginPath();
      for (let i = last; i >= first; i--) context.lineTo(2 * i, y(below[i]));
      for (let i = first; i <= last; i++) {
        below[i] += linear(values, places[i]);
        context.lineTo(2 * i, y(below[i]));
      }
      context.fillStyle = colour(`--${name}`);
      context.fill();
    }
    this.drawFrame(context, width, height, withPrefix(this.energyTop / 1.05, "J"));
  }

  /** Curves of the forces; where a pulse is narrower than some pixels, a line as high as its peak. */
  drawForces(t, left, span) {
    const { context, width, height } = prepared(this.force), { run } = this, bottom = height - 17, scale = width / span;
    const right = left + span;
    const y = (value) => bottom - (bottom - 3) * value / run.largest;
    this.drawTicks(context, span, width, bottom);
    run.pulses.forEach(({ onset, release, peak }, contact) => {
      // Equal curves on top of each other stay visible, as the later ones are narrower.
      context.lineWidth = 1.6 + (run.pulses.length <= 6 ? 1.2 * (run.pulses.length - 1 - contact) : 0);
      context.strokeStyle = this.colours[contact];
      context.beginPath();
      let pixel = -2;
      for (let k = Math.max(0, countUpTo(onset, left) - 1); k < onset.length && onset[k] <= right; k++) {
        const from = (onset[k] - left) * scale, to = (release[k] - left) * scale;
        if (to < 0 || to < pixel + 1) continue;
        pixel = to;
        if (to - from < 4) {
          context.moveTo(from, bottom);
          context.lineTo(from, y(peak[k]));
          continue;
        }
        const last = Math.min(width, to), level = (at) => y(linear(run.F[contact], run.place(left + at / scale)));
        let at = Math.max(0, from);
        context.moveTo(at, level(at));
        while (at < last) {
          at = Math.min(at + 2, last);
          context.lineTo(at, level(at));
        }
      }
      context.stroke();
    });
    context.fillStyle = colour("--edge");
    context.fillRect(0, bottom, width, 1);
    this.drawFrame(context, width, bottom, withPrefix(run.largest, run.strength[1]));
  }

  /** A mark for each click of the run. */
  drawMarks() {
    if (this.wholePicture === this.marks.clientWidth) return;
    const { context, width, height } = prepared(this.marks), { run } = this, thumb = 16;
    const scale = (width - thumb) / (run.stop - run.start);
    this.wholePicture = this.marks.clientWidth;
    context.fillStyle = colour("--soft");
    for (const { begin, end } of run.clicks)
      context.fillRect(thumb / 2 + (begin - run.start) * scale - 0.75, 0, Math.max(1.5, (end - begin) * scale), height);
  }
}

/** 0 where a number is nothing beside `largest` but rounding. */
function tidy(value, largest) {
  return Math.abs(value) < 1e-6 * largest ? 0 : value;
}
