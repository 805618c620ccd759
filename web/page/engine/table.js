// A recorded run in CSV as FMPy writes it, with the checks and words of python/newtons_cradle/recording.py.

import { Refusal } from "#engine/engine.js";
import { largest, withPrefix } from "#view/common.js";
import { say } from "#view/texts.js";

const COARSE = 0.05; // of the largest excursion: how far a ball may be from where its velocities take it
const STRUCK = 0.3;  // of the largest velocity: a change from one sample to the next that only an impact makes
const TRUTH = { True: 1, False: 0 };
const ENERGIES = { kinetic: "E_kinetic", gravity: "E_gravity", elastic: "E_contact" };

/** The run in a file {balls, time, x, v, F, energy, pulses}. Throws Refusal, with the fault and what is needed. */
export function fromCsv(file, text) {
  const refuse = (reason, values) => {
    throw new Refusal(say("badFile", { file, reason: say(`refused.${reason}`, values) }));
  };
  const columns = columnsOf(text, refuse), balls = ballsOf([...columns.keys()]);
  const missing = ["time", ...numbered("x", balls), ...numbered("v", balls), ...numbered("F", balls - 1)]
    .filter((name) => !columns.has(name));
  if (missing.length) refuse("missing", { names: [...missing.slice(0, 6), ...(missing[6] ? ["…"] : [])].join(", ") });
  const run = runOf(columns), { time } = run;
  if (time.length < 2 || time.some((t, k) => k && t <= time[k - 1])) refuse("rising");
  refuseCoarse(refuse, run);
  const peaks = vector(columns, "F_peak", balls - 1), known = peaks.every(Boolean);
  if (!known) refuseMissed(refuse, run);
  return { ...run, pulses: guessedPulses(time, known ? peaks : run.F) };
}

/** The columns of numbers by their names in the first line. */
function columnsOf(text, refuse) {
  const lines = text.replace(/^\uFEFF/, "").split(/\r?\n/);
  const cells = (line) => line.split(",").map((cell) => cell.trim().replace(/^"(.*)"$/, "$1")), names = cells(lines[0]);
  if (!names.includes("time")) refuse("table");
  const rows = [...lines.keys()].slice(1).filter((number) => lines[number].trim());
  const columns = names.map(() => new Float64Array(rows.length));
  rows.forEach((number, row) => {
    const found = cells(lines[number]), line = number + 1;
    if (found.length !== names.length) refuse("cells", { line, found: found.length, names: names.length });
    found.forEach((cell, i) => {
      columns[i][row] = TRUTH[cell] ?? (cell ? Number(cell) : NaN);
      if (!Number.isFinite(columns[i][row])) refuse("number", { line, cell });
    });
  });
  return new Map(names.map((name, i) => [name, columns[i]]));
}

/** The motion, forces and energies {balls, time, x, v, F, energy} in these columns. */
export function runOf(columns) {
  const balls = ballsOf([...columns.keys()]), of = (name, count = balls) => vector(columns, name, count);
  const energy = {}, total = columns.get("E_total");
  for (const [part, stored] of Object.entries(ENERGIES))
    for (const [name, column] of columns)
      if (name.split("[")[0] === stored) energy[part] = column.map((value, k) => value + (energy[part]?.[k] ?? 0));
  return { balls, time: columns.get("time"), x: of("x"), v: of("v"), F: of("F", balls - 1),
    energy: Object.keys(energy).length || !total ? energy : { total } };
}

/** The names of a vector's elements, from `name[1]` on. */
export const numbered = (name, count) => Array.from({ length: count }, (_, i) => `${name}[${i + 1}]`);

const vector = (columns, name, count) => numbered(name, count).map((element) => columns.get(element));

/** As many balls as the file names, at least one. */
function ballsOf(names) {
  const ofContacts = /^(F|F_peak|F_mean|impulse|E_contact|gap)$/;
  const numbers = names.map((name) => /^(\w+)\[(\d+)\]$/.exec(name)).filter(Boolean);
  return Math.max(1, ...numbers.map(([, name, i]) => Number(i) + ofContacts.test(name)));
}

/** Refuses samples that do not resolve the motion. */
function refuseCoarse(refuse, { time, x, v }) {
  const edge = (of) => of(...x.map((column) => column.reduce((a, b) => of(a, b))));
  const extent = edge(Math.max) - edge(Math.min);
  let worst = { away: COARSE * extent };
  x.forEach((place, i) => place.forEach((_, k) => {
    const h = time[k + 1] - time[k], away = Math.abs(place[k + 1] - place[k] - 0.5 * h * (v[i][k + 1] + v[i][k]));
    if (away > worst.away) worst = { away, h, ball: i + 1, time: `${time[k]} s` };
  }));
  const { away, h, ...where } = worst, finer = Number((0.9 * h * COARSE * extent / away).toPrecision(1));
  if (h) refuse("coarse", { ...where, step: withPrefix(h, "s"), finer: withPrefix(finer, "s") });
}

/** Refuses where a ball was struck between samples and neither of them shows a force. */
function refuseMissed(refuse, { time, v, F }) {
  const fastest = largest(v);
  time.forEach((from, k) => {
    const ball = 1 + v.findIndex((column, i) => Math.abs(column[k + 1] - column[k]) > STRUCK * fastest
      && ![F[i - 1], F[i]].some((force) => force && (force[k] || force[k + 1])));
    if (ball && v.length > 1) refuse("missed", { ball, from: `${from} s`, to: `${time[k + 1]} s` });
  });
}

/** Pulses from samples of the forces, or from their peaks: while a contact's samples are not 0. */
function guessedPulses(time, forces) {
  const pulses = [];
  forces.forEach((force, contact) => force.forEach((size, k) => {
    if (!(size > 0)) return;
    if (!(force[k - 1] > 0)) pulses.push({ contact, onset: time[Math.max(0, k - 1)], peak: 0 });
    const pulse = pulses.at(-1);
    Object.assign(pulse, { release: time[k], peak: Math.max(pulse.peak, size) });
  }));
  return pulses;
}
