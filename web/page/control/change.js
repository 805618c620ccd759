// The panel in which a cradle is changed, while it swings.

import { LAWS, MODELS, MOST_BALLS } from "#engine/setup.js";
import { LOSSES } from "#view/captions.js";
import { withPrefix } from "#view/common.js";
import { rounded, say, textsOf } from "#view/texts.js";

const GRAVITIES = { earth: 9.81, moon: 1.62, mars: 3.71, jupiter: 24.8 };
const WEIGHTS = [0.125, 0.25, 0.5, 0.75, 1, 1.5, 2, 4, 8];

const some = (value, text) => (value ? text : say("none")), length = (m) => some(m, withPrefix(m, "m"));

/** Zero, and 1, 2 and 5 times the powers of ten from `first` to before `end`. */
const decades = (first, end) => [0, ...Array.from({ length: 3 * (end - first) }, (_, k) =>
  Number(`${[1, 2, 5][k % 3]}e${first + Math.floor(k / 3)}`))];

/** The values of each parameter of losses. */
const LOST = {
  "contact.damping": { list: decades(1, 7) },
  "contact.huntCrossley": { max: 1, step: 0.05 },
  "contact.relaxationTime": { list: decades(-9, -4) },
  "contact.restitution": { max: 1, step: 0.01 },
};

/** The scale of what contacts lose by the damping law of a set-up; by that of Hunt and Crossley where the usual one
 *  takes nothing. */
function lossScale({ lossName: own, losses }) {
  const name = losses.length || own !== "contact.damping" ? own : "contact.huntCrossley";
  const law = name === own ? {} : { "contact.dampingLaw": "huntCrossley" }, [title, show] = LOSSES[name];
  return { title, ...LOST[name], show, at: (get) => (name === own ? get(name) : 0),
    values: (loss) => ({ ...law, [name]: loss }) };
}

/** Numbers on scales: the set-ups that have them, the place of a number, its text, and the values of a place; or what
 *  makes a scale for a set-up. */
const SCALES = {
  deadBand: { list: [0, 1e-7, 2.6e-7, 5e-7, 1e-6, 2.6e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4], show: length,
    at: (get) => get("contact.deadBand"), values: (m) => ({ "contact.deadBand": m }) },
  stiffness: { min: 4, max: 14, step: 0.5, show: (power) => withPrefix(10 ** power, "N/m", 2),
    needs: (setup) => setup.get("contact.model") === "powerLaw",
    at: (get) =>
      Math.log10(get("contact.stiffness") * (get("contact.overlapRef") / 1e-6) ** (1 - get("contact.exponent"))),
    values: (power) => ({ "contact.stiffness": 10 ** power, "contact.overlapRef": 1e-6 }) },
  loss: lossScale,
  drag: { max: 0.5, step: 0.01, show: (rate, get) => some(rate, `${rounded(rate * get("ball.mass"))} kg/s`),
    at: (get) => get("pendulum.drag") / get("ball.mass"),
    values: (rate, get) => ({ "pendulum.drag": rate * get("ball.mass") }) },
  length: { min: 0.05, max: 2, step: 0.05, show: length, at: (get) => get("pendulum.length"),
    values: (m) => ({ "pendulum.length": m }) },
};

export function fillChange(panels) {
  const { app } = panels, { live, setup } = app.changedSource, refresh = () => panels.refresh();
  if (app.stages.length > 1)
    panels.chips("side", textsOf("sides"), app.side, (side) => { app.side = side; refresh(); });
  else panels.chips("preset", textsOf("presets"), app.preset, (name) => app.choose(name));
  if (!live) return;
  const set = (values) => app.change(values), get = (name) => setup.get(name), { balls } = setup;
  panels.chips("law", textsOf("laws"), setup.law, (law) => set(LAWS[law]));
  for (const [name, made] of Object.entries(SCALES)) {
    const { needs, title = name, at, show, values, ...scale } = typeof made === "function" ? made(setup) : made;
    if (needs?.(setup) ?? true)
      panels.slider(title, { ...scale, value: at(get), show: (place) => show(place, get),
        choose: (place) => set(values(place, get)) });
  }
  panels.chips("model", textsOf("models"), get("pendulum.model"), (model) => set(MODELS[model]));
  const ratios = get("ball.massRatio"), uneven = ratios.findIndex((ratio) => ratio !== 1);
  const ball = Math.min(balls - 1, panels.ball ?? (uneven >= 0 ? uneven : Math.floor(balls / 2)));
  panels.slider("whose", { min: 1, max: balls, value: ball + 1, show: (i) => say("ball", { ball: i }),
    choose: (i) => { panels.ball = i - 1; refresh(); } });
  panels.slider("weight", { list: WEIGHTS, value: ratios[ball],
    show: (ratio) => say("times", { ratio: rounded(ratio) }),
    choose: (ratio) => set({ "ball.massRatio": ratios.map((old, i) => (i === ball ? ratio : old)) }) });
  const world = Object.keys(GRAVITIES).find((name) => GRAVITIES[name] === get("gravity"));
  panels.chips("gravity", textsOf("gravities"), world, (name) => set({ gravity: GRAVITIES[name] }));
  panels.slider("balls", { min: 1, max: MOST_BALLS, value: balls, show: String, choose: (count) => app.resize(count) });
}
