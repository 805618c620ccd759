// What can be kept: a picture, tables.

import { Live } from "#engine/live.js";
import { numbered } from "#engine/table.js";
import { FONT } from "#view/texts.js";

const RUN_STEP = 0.01; // s between the rows of a run in CSV
const RUN_ROWS = 6000;

export function save(name, content) {
  const url = URL.createObjectURL(content), link = document.createElement("a");
  Object.assign(link, { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

/** All stages as they are, on the page's background, with their captions. */
export function savePicture(app) {
  const theme = app.theme, scale = 2, boxes = app.stages.map(({ canvas }) => canvas.getBoundingClientRect());
  const width = boxes.reduce((sum, box) => sum + box.width, 0), height = boxes[0].height + 70;
  const canvas = Object.assign(document.createElement("canvas"), { width: scale * width, height: scale * height });
  const c = canvas.getContext("2d");
  c.scale(scale, scale);
  c.fillStyle = theme.back;
  c.fillRect(0, 0, width, height);
  c.textAlign = "center";
  c.fillStyle = theme.ink;
  app.stages.forEach((stage, i) => {
    const { width: wide, height: tall } = boxes[i], details = [stage.heading.textContent, stage.detail.textContent];
    for (const layer of stage.scene.layers) c.drawImage(layer, 0, 0, wide, tall);
    c.font = `17px ${FONT}`;
    c.fillText(stage.sentence.textContent, wide / 2, height - 42, wide - 20);
    c.font = `14px ${FONT}`;
    c.fillText(details.filter(Boolean).join(" · "), wide / 2, height - 18, wide - 20);
    c.translate(wide, 0);
  });
  canvas.toBlob((blob) => save("cradle.png", blob));
}

export const csv = (lines) => new Blob([lines.map((line) => line.join(",")).join("\n") + "\n"], { type: "text/csv" });

/** The pulses of the run so far, contacts and balls counted from 1. */
export function pulsesTable({ pulses }) {
  return csv([["contact", "onset", "release", "peak", "impulse", "peak_time"],
    ...pulses.map((p) => [p.contact + 1, p.onset, p.release, p.peak, p.impulse, p.peakTime])]);
}

/** The run for this page and `cradle-fmu page`: a recording's samples, or a live run computed again at even times. */
export function runTable(source) {
  const { live, drawing: { balls }, now } = source, run = live ? new Live(source.engine, source.setup) : source;
  const rows = Math.max(2, Math.min(RUN_ROWS, Math.floor(now / RUN_STEP)) + 1);
  const times = live ? Array.from({ length: rows }, (_, k) => k * RUN_STEP) : source.times;
  const counts = { x: balls, v: balls, F: balls - 1, F_peak: balls - 1 };
  const names = Object.entries(counts).flatMap(([name, count]) => numbered(name, count));
  const lines = [["time", ...names, ...(live ? ["E_total", "p_total"] : [])]];
  if (!live) source.seek(source.begin);
  for (const time of times) {
    run.advance(time);
    const { x, v, F, energy, momentum } = run.state, peaks = Array.from(F);
    for (const { contact, peak, impulse } of run.takePulses())
      peaks[contact] = Math.max(peaks[contact], peak || impulse); // of rigid balls, only that is known
    lines.push([time, ...x, ...v, ...F, ...peaks, ...(live ? [energy, momentum] : [])]);
  }
  if (live) run.forget();
  else source.seek(now);
  return csv(lines);
}
