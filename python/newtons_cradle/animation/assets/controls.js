// Buttons, keys and the pointer over the curves; what the page says besides the picture.

class Controls {
  constructor(player) {
    this.player = player;
    for (const item of document.querySelectorAll("[id]")) this[item.id] = item;
    this.whole.min = player.run.start;
    this.whole.max = player.run.stop;
    this.describe();
    this.listen();
  }

  /** The parameters, and how the drawing departs from them. */
  describe() {
    const { run, scene } = this.player;
    for (const row of run.parameters) {
      const line = this.parameters.tBodies[0].insertRow();
      for (const text of row) line.insertCell().textContent = text;
    }
    this.parameters.hidden = !run.parameters.length;
    const sizes = `Pendulum ${withPrefix(run.length, "m", 4)}, radius of a ball ${withPrefix(run.radius, "m")}`;
    const known = run.parameters.length ? "" : ` (for the drawing; the file names no parameters)`;
    const notes = scene.notes.map((note) => ` ${note[0].toUpperCase()}${note.slice(1)}.`).join("");
    this.notes.textContent = `${run.title}. ${sizes}${known}.${notes}`;
    this.subtitle.textContent = [run.title, ...scene.notes].join(" · ");
  }

  listen() {
    const { player } = this;
    this.play.onclick = () => player.play();
    this.next.onclick = () => player.jump(1);
    this.previous.onclick = () => player.jump(-1);
    this.inside.onclick = () => (player.inside ? player.leave() : player.open());
    this.about.onclick = () => this.details.showModal();
    this.speed.oninput = () => player.setSpeed(player.slowest ** (1 - Number(this.speed.value)));
    this.whole.oninput = () => player.go(Number(this.whole.value));
    for (const canvas of [this.energy, this.force]) {
      this.drag(canvas);
      canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        player.setSpeed(player.base * Math.exp(0.002 * event.deltaY));
      }, { passive: false });
    }
    addEventListener("keydown", (event) => this.key(event));
  }

  /** Keys that the element in focus does not need itself. */
  key(event) {
    const { player } = this, { eye } = player.scene, { target } = event, arrow = event.key.startsWith("Arrow");
    const step = 0.02 * SHOWN * player.speed();
    if (this.details.open || event.ctrlKey || event.metaKey || event.altKey) return;
    if ((event.key === " " && target.matches("button")) || (arrow && target.matches("input"))) return;
    const turn = { ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.08], ArrowDown: [0, -0.08] }[event.key];
    const keys = {
      " ": () => player.play(), "]": () => player.jump(1), "[": () => player.jump(-1), i: () => this.inside.click(),
      "+": () => eye.approach(0.8), "=": () => eye.approach(0.8), "-": () => eye.approach(1.25), 0: () => eye.home(),
      ArrowRight: () => player.go(player.t + step), ArrowLeft: () => player.go(player.t - step),
    };
    const act = turn && target === this.stage ? () => eye.turn(...turn)
      : keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (act) event.preventDefault();
    act?.();
  }

  /** The pointer over the curves reads their values; held down, it moves in time. */
  drag(canvas) {
    const { player } = this, { strips } = player;
    let grip = null;
    canvas.onpointerdown = ({ pointerId, offsetX }) => {
      canvas.setPointerCapture(pointerId);
      grip = { x: offsetX, t: player.t, played: player.playing };
      player.frozen = SHOWN * player.speed();
      player.play(false);
    };
    canvas.onpointermove = ({ offsetX }) => {
      strips.pointer = offsetX / canvas.clientWidth;
      player.dirty = true;
      if (grip) player.go(grip.t - (offsetX - grip.x) * player.frozen / canvas.clientWidth);
    };
    canvas.onpointerup = canvas.onpointercancel = () => {
      if (grip?.played) player.play(true);
      grip = player.frozen = null;
      player.dirty = true;
    };
    canvas.onpointerleave = () => {
      strips.pointer = null;
      player.dirty = true;
    };
  }

  /** Writes what changes with the time shown. */
  show(speed, span) {
    const { player } = this, { inside, click } = player;
    const digits = Math.min(12, Math.max(2, 2 - Math.floor(Math.log10(span))));
    const pace = (rate) => (rate === 1 ? "real time" : `1 s shows ${withPrefix(rate, "s", 2)}`);
    write(this.time, `${player.t.toFixed(digits)} s`);
    write(this.pace, pace(speed));
    write(this.factor, pace(player.base));
    write(this.caption, player.caption());
    write(this.play, player.playing ? "Pause" : "Play");
    write(this.previous, inside ? "‹ Stage" : "‹ Click");
    write(this.next, inside ? "Stage ›" : "Click ›");
    write(this.inside, inside ? "Back to real time" : "Look inside this click");
    this.inside.disabled = !inside && (!click || click.closed !== "");
    this.whole.value = player.t;
    this.whole.ariaValueText = `${player.t.toFixed(2)} s`;
    this.speed.value = 1 - Math.log(player.base) / Math.log(player.slowest);
    this.speed.ariaValueText = pace(player.base);
  }
}
