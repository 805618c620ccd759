// The cradle in three dimensions. Lengths in metres; x to the right, y up, z towards the eye.

const STEEL = new THREE.Color(0.9, 0.93, 0.97);

/** A square picture, `size` pixels wide. */
function picture(size, draw) {
  const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
  draw(canvas.getContext("2d"));
  return new THREE.CanvasTexture(canvas);
}

/** A picture full of a radial gradient between two circles. */
function radial(size, circles, stops) {
  return picture(size, (context) => {
    context.fillStyle = shaded(context.createRadialGradient(...circles), stops);
    context.fillRect(0, 0, size, size);
  });
}

/** A picture of a lit sphere: looking it up costs less than lights, which a renderer without a GPU feels. */
function litSphere(stops) { return radial(128, [45, 34, 2, 64, 64, 70], stops); }

/** A disc of a colour rgba(r,g,b,a) that fades out. */
function softDisc(inner) { return radial(64, [32, 32, 0, 32, 32, 32], [inner, inner.replace(/[\d.]+\)$/, "0)")]); }

/** Whether WebGL has no GPU to draw with. Smoothing edges would then double the work. */
function drawnByProcessor() {
  const context = document.createElement("canvas").getContext("webgl");
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

class Scene {
  constructor(canvas, run) {
    this.canvas = canvas;
    this.run = run;
    this.measure();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: devicePixelRatio < 2 && !drawnByProcessor() });
    this.scene = new THREE.Scene();
    this.eye = new Eye(canvas);
    // of each ball: where it is drawn (m), its arrow's length (m), the glow of the contact to its right
    this.shown = [];
    this.numbers = new Map();
    this.build();
    this.paint();
    this.resolution = Math.min(devicePixelRatio, 2);
  }

  /** Sizes of the drawing. Balls too small to see are drawn larger; strings so that they fit and no angle gets too
   *  large. */
  measure() {
    const run = this.run;
    const most = (columns) => columns.reduce((most, column) => column.reduce((a, b) => Math.max(a, Math.abs(b)), most),
      0);
    const extent = this.extent = most(run.x);
    this.fastest = most(run.v) || 1;
    this.hanging = extent <= 1.5 * run.length;
    this.radius = Math.max(run.radius, (this.hanging ? 0.1 : 0.03) * extent);
    this.width = 2 * this.radius * run.balls + 2 * extent;
    this.stringLength = Math.max(Math.min(run.length, 0.6 * this.width), extent / 1.1);
    this.notes = [];
    if (this.radius > run.radius)
      this.notes.push(`balls drawn ${(this.radius / run.radius).toPrecision(2)} times as large`);
    if (this.hanging && this.stringLength !== run.length)
      this.notes.push(`strings drawn at ${Math.round(100 * this.stringLength / run.length)} %`);
    if (!this.hanging) this.notes.push("drawn on a rail: the balls move further than strings let them");
  }

  build() {
    const { balls } = this.run, segments = balls <= 30 ? [32, 20] : balls <= 300 ? [16, 10] : [8, 6];
    const r = this.radius, instanced = (geometry, material, count) => {
      const mesh = new THREE.InstancedMesh(geometry, material, Math.max(1, count));
      mesh.count = count;
      mesh.frustumCulled = false;
      this.scene.add(mesh);
      return mesh;
    };
    const steel = litSphere([[0, "#ffffff"], [0.12, "#e9eef5"], [0.45, "#8e9bab"], [0.75, "#3f4a58"], [1, "#1c242e"]]);
    this.balls = instanced(new THREE.SphereGeometry(r, ...segments), new THREE.MeshMatcapMaterial({ matcap: steel }),
      balls);
    const glow = { map: softDisc("rgba(255,255,255,1)"), transparent: true, depthTest: false };
    this.sparks = instanced(new THREE.PlaneGeometry(1, 1), new THREE.MeshBasicMaterial(glow), balls - 1);
    const arrow = this.arrow = new THREE.MeshBasicMaterial();
    this.shafts = instanced(new THREE.BoxGeometry(1, 0.09 * r, 0.09 * r), arrow, balls);
    this.tips = instanced(new THREE.ConeGeometry(0.17 * r, 0.42 * r, 10).rotateZ(-Math.PI / 2), arrow, balls);
    this.finishes = { dark: litSphere([[0, "#6e7d8f"], [0.5, "#36424f"], [1, "#171d25"]]),
      light: litSphere([[0, "#ffffff"], [0.5, "#cbd1d9"], [1, "#929dab"]]) };
    this.frame = new THREE.MeshMatcapMaterial({ matcap: this.finishes.dark });
    this.buildFrame(this.frame);
    if (this.hanging) {
      const shade = { map: softDisc("rgba(0,0,0,0.55)"), transparent: true, depthWrite: false };
      this.shadows = instanced(new THREE.PlaneGeometry(3 * r, 3 * r).rotateX(-Math.PI / 2),
        new THREE.MeshBasicMaterial(shade), balls);
      this.stringPoints = new Float32Array(balls * 12);
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(this.stringPoints, 3));
      this.strings = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial());
      this.strings.frustumCulled = false;
      this.scene.add(this.strings);
    }
  }

  /** Takes the page's colours, which change between day and night. */
  paint() {
    const dark = DARK.matches;
    this.renderer.setClearColor(colour("--paper"));
    this.frame.matcap = this.finishes[dark ? "dark" : "light"];
    this.arrow.color.set(colour("--kinetic"));
    this.strings?.material.color.set(colour("--edge"));
    this.colours = this.run.pulses.map((_, i) => new THREE.Color(seriesColour(i, this.run.balls - 1)));
    this.colours.forEach((shine, i) => this.sparks.setColorAt(i, shine));
    if (this.sparks.instanceColor) this.sparks.instanceColor.needsUpdate = true;
    this.sparks.material.blending = dark ? THREE.AdditiveBlending : THREE.NormalBlending;
    this.eye.changed = true;
  }

  /** Bars, legs and base plate, or the rail. */
  buildFrame(material) {
    const r = this.radius, top = this.stringLength, depth = this.depth = Math.max(3.2 * r, 0.3 * top);
    const half = this.half = this.run.balls * r + 0.35 * top, bar = 0.16 * r + 0.008 * top;
    const floor = this.floor = -2.7 * r;
    const box = (width, height, breadth, x, y, z) => {
      const mesh = new THREE.Mesh(new THREE.BoxGeometry(width, height, breadth), material);
      mesh.position.set(x, y, z);
      this.scene.add(mesh);
    };
    if (!this.hanging) return box(2 * this.width, 0.1 * r, 0.1 * r, 0, -1.05 * r, 0);
    // Bars between the legs: where both had faces in one plane, the picture would flicker.
    for (const z of [-depth / 2, depth / 2]) {
      box(2 * half - bar, bar, bar, 0, top, z);
      for (const x of [-half, half]) box(bar, top + bar / 2 - floor, bar, x, (top + bar / 2 + floor) / 2, z);
    }
    return box(2 * half + 3 * r, 0.3 * r, depth + 2.4 * r, 0, floor - 0.15 * r, 0);
  }

  /** Moves everything to the state at one instant: positions (m), velocities (m/s), glow of the contacts (0 to 1). */
  update({ x, v, glow }) {
    const { balls } = this.run, r = this.radius, L = this.stringLength, matrix = new THREE.Matrix4();
    const tint = new THREE.Color();
    this.shown = x.map((away, i) => {
      const rest = 2 * r * (i - 0.5 * (balls - 1)), angle = away / L;
      const place = { rest, arrow: 2.6 * r * v[i] / this.fastest, glow: glow[i] ?? 0 };
      if (!this.hanging) return { x: rest + away, y: 0, ...place };
      return { x: rest + L * Math.sin(angle), y: L * (1 - Math.cos(angle)), ...place };
    });
    for (let i = 0; i < balls; i++) {
      const { rest, x: px, y: py, arrow } = this.shown[i];
      this.balls.setMatrixAt(i, matrix.makeTranslation(px, py, 0));
      const hotter = (glow[i] ?? 0) > (glow[i - 1] ?? 0) ? i : i - 1;
      tint.copy(STEEL);
      if (glow[hotter] > 0) tint.lerp(this.colours[hotter], 0.85 * Math.min(1, Math.sqrt(glow[hotter])));
      this.balls.setColorAt(i, tint);
      this.moveArrow(i, px, py, arrow);
      if (!this.hanging) continue;
      this.shadows.setMatrixAt(i, matrix.makeTranslation(px, this.floor + 0.01 * r, 0));
      this.stringPoints.set([px, py, 0, rest, L, this.depth / 2, px, py, 0, rest, L, -this.depth / 2], 12 * i);
    }
    for (const mesh of [this.balls, this.shafts, this.tips, this.shadows])
      if (mesh) mesh.instanceMatrix.needsUpdate = true;
    this.balls.instanceColor.needsUpdate = true;
    if (this.strings) this.strings.geometry.attributes.position.needsUpdate = true;
  }

  /** The arrow below a ball: as long as it is fast. */
  moveArrow(i, x, y, length) {
    const r = this.radius, shown = Math.abs(length) > 0.01 * r ? 1 : 0, matrix = new THREE.Matrix4();
    matrix.makeScale(shown * length, shown, shown).setPosition(x + length / 2, y - 1.55 * r, 0);
    this.shafts.setMatrixAt(i, matrix);
    matrix.makeScale(shown * Math.sign(length || 1), shown, shown).setPosition(x + length, y - 1.55 * r, 0);
    this.tips.setMatrixAt(i, matrix);
  }

  /** What the eye must see: boxes of everything, of the balls' paths with their arrows, and of the balls now. */
  boxes() {
    const { run, radius: r, stringLength: L, extent } = this;
    const box = (left, right, low, high, z) =>
      ({ low: new THREE.Vector3(left, low, -z), high: new THREE.Vector3(right, high, z) });
    const rise = this.hanging ? L * (1 - Math.cos(extent / L)) : 0;
    const reach = run.balls * r + (this.hanging ? Math.hypot(extent, 3 * r) : extent + 3 * r);
    const left = Math.min(...this.shown.map(({ x, arrow }) => Math.min(x - r, x + arrow - 0.3 * r)));
    const right = Math.max(...this.shown.map(({ x, arrow }) => Math.max(x + r, x + arrow + 0.3 * r)));
    const paths = box(-reach, reach, -2 * r, rise + 1.2 * r, r);
    const now = box(left, right, -2 * r, Math.max(...this.shown.map(({ y }) => y)) + 1.2 * r, r);
    const half = Math.max(reach, this.half);
    return [this.hanging ? box(-half, half, this.floor - 0.4 * r, L, this.depth / 2) : paths, paths, now];
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas, size = `${width} ${height} ${this.resolution}`;
    if (!width || !height) return;
    if (size !== this.size) {
      this.size = size;
      this.renderer.setPixelRatio(this.resolution);
      this.renderer.setSize(width, height, false);
      this.eye.camera.aspect = width / height;
    }
    this.eye.place(...this.boxes());
    this.placeSparks();
    this.placeNumbers(height);
    this.renderer.render(this.scene, this.eye.camera);
  }

  /** The shine between two balls that press each other faces the eye. */
  placeSparks() {
    const matrix = new THREE.Matrix4(), scale = new THREE.Vector3();
    for (let i = 0; i + 1 < this.run.balls; i++) {
      const a = this.shown[i], b = this.shown[i + 1];
      matrix.makeRotationFromQuaternion(this.eye.camera.quaternion)
        .scale(scale.setScalar(this.radius * 2.6 * Math.sqrt(a.glow)));
      this.sparks.setMatrixAt(i, matrix.setPosition((a.x + b.x) / 2, (a.y + b.y) / 2, 0));
    }
    this.sparks.instanceMatrix.needsUpdate = true;
  }

  /** Numbers on the balls; where these are small, above them, and where they are many, on some of them. */
  placeNumbers(height) {
    const { radius: r, run, eye } = this, pixel = 2 * eye.distance * Math.tan(OPENING / 2) / height;
    const small = r < 9 * pixel;
    const size = Math.max(0.75 * r, 17 * pixel), towards = eye.camera.getWorldDirection(new THREE.Vector3())
      .multiplyScalar(-1.01 * r);
    const every = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((step) => 2 * r * step > size
      && run.balls / step <= 40) ?? 1000;
    for (const label of this.numbers.values()) label.visible = false;
    for (let i = 1; i <= run.balls; i = i === 1 && every > 1 ? every : i + every) {
      if (!this.numbers.has(i)) this.numbers.set(i, this.number(i));
      const label = this.numbers.get(i), { x, y } = this.shown[i - 1];
      label.visible = true;
      label.scale.setScalar(size);
      label.position.set(x, y + (small ? r + 0.6 * size : 0), 0);
      if (!small) label.position.add(towards);
    }
  }

  number(i) {
    const map = picture(96, (context) => {
      context.fillStyle = "#ffffff";
      context.arc(48, 48, 44, 0, 2 * Math.PI);
      context.fill();
      context.fillStyle = "#1c2430";
      context.font = `600 ${[62, 52, 38, 30][String(i).length - 1]}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillText(String(i), 48, 52);
    });
    const label = new THREE.Sprite(new THREE.SpriteMaterial({ map }));
    label.renderOrder = 2;
    this.scene.add(label);
    return label;
  }
}
