// Ready set-ups. Those of the paper and the desk are the producer's, see packaging/presets; the build puts them here.

const FILES = {{presets}};

/** Values of the FMU where nothing else is said. */
const DEFAULTS = {
  gravity: 9.81, "ball.mass": 1, "ball.radius": 0.0313, "ball.youngModulus": 2.1e11, "ball.poissonRatio": 0.3,
  "pendulum.length": 1.962, "pendulum.drag": 0, "contact.model": "powerLaw", "contact.stiffness": 1e10, "contact.overlapRef": 1e-6,
  "contact.exponent": 1, "contact.deadBand": 2.6e-6, "contact.dampingLaw": "kelvinVoigt", "contact.damping": 0,
  "contact.huntCrossley": 0, "contact.relaxationTime": 0, "contact.restitution": 1,
};

/** The lesson's steps, see docs/lesson.md, as parts of the address. */
const LESSON = [
  "preset=textbook&lift=2",
  "preset=textbook&lift=2&show=energy,momentum",
  "preset=textbook&lift=2&slow=next",
  "preset=hertz&lift=2&slow=next",
  "preset=textbook&lift=2&beside=hertz",
  "preset=textbook&ball.massRatio=1,1,1,1,0.5&lift=1&slow=next&show=velocity",
];

function fromFile(name, changes = {}) {
  const { balls, ...values } = FILES[name];
  return new Setup(balls, { ...values, ...changes });
}

/** A cradle that fits a table: 1 kg balls on strings of 0.4 m. */
const TABLE = { "pendulum.length": 0.4 };

/** Steel balls that touch each other. */
const TOUCHING = { "contact.model": "hertz", "contact.deadBand": 0 };

/** `beside`: what it is compared with, as changes of its values. */
const PRESETS = {
  textbook: { setup: () => new Setup(5, { ...TABLE, "contact.deadBand": 2e-5 }), beside: TOUCHING },
  hertz: { setup: () => new Setup(5, { ...TABLE, ...TOUCHING }), beside: { "contact.model": "rigid" } },
  desk: { setup: () => fromFile("desk"), beside: { "contact.huntCrossley": 0 } },
  figure5: { setup: () => fromFile("figure5"), beside: { "contact.deadBand": 0 } },
  figure5touching: { setup: () => fromFile("figure5", { "contact.deadBand": 0 }), beside: { "contact.deadBand": 2.6e-7 } },
  thirteen: { setup: () => fromFile("figure3"), beside: { "contact.exponent": 1.5 } },
  rigid: { setup: () => new Setup(5, { ...TABLE, "contact.model": "rigid", "contact.deadBand": 0 }), beside: { "contact.restitution": 0.95 } },
  buzzing: {
    setup: () => new Setup(20, {
      "pendulum.length": 0.4, "contact.deadBand": 0, "contact.stiffness": 1e14, "contact.exponent": 1.5,
      "contact.gap": Array(19).fill(-2e-8), x_start: [-0.1],
    }),
    beside: { "contact.dampingLaw": "huntCrossley", "contact.huntCrossley": 0.3 },
  },
};
