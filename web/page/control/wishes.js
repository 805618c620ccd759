// Wishes of the viewer that are no physics: keys, the address, what is shown, day and night.

Object.assign(App.prototype, {
  listen() {
    const { play, again, rest, inside } = this.controls;
    play.onclick = () => this.setRunning(!this.clock.running);
    again.onclick = () => this.again();
    rest.onclick = () => this.stopAll();
    inside.onclick = () => this.inside();
    addEventListener("hashchange", () => this.open(location.hash));
    addEventListener("keydown", (event) => this.key(event));
    // A button that was clicked does not take the space bar, which pauses; one that the keyboard has come to does.
    addEventListener("click", ({ detail }) => { if (detail && document.activeElement?.matches("button")) document.activeElement.blur(); });
    matchMedia("(prefers-color-scheme: light)").addEventListener("change", ({ matches }) => this.setTheme(matches));
    this.setRunning(true);
  },

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const typing = event.target.matches?.("#panel input, select, textarea"), pressed = event.target.matches?.("button");
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (typing || (key === " " && pressed) || !(this.keys || key === "Escape")) return;
    const acts = {
      " ": () => this.setRunning(!this.clock.running), i: () => this.inside(), a: () => this.again(), 0: () => this.stopAll(),
      e: () => this.setOther("every", this.clock.slow !== "always"), ",": () => this.stepInside(-1), ".": () => this.stepInside(1),
      Escape: () => { if (this.panels.kind) this.panels.toggle(this.panels.kind); },
    };
    const panel = { c: "change", s: "show", b: "beside", k: "keep", l: "lesson", "?": "help", h: "help" }[key];
    if (panel) acts[key] = () => this.panels.toggle(panel);
    const act = /^[1-9]$/.test(key) ? () => this.lift(Number(key)) : acts[key];
    if (act) event.preventDefault();
    act?.();
  },

  /** By the keys through a click. */
  stepInside(direction) {
    const { source } = this.stages[0], click = source.shownClick;
    if (click?.length && this.stages.length === 1) this.seek(source.run.time + direction * INSIDE_STEP * click.length);
  },

  setShow(kind, on) {
    this.shows[kind] = on;
    showLink(this);
  },

  setOther(kind, on) {
    if (kind === "every") this.clock.slowAt(on ? "always" : "no");
    if (kind === "sound") this.sound.switchOn(on);
    if (kind === "light") this.setTheme(on);
    if (kind === "keys") this.keys = on;
    showLink(this);
  },

  setPace(rate) {
    this.clock.base = rate;
    if (this.clock.slow === "no") this.clock.rate = rate;
  },

  setTheme(light) {
    this.theme = light ? DAY : NIGHT;
    document.documentElement.classList.toggle("light", light);
    this.theme.energies.forEach((colour, i) => document.documentElement.style.setProperty(`--e${i}`, colour));
  },

  async copyLink() {
    const link = linkTo(this);
    try {
      await navigator.clipboard.writeText(link);
      this.tell(say("copied"));
    } catch {
      this.tell(`${say("linkHere")} ${link}`, 60);
    }
  },

  /** What an address asks for. */
  open(hash) {
    this.attempt(() => {
      const { setup, options } = Setup.fromLink(hash);
      this.engine.start(setup.recipe()).forget();
      this.dropStage();
      this.clock.slowAt("no");
      for (const kind of Object.keys(this.shows)) this.shows[kind] = (options.show ?? "").split(",").includes(kind);
      this.begin(setup, options.preset ?? (hash.includes("balls=") ? null : "textbook"));
      if (options.lift) this.lift(Number(options.lift));
      if (options.beside in TEXTS.besides) this.compare(options.beside);
      if (options.right) this.besideWith(options.right);
      if (options.slow === "always") this.setOther("every", true);
      if (options.slow === "next") this.clock.slowAt("next");
    });
  },

  async openFile(file) {
    if (!file) return;
    const text = await file.text();
    this.attempt(() => {
      const recording = new Recording(file.name, text);
      this.dropStage();
      this.replace(recording);
      this.changed();
    });
  },
});

const NIGHT = {
  name: "night", dark: true, back: "#0f141a", ink: "#eaf0f6", accent: "#ffb54a", focus: "#7cc4ff", grid: "rgba(255,255,255,.14)", spike: "#ffb54a",
  string: "rgba(214,226,238,.62)", rail: ["#69747f", "#b9c3cd", "#4b555f"], base: ["#3a4653", "#1d262f"], label: "#10161d", shadow: "rgba(0,0,0,.62)", noShadow: "rgba(0,0,0,0)",
  ball: [[0, "#eef4fa"], [0.32, "#aebccb"], [0.5, "#6f7f90"], [0.56, "#c2ccd6"], [0.72, "#93a1af"], [1, "#3c4753"]], rim: "rgba(8,14,22,.62)",
  glowMode: "lighter", glow: (strength) => `rgba(255, ${Math.round(140 + 90 * strength)}, ${Math.round(40 + 120 * strength)}, ${strength})`,
  lens: "#131b24", lensLine: "rgba(210,224,238,.75)", lensBall: ["#dfe8f1", "#56636f"], patch: "#fff3d6", energies: ["#6fb6f2", "#8d9db0", "#ffb54a"],
};

const DAY = {
  name: "day", dark: false, back: "#f6f4ef", ink: "#17202a", accent: "#a85a00", focus: "#0b5c9e", grid: "rgba(0,0,0,.16)", spike: "#c05a00",
  string: "rgba(60,72,84,.6)", rail: ["#8b96a1", "#d5dce3", "#66717c"], base: ["#8a6a4c", "#5f452e"], label: "#10161d", shadow: "rgba(40,50,60,.34)", noShadow: "rgba(40,50,60,0)",
  ball: [[0, "#ffffff"], [0.32, "#d3dbe3"], [0.5, "#98a5b2"], [0.56, "#dde3e9"], [0.72, "#b4bec8"], [1, "#66727e"]], rim: "rgba(30,40,52,.5)",
  glowMode: "source-over", glow: (strength) => `rgba(240, ${Math.round(95 + 60 * strength)}, 20, ${0.85 * strength})`,
  lens: "#ffffff", lensLine: "rgba(50,62,74,.75)", lensBall: ["#76838f", "#b4bec8"], patch: "#ff9d2e", energies: ["#4d97d6", "#9aa6b3", "#e08a1e"],
};
