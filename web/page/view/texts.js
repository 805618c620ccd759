// Everything that the page says. To translate it, give this table another language, and choose it in `TEXTS` below.

const ENGLISH = {
  language: "en",
  title: "Newton's cradle",
  hint: "Pull a ball aside and let it go.",
  hintHeld: "Let go, or throw it.",
  hintPaused: "Time stands still. Place the balls where you like, then press Play.",
  play: "Play", pause: "Pause", again: "Let go again", rest: "Stop all",
  inside: "Look inside a click", insideNow: "Leave the click",
  change: "Change", show: "Show", beside: "Compare", keep: "Keep", help: "Keys", close: "Close",
  pace: "Speed of time", realTime: "real time",
  slower: (amount) => `1 s shows ${amount}`,
  late: (part) =>
  `This takes more computing than there is time: the clock runs ${part} % slower, so that the page need not stop.`,
  stageName: (name) => `The cradle: ${name}`,
  ball: (i) => `Ball ${i}`,
  ballAt: (cm, held) => (Math.abs(cm) < 0.05 ? "hanging down"
  : `${Math.abs(cm).toFixed(1)} cm to the ${cm < 0 ? "left" : "right"}`) + (held ? ", held" : ""),
  keys: [
    ["Tab", "choose a ball"], ["← →", "pull it aside, hold it there"], ["Enter", "let go"], ["Space", "pause or play"],
    ["1 to 9", "lift so many balls and let go"], ["I", "look inside the next click"], ["E", "slow down at every click"],
    ["A", "let go again"], ["0", "stop all"], ["C", "change"], ["S", "show"], ["B", "compare"], ["L", "lesson"],
      ["K", "keep"], [", .", "back and on inside a click"],
  ],

  lesson: "Lesson",
  lessons: [
    { title: "Two up, two out",
      text: "Lift two balls and let go: two fly out. Try one, three, four. How does the cradle know how many?" },
    { title: "Why not one, twice as fast?",
      text: "That would keep the momentum. But it would need twice the energy: there the speed is squared. "
        + "Watch both." },
    { title: "Look inside the click",
      text: "Laws of conservation do not say how. Slowed down some 70 000 times: the balls meet in pairs, and each "
        + "hands on all it has." },
    { title: "Steel balls in touch",
      text: "Now they press all at once. Count what flies out: it is no longer only two." },
    { title: "See the difference grow",
      text: "The same release, side by side: after ten clicks the neat pattern is gone where the balls touch." },
    { title: "And one faster after all",
      text: "With a lighter ball at the end the hand-over does not fit: it leaves faster than any ball came in, and "
        + "ball 4 follows it." },
  ],

  preset: "A ready cradle",
  presets: {
    textbook: "Textbook", hertz: "Steel balls in touch", desk: "On the desk", figure5: "Paper: with dead band",
    figure5touching: "Paper: without dead band", thirteen: "Thirteen, 3 against 2", rigid: "Rigid", buzzing: "Buzzing",
  },
  about: {
    textbook: "A hair's breadth of play between the balls: they meet one after the other.",
    hertz: "Steel as it is: the balls touch, and all of them press at once.",
    desk: "22 mm steel balls on 14 cm strings. Each click loses a little.",
    figure5: "Figure 5 of the paper: 0.26 µm of play, two balls lifted by 1 m.",
    figure5touching: "Figure 5 of the paper, the balls in touch: watch the neat pattern dissolve.",
    thirteen: "Figure 3 of the paper: soft contacts, three balls against two.",
    rigid: "Impacts without any duration, as in most textbooks.",
    buzzing: "Twenty hard balls pressed together: hundreds of contacts each second.",
    own: "Your own cradle.",
    recorded: "A recorded run.",
  },
  law: "How the balls push",
  laws: { linear: "Linear", quadratic: "Quadratic", cubic: "Cubic", hertz: "Hertz (spheres)", rigid: "Rigid" },
  deadBand: "Play between the balls", stiffness: "Hardness", loss: "Loss in contacts",
  restitution: "Speed kept in an impact", drag: "Drag of the air",
  balls: "Balls", length: "Strings", gravity: "Gravity",
  gravities: { earth: "Earth", moon: "Moon", mars: "Mars", jupiter: "Jupiter" },
  whose: "Ball", weight: "Its mass",
  times: (ratio) => `${rounded(ratio)} times`,
  none: "none",
  side: "Change the", left: "left one", right: "right one", both: "both",
  waiting: "The change waits until no balls touch.",

  shows: { velocity: "Velocities", force: "Forces", energy: "Energy", momentum: "Momentum",
  numbers: "Numbers on the balls" },
  others: { every: "Slow down at every click", sound: "Sound", light: "Dark or light", keys: "Single keys" },
  rows: {
    velocity: (fastest) => `Velocities, up to ${fastest}`,
    force: (strongest) => `Forces, up to ${strongest}`,
    energy: (total) => `Energy ${total}`,
    momentum: (now) => `Momentum ${now}`,
  },
  exact: (lost, residual) => `lost ${lost} · error of the computation ${residual} J`,
  support: (force) => `pull on the frame ${force}`,
  energies: { kinetic: "of motion", gravity: "of height", elastic: "in contacts" },
  inHand: "in your hand",

  besideWhat: "Beside it, from the same release",
  besides: { usual: "What differs most", hertz: "Steel balls in touch", noBand: "No play between the balls",
  rigid: "Rigid", lossy: "With loss", heavy: "Middle ball twice as heavy", stop: "Nothing" },

  link: "Copy a link to this", copied: "The link is in the clipboard.", linkHere: "Here is the link:",
  picture: "Picture (PNG)", pulsesFile: "Table of pulses (CSV)", runFile: "Run (CSV)",
  open: "Show a recorded run (CSV)",
  badFile: (name, reason) => `${name} cannot be shown: ${reason}`,
  columns: "it needs columns time, x[1], x[2], ... with times that rise",

  approaching: (a, b, time) => `Ball ${a} is ${time} from ball ${b}.`,
  touch: (a, b) => `Ball ${a} touches ball ${b}.`,
  touchWhile: (a, b, c) => `Ball ${b} reaches ball ${c} while ball ${a} still pushes it.`,
  touchWhileRight: (a, b, c) => `Ball ${b} reaches ball ${a} while ball ${c} still pushes it.`,
  part: (a, b) => `Balls ${a} and ${b} part.`,
  partWhile: (leaver, a, b) => `Ball ${a} still touches ball ${b} when ball ${leaver} leaves.`,
  pressed: (count) => ["Nothing touches.", "One contact still presses."][count] ?? `${count} contacts press at once.`,
  lensGap: "gap", lensPressed: "pressed",
  sinceTouch: (time, force) => `${time} after the first touch${force ? ` · ${force}` : ""}`,
  over: (length, count) => `It took ${length}: ${count} ${count === 1 ? "push" : "pushes"}.`,
  overRigid: (count) =>
  `Rigid balls: ${count} ${count === 1 ? "impact" : "impacts"} in no time at all. There is no inside to look at.`,
  leave: (list) => `Now, of the speed that came in: ${list}.`,
  leaver: (ball, percent) => `ball ${ball} ${percent} %`,
  all: "Each ball hangs still.",
  licences: "Licences",
  problem: "Something went wrong",
  reload: "Load the page again to go on.",
};

export const TEXTS = ENGLISH;

/** The text with this name, such as `presets.desk`; if it takes arguments, with these. */
export function say(name, ...given) {
  const text = name.split(".").reduce((table, part) => table[part], TEXTS);
  return typeof text === "function" ? text(...given) : text;
}

/** Fills in what elements of the page ask for: data-text their text, data-label their accessible name. */
export function fillTexts(root = document) {
  document.documentElement.lang = TEXTS.language;
  document.title = say("title");
  for (const element of root.querySelectorAll("[data-text]")) element.textContent = say(element.dataset.text);
  for (const element of root.querySelectorAll("[data-label]"))
    element.setAttribute("aria-label", say(element.dataset.label));
}

export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

/** With this many significant digits, without a power of ten where that can be avoided. */
export function rounded(value, digits = 3) {
  const short = Number(value.toPrecision(digits));
  return String(Math.abs(short) >= 1e-4 || short === 0 ? short : value.toExponential(Math.max(0, digits - 1)))
    .replace("-", "−");
}

/** A tiny number as it is said of residuals: 3.1e-16 becomes 3.1 × 10⁻¹⁶. */
export function power(value, digits = 2) {
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const raised = [...String(Number(exponent))].map((letter) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[letter] ?? "⁻").join("");
  return `${mantissa.replace("-", "−")} × 10${raised}`;
}
