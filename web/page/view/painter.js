// Draws things in space with WebGL, from back to front; their shaders define what they are.

import { sized } from "#view/common.js";
import { PROGRAMS, VERTEX } from "#view/steel.js";

const SLOW = 26; // ms between pictures after which they get fewer pixels
const UNSEEN = 1e-4; // radii, or px, by which what is drawn may change without being seen

export class Painter {
  constructor(gl) {
    Object.assign(this, { gl, things: [], sharp: 1, pace: 0, last: 0 });
    this.programs = Object.fromEntries(Object.entries(PROGRAMS).map(([kind, text]) => [kind, this.program(text)]));
    this.works = Object.values(this.programs).every(Boolean);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, gl.createBuffer());
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** A program with this fragment shader, and the location of a thing's numbers; null if it fails. */
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
    return { program, place: gl.getUniformLocation(program, "thing_") };
  }

  /** Adds a thing, in front of those farther away; the shaders define its vectors. */
  add(kind, far, a, b, c = [], d = [], e = []) {
    this.things.push({ kind, far, numbers: padded([a, b, c, d, e]) });
  }

  /** Draws what was added, unless it looks as it did, on a canvas of this size (px), with `ratio` pixels in one: fewer
   *  while it moves where that takes long. `known`: the vectors that all shaders know. */
  paint(known, clientWidth, clientHeight, ratio) {
    const { gl, drawn } = this, things = this.things.sort((a, b) => b.far - a.far);
    const all = (ratio) => padded([...known, [clientWidth, clientHeight, ratio]]);
    const now = [...all(ratio), ...things.flatMap(({ numbers }) => numbers)];
    const same = drawn?.length === now.length && now.every((number, k) => Math.abs(number - drawn[k]) < UNSEEN);
    this.things = [];
    if (same && this.ratio === ratio) return;
    if (!same) Object.assign(this, { drawn: now, sharp: this.sharpness() });
    this.ratio = same ? ratio : ratio * this.sharp;
    const { width, height } = sized(gl.canvas, clientWidth * this.ratio, clientHeight * this.ratio);
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.bufferData(gl.UNIFORM_BUFFER, new Float32Array(all(this.ratio)), gl.DYNAMIC_DRAW);
    for (const { kind, numbers } of things) {
      gl.useProgram(this.programs[kind].program);
      gl.uniform4fv(this.programs[kind].place, numbers);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
  }

  /** The part of the pixels of a moving picture, by the time (ms) between two pictures. */
  sharpness() {
    const now = performance.now();
    this.pace += 0.08 * (Math.min(60, now - this.last) - this.pace);
    this.last = now;
    if (this.pace < SLOW || this.sharp < 0.6) return this.sharp;
    this.pace = 0;
    return 0.8 * this.sharp;
  }
}

/** The numbers of vectors, four of each. */
function padded(vectors) { return vectors.flatMap((vector) => [0, 1, 2, 3].map((axis) => vector[axis] ?? 0)); }
