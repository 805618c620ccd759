// The cradle in three dimensions. Lengths in metres; x to the right, y up, z towards the eye.

const STEEL = new THREE.Color(0.86, 0.9, 0.96), WARM = new THREE.Color(1.0, 0.62, 0.18), HOT = new THREE.Color(1.0, 0.27, 0.1);

const AZIMUTH = 0.28; // rad, where the eye is at first

/** A picture of a lit sphere: looking it up costs less than lights, which a renderer without a GPU feels. */
function litSphere(stops) {
  const size = 128, canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const context = canvas.getContext("2d"), gradient = context.createRadialGradient(45, 34, 2, 64, 64, 70);
  for (const [at, colour] of stops) gradient.addColorStop(at, colour);
  context.fillStyle = gradient;
  context.fillRect(0, 0, size, size);
  return new THREE.CanvasTexture(canvas);
}

/** Whether WebGL has no GPU to draw with. Smoothing edges would then double the work. */
function drawnByProcessor() {
  const context = document.createElement("canvas").getContext("webgl"), names = context?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

function softDisc(inner) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const context = canvas.getContext("2d"), gradient = context.createRadialGradient(32, 32, 0, 32, 32, 32);
  gradient.addColorStop(0, inner);
  gradient.addColorStop(1, inner.replace(/[\d.]+\)$/, "0)"));
  context.fillStyle = gradient;
  context.fillRect(0, 0, 64, 64);
  return new THREE.CanvasTexture(canvas);
}

class Scene {
  constructor(canvas, run) {
    this.canvas = canvas;
    this.run = run;
    this.measure();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: devicePixelRatio < 2 && !drawnByProcessor() });
    this.renderer.setClearColor(0x10151c);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01 * this.width, 100 * this.width);
    this.build();
    this.home();
    this.listen();
    this.resolution = Math.min(devicePixelRatio, 2);
  }

  /** Sizes of the drawing. Balls too small to see are drawn larger; strings so that they fit and no angle gets too large. */
  measure() {
    const run = this.run;
    let extent = 0, fastest = 0;
    for (const column of run.x) for (const value of column) extent = Math.max(extent, Math.abs(value));
    for (const column of run.v) for (const value of column) fastest = Math.max(fastest, Math.abs(value));
    this.fastest = fastest || 1;
    this.hanging = extent <= 1.5 * run.length;
    this.radius = Math.max(run.radius, (this.hanging ? 0.1 : 0.03) * extent);
    this.width = 2 * this.radius * run.balls + 2 * extent;
    this.stringLength = Math.max(Math.min(run.length, 0.6 * this.width), extent / 1.1);
    const notes = [];
    if (this.radius > run.radius) notes.push(`balls drawn ${(this.radius / run.radius).toPrecision(2)} times their size`);
    if (this.hanging && this.stringLength !== run.length) notes.push(`strings drawn at ${Math.round(100 * this.stringLength / run.length)} % of their length`);
    if (!this.hanging) notes.push("drawn on a rail: the balls move further than strings let them");
    this.notes = notes;
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
    const dark = litSphere([[0, "#6e7d8f"], [0.5, "#36424f"], [1, "#171d25"]]);
    this.balls = instanced(new THREE.SphereGeometry(r, ...segments), new THREE.MeshMatcapMaterial({ matcap: steel }), balls);
    const glow = { map: softDisc("rgba(255,170,70,1)"), blending: THREE.AdditiveBlending, transparent: true, depthTest: false };
    this.sparks = instanced(new THREE.PlaneGeometry(1, 1), new THREE.MeshBasicMaterial(glow), balls - 1);
    const arrow = new THREE.MeshBasicMaterial({ color: 0x5cc8ff });
    this.shafts = instanced(new THREE.BoxGeometry(1, 0.09 * r, 0.09 * r), arrow, balls);
    this.tips = instanced(new THREE.ConeGeometry(0.17 * r, 0.42 * r, 10).rotateZ(-Math.PI / 2), arrow, balls);
    this.buildFrame(new THREE.MeshMatcapMaterial({ matcap: dark }));
    if (this.hanging) {
      const shade = { map: softDisc("rgba(0,0,0,0.55)"), transparent: true, depthWrite: false };
      this.shadows = instanced(new THREE.PlaneGeometry(3 * r, 3 * r).rotateX(-Math.PI / 2), new THREE.MeshBasicMaterial(shade), balls);
      this.stringPoints = new Float32Array(balls * 12);
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(this.stringPoints, 3));
      this.strings = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x8896a6 }));
      this.strings.frustumCulled = false;
      this.scene.add(this.strings);
    }
  }

  /** Bars, legs and base plate, or the rail. */
  buildFrame(material) {
    const r = this.radius, top = this.stringLength, depth = this.depth = Math.max(3.2 * r, 0.3 * top);
    const half = this.run.balls * r + 0.35 * top, bar = 0.16 * r + 0.008 * top, floor = this.floor = -2.7 * r;
    const box = (width, height, breadth, x, y, z) => {
      const mesh = new THREE.Mesh(new THREE.BoxGeometry(width, height, breadth), material);
      mesh.position.set(x, y, z);
      this.scene.add(mesh);
    };
    if (!this.hanging) return box(2 * this.width, 0.1 * r, 0.1 * r, 0, -1.05 * r, 0);
    for (const z of [-depth / 2, depth / 2]) {
      box(2 * half, bar, bar, 0, top, z);
      for (const x of [-half, half]) box(bar, top - floor, bar, x, (top + floor) / 2, z);
    }
    return box(2 * half + 3 * r, 0.3 * r, depth + 2.4 * r, 0, floor - 0.15 * r, 0);
  }

  /** Moves everything to the state at one instant: positions (m), velocities (m/s), glow of the contacts (0 to 1). */
  update({ x, v, glow }) {
    const { balls } = this.run, r = this.radius, L = this.stringLength, matrix = new THREE.Matrix4(), colour = new THREE.Color();
    const middle = 0.5 * (balls - 1), at = (i) => {
      const rest = 2 * r * (i - middle), angle = x[i] / L;
      return this.hanging ? [rest, rest + L * Math.sin(angle), L * (1 - Math.cos(angle))] : [rest, rest + x[i], 0];
    };
    for (let i = 0; i < balls; i++) {
      const [rest, px, py] = at(i), heat = Math.max(glow[i - 1] ?? 0, glow[i] ?? 0);
      this.balls.setMatrixAt(i, matrix.makeTranslation(px, py, 0));
      colour.copy(STEEL).lerp(WARM, Math.min(1, 2 * heat)).lerp(HOT, Math.max(0, 2 * heat - 1));
      this.balls.setColorAt(i, colour);
      this.moveArrow(i, px, py, v[i] / this.fastest);
      if (!this.hanging) continue;
      this.shadows.setMatrixAt(i, matrix.makeTranslation(px, this.floor + 0.01 * r, 0));
      this.stringPoints.set([px, py, 0, rest, L, this.depth / 2, px, py, 0, rest, L, -this.depth / 2], 12 * i);
    }
    for (let i = 0; i + 1 < balls; i++) {
      const [, ax, ay] = at(i), [, bx, by] = at(i + 1), size = r * 2.6 * Math.sqrt(glow[i]);
      matrix.makeRotationFromQuaternion(this.camera.quaternion).scale(new THREE.Vector3(size, size, size));
      this.sparks.setMatrixAt(i, matrix.setPosition((ax + bx) / 2, (ay + by) / 2, 0));
    }
    for (const mesh of [this.balls, this.sparks, this.shafts, this.tips, this.shadows]) if (mesh) mesh.instanceMatrix.needsUpdate = true;
    this.balls.instanceColor.needsUpdate = true;
    if (this.strings) this.strings.geometry.attributes.position.needsUpdate = true;
  }

  /** The arrow below a ball: as long as it is fast. */
  moveArrow(i, x, y, speed) {
    const r = this.radius, length = 2.6 * r * speed, shown = Math.abs(speed) > 0.004 ? 1 : 0, matrix = new THREE.Matrix4();
    matrix.makeScale(shown * length, shown, shown).setPosition(x + length / 2, y - 1.55 * r, 0);
    this.shafts.setMatrixAt(i, matrix);
    matrix.makeScale(shown * Math.sign(speed || 1), shown, shown).setPosition(x + length, y - 1.55 * r, 0);
    this.tips.setMatrixAt(i, matrix);
  }

  /** The eye's first place. */
  home() {
    this.turn = { azimuth: AZIMUTH, height: 0.22, distance: 1 };
  }

  listen() {
    const grips = new Map();
    this.canvas.addEventListener("pointerdown", (event) => { grips.set(event.pointerId, event); this.canvas.setPointerCapture(event.pointerId); });
    const release = (event) => grips.delete(event.pointerId);
    this.canvas.addEventListener("pointerup", release);
    this.canvas.addEventListener("pointercancel", release);
    this.canvas.addEventListener("pointermove", (event) => {
      const last = grips.get(event.pointerId);
      if (!last) return;
      this.turn.azimuth -= 0.006 * (event.clientX - last.clientX);
      this.turn.height = Math.min(1.45, Math.max(-0.25, this.turn.height + 0.006 * (event.clientY - last.clientY)));
      grips.set(event.pointerId, event);
      this.changed = true;
    });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.turn.distance = Math.min(6, Math.max(0.15, this.turn.distance * Math.exp(0.001 * event.deltaY)));
      this.changed = true;
    }, { passive: false });
    this.canvas.addEventListener("dblclick", () => { this.home(); this.changed = true; });
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas, size = `${width} ${height} ${this.resolution}`;
    if (size !== this.size) {
      this.size = size;
      this.renderer.setPixelRatio(this.resolution);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
    }
    const tall = this.hanging ? this.stringLength + 5 * this.radius : 6 * this.radius;
    const wide = Math.max(this.width, 2 * this.run.balls * this.radius + 0.8 * this.stringLength) + 4 * this.radius;
    const tangent = Math.tan(Math.PI / 12), across = Math.cos(AZIMUTH) / tangent / this.camera.aspect + Math.sin(AZIMUTH);
    const fit = Math.max(tall / 2 / tangent, wide / 2 * across);
    const { azimuth, height: up, distance } = this.turn, away = 1.12 * fit * distance;
    const centre = this.hanging ? 0.42 * this.stringLength - this.radius : 0;
    this.camera.position.set(away * Math.sin(azimuth) * Math.cos(up), centre + away * Math.sin(up), away * Math.cos(azimuth) * Math.cos(up));
    this.camera.lookAt(0, centre, 0);
    this.renderer.render(this.scene, this.camera);
  }
}
