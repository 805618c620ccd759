// Draws things in space with WebGL, those behind first; what they are, their shaders say.

import { PROGRAMS, VERTEX } from "#view/steel.js";

const VECTORS = 4; // of a thing, each of four numbers
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
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    for (let k = 0; k < VECTORS; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribDivisor(k, 1);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** A program with this fragment shader; null where it does not come about. */
  program(fragment) {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
  }

  close() { this.gl.getExtension("WEBGL_lose_context")?.loseContext(); }

  /** Begins a picture. */
  begin() { Object.assign(this, { things: [], runs: [] }); }

  /** One more thing, in front of all before it: what its vectors are, the vertex shader says. `place`: 0 for where they
   *  say; 1 for mirrored in the base; IN_RECTANGLE of the picture. */
  add(kind, place, a, b = a, c = [], d = []) {
    const { things, runs } = this;
    if (runs.at(-1)?.kind !== kind) runs.push({ kind, first: things.length, count: 0 });
    runs.at(-1).count++;
    for (const vector of [a, [b[0], b[1], b[2], place], c, d]) for (let k = 0; k < 4; k++) things.push(vector[k] ?? 0);
  }

  /** Ends it; whether it can be seen to differ from the last one. `space`: what shaders want to know. */
  finish(space) {
    const last = this.drawn;
    this.drawn = [...this.things, ...space].map((value) => value.toFixed(4)).join();
    this.space = space;
    return this.drawn !== last;
  }

  /** Draws all things on a canvas of this size (px), with `ratio` pixels in one. */
  paint(clientWidth, clientHeight, ratio) {
    const { gl, runs, things, space } = this, { canvas } = gl;
    const width = Math.round(clientWidth * ratio), height = Math.round(clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const known = new Float32Array([...space, clientWidth, clientHeight, ratio, 0]);
    gl.bufferData(gl.UNIFORM_BUFFER, known, gl.DYNAMIC_DRAW);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(things), gl.DYNAMIC_DRAW);
    for (const { kind, first, count } of runs) {
      gl.useProgram(this.programs[kind]);
      for (let k = 0; k < VECTORS; k++)
        gl.vertexAttribPointer(k, 4, gl.FLOAT, false, 16 * VECTORS, 4 * (first + 4 * k));
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    }
  }
}
