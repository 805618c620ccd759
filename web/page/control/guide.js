// The first minute: until somebody touches the page, a drawn hand shows what hands can do here.

const WAIT = 1, PULL = 1.6, HOLD = 0.5; // s: before the hand comes, while it pulls, and while it keeps still
const LIFT = 0.3; // of the strings' length

export class Guide {
  /** `phase`: "pulls" the first ball, then "has shown" how; null if not needed. */
  constructor(app) {
    Object.assign(this, { app, seconds: 0, phase: location.hash || app.still ? null : "waits" });
    for (const touched of ["pointerdown", "keydown", "hashchange"])
      addEventListener(touched, () => this.leave(), { capture: true });
  }

  follow(passed) {
    this.seconds += passed;
    const { app, seconds } = this, [{ scene, source, canvas }] = app.stages, { hand } = app.controls;
    if (this.phase === "waits" && seconds > WAIT) {
      this.phase = "pulls";
      app.take(this, 0, 0);
    }
    if (this.phase !== "pulls") return;
    const part = Math.min(1, (seconds - WAIT) / PULL);
    app.move(this, 0, -LIFT * source.drawing.length * part * part * (3 - 2 * part));
    const { x, y } = scene.place(0, source.state.x[0]), { left, top } = canvas.getBoundingClientRect();
    hand.style.translate = `${left + x}px ${top + y}px`;
    hand.classList.add("seen");
    if (seconds > WAIT + PULL + HOLD) this.leave("has shown");
  }

  leave(phase = null) {
    const pulls = this.phase === "pulls";
    this.phase = phase;
    this.app.controls.hand.classList.remove("seen");
    if (pulls) this.app.drop(this, 0);
  }
}
