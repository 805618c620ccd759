// Draws things in space with WebGL, those behind first; what they are, their shaders say.

import { PROGRAMS, VERTEX } from "#view/steel.js";

const NAMES = ["A", "B", "C", "D"]; // of a thing's vectors in the shaders
const SLOW = 26; // ms between pictures after which they get fewer pixels
const UNSEEN = 1e-4; // radii, or px, by which what is drawn may change without being seen
export const IN_RECTANGLE = 2;

export class Painter {
  /** Draws on a canvas; null where there is no WebGL 2. */
  static open(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, depth: false, preserveDrawingBuffer: true });
    const painter = gl && new Painter(gl);
    return painter && Object.values(painter.programs).every(Boolean) ? painter : null;
  }

  constructor(gl) {
    Object.assign(this, { gl, things: [], sharp: 1, pace: 0, last: 0 });
    this.programs = Object.fromEntries(Object.entries(PROGRAMS).map(([kind, text]) => [kind, this.program(text)]));
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, gl.createBuffer());
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** A program with this fragment shader, and where it has a thing's vectors; null where it does not come about. */
  program(fragment) {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    return { program, vectors: NAMES.map((name) => gl.getUniformLocation(program, name)) };
  }

  close() { this.gl.getExtension("WEBGL_lose_context")?.loseContext(); }

  /** One more thing, in front of all before it; what its vectors are, the shaders say. `place`: 0 for where these say,
   *  1 for mirrored in the base, IN_RECTANGLE of the picture. */
  add(kind, place, a, b = a, c = [], d = []) {
    const vectors = [a, [b[0], b[1], b[2], place], c, d].map((vector) => [0, 1, 2, 3].map((k) => vector[k] ?? 0));
    this.things.push({ kind, vectors });
  }

  /** Draws what was added, unless it looks as it did, on a canvas of this size (px), with `ratio` pixels in one: fewer
   *  while it moves where that takes long. `space`: what shaders want to know. */
  paint(space, clientWidth, clientHeight, ratio) {
    const { gl, things, drawn } = this, { canvas } = gl;
    const numbers = [...space, clientWidth, clientHeight, ratio, ...things.flatMap(({ vectors }) => vectors.flat())];
    const same = drawn?.length === numbers.length && numbers.every((k, i) => Math.abs(k - drawn[i]) < UNSEEN);
    this.things = [];
    if (same && this.ratio === ratio) return;
    if (!same) Object.assign(this, { drawn: numbers, sharp: this.sharpness() });
    this.ratio = same ? ratio : ratio * this.sharp;
    const width = Math.round(clientWidth * this.ratio), height = Math.round(clientHeight * this.ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const known = new Float32Array([...space, clientWidth, clientHeight, this.ratio, 0]);
    gl.bufferData(gl.UNIFORM_BUFFER, known, gl.DYNAMIC_DRAW);
    for (const { kind, vectors } of things) {
      const { program, vectors: places } = this.programs[kind];
      gl.useProgram(program);
      vectors.forEach((vector, k) => gl.uniform4fv(places[k], vector));
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
  }

  /** The part of its pixels that a moving picture gets, by the time (ms) that passes from one to the next. */
  sharpness() {
    const now = performance.now();
    this.pace += 0.08 * (Math.min(60, now - this.last) - this.pace);
    this.last = now;
    if (this.pace < SLOW || this.sharp < 0.6) return this.sharp;
    this.pace = 0;
    return 0.8 * this.sharp;
  }
}
