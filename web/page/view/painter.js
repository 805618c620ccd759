// Draws things in space with WebGL, those behind first; what they are, their shaders say.

import { PROGRAMS } from "#view/steel.js";

const FLOATS = 13;   // of a thing: three vectors, and whether it is mirrored
const UNSEEN = 3e-5; // part by which what is drawn may change without being seen

export class Painter {
  /** Draws on a canvas; null where there is no WebGL 2. */
  static open(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, depth: false, preserveDrawingBuffer: true });
    const painter = gl && new Painter(gl);
    return painter && Object.values(painter.programs).every(Boolean) ? painter : null;
  }

  constructor(gl) {
    this.gl = gl;
    this.programs = Object.fromEntries(Object.entries(PROGRAMS).map(([kind, texts]) => [kind, this.program(texts)]));
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, gl.createBuffer());
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    for (let k = 0; k < 4; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribDivisor(k, 1);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** A program of two shaders; null where it does not come about. */
  program(texts) {
    const { gl } = this, program = gl.createProgram();
    texts.forEach((text, k) => {
      const shader = gl.createShader([gl.VERTEX_SHADER, gl.FRAGMENT_SHADER][k]);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    gl.uniformBlockBinding(program, gl.getUniformBlockIndex(program, "Space"), 0);
    return program;
  }

  close() { this.gl.getExtension("WEBGL_lose_context")?.loseContext(); }

  /** Begins a picture. */
  begin() { Object.assign(this, { things: [], runs: [] }); }

  /** One more thing, in front of all before it. */
  add(kind, a, b = [], c = [], mirrored = 0) {
    const { things, runs } = this;
    if (runs.at(-1)?.kind !== kind) runs.push({ kind, first: things.length / FLOATS, count: 0 });
    runs.at(-1).count++;
    for (const vector of [a, b, c]) for (let k = 0; k < 4; k++) things.push(vector[k] ?? 0);
    things.push(mirrored);
  }

  /** Ends it; whether it looks otherwise than the last one. `space`: what shaders want to know, as vectors. */
  finish(space) {
    const { drawn: last, things } = this, now = { things, space: space.flat() };
    const same = (a, b) =>
      a.length === b.length && a.every((value, k) => Math.abs(value - b[k]) <= UNSEEN * Math.max(1, Math.abs(value)));
    if (last && same(last.things, now.things) && same(last.space, now.space)) return false;
    this.drawn = now;
    return true;
  }

  /** Draws all things on a canvas of this size (px), with `ratio` pixels in one. */
  paint(clientWidth, clientHeight, ratio) {
    const { gl, runs, drawn: { things, space } } = this, { canvas } = gl;
    const width = Math.round(clientWidth * ratio), height = Math.round(clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const known = new Float32Array([...space, clientWidth, clientHeight, ratio, 0]);
    gl.bufferData(gl.UNIFORM_BUFFER, known, gl.DYNAMIC_DRAW);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(things), gl.DYNAMIC_DRAW);
    for (const { kind, first, count } of runs) {
      gl.useProgram(this.programs[kind]);
      for (let k = 0; k < 4; k++)
        gl.vertexAttribPointer(k, k < 3 ? 4 : 1, gl.FLOAT, false, 4 * FLOATS, 4 * (FLOATS * first + 4 * k));
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    }
  }
}
