// Draws things in space with WebGL, those behind first; what they are, their shaders say.

import { PROGRAMS, VERTEX } from "#view/steel.js";

const NAMES = ["A", "B", "C", "D"]; // of a thing's vectors in the shaders
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
    this.gl = gl;
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

  /** Begins a picture. */
  begin() { this.things = []; }

  /** One more thing, in front of all before it; what its vectors are, the shaders say. `place`: 0 for where these say,
   *  1 for mirrored in the base, IN_RECTANGLE of the picture. */
  add(kind, place, a, b = a, c = [], d = []) {
    const vectors = [a, [b[0], b[1], b[2], place], c, d].map((vector) => [0, 1, 2, 3].map((k) => vector[k] ?? 0));
    this.things.push({ kind, vectors });
  }

  /** Ends it; whether it can be seen to differ from the last one that did. `space`: what shaders want to know. */
  finish(space) {
    const numbers = [...space, ...this.things.flatMap(({ vectors }) => vectors.flat())], { drawn } = this;
    this.space = space;
    const same = drawn?.length === numbers.length && numbers.every((k, i) => Math.abs(k - drawn[i]) < UNSEEN);
    if (!same) this.drawn = numbers;
    return !same;
  }

  /** Draws all things on a canvas of this size (px), with `ratio` pixels in one. */
  paint(clientWidth, clientHeight, ratio) {
    const { gl, things, space } = this, { canvas } = gl;
    const width = Math.round(clientWidth * ratio), height = Math.round(clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const known = new Float32Array([...space, clientWidth, clientHeight, ratio, 0]);
    gl.bufferData(gl.UNIFORM_BUFFER, known, gl.DYNAMIC_DRAW);
    for (const { kind, vectors } of things) {
      const { program, vectors: places } = this.programs[kind];
      gl.useProgram(program);
      vectors.forEach((vector, k) => gl.uniform4fv(places[k], vector));
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
  }
}
