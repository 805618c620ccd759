// Where the viewer's eye is, and what it sees of the space around the cradle: x to the right, y up, z towards the
// viewer, in radii of a ball; the origin is the middle of the balls at rest.

/** Ready views, by how far the eye is to the right and how high (rad). */
const VIEWS = { front: { azimuth: -0.24, height: 0.17 }, side: { azimuth: -1.42, height: 0.34 },
  top: { azimuth: 0, height: 1.45 } };
const LOWEST = 0.03, HIGHEST = 1.5; // rad; the floor is never seen from below

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const plus = (a, b, times = 1) => a.map((part, axis) => part + times * b[axis]);
export const minus = (a, b) => plus(a, b, -1);

/** The corners of a box with the origin between its sides. */
export function box(x, low, high, z) {
  return [-x, x].flatMap((a) => [low, high].flatMap((b) => [-z, z].map((c) => [a, b, c])));
}

export class Eye {
  constructor() { Object.assign(this, VIEWS.front, { wanted: VIEWS.front, view: "front" }); }

  /** The ready view after this one. */
  get next() {
    const views = Object.keys(VIEWS);
    return views[(views.indexOf(this.view) + 1) % views.length];
  }

  /** Goes to this ready view or, without a name, to the next one, the short way round. */
  look(view = this.next) {
    const { azimuth, height } = VIEWS[view], turns = Math.round((this.azimuth - azimuth) / (2 * Math.PI));
    Object.assign(this, { view, wanted: { azimuth: azimuth + 2 * Math.PI * turns, height } });
  }

  /** Turned by hand (rad). */
  turn(right, up) {
    const wanted = { azimuth: this.azimuth - right, height: Math.min(HIGHEST, Math.max(LOWEST, this.height + up)) };
    Object.assign(this, wanted, { wanted, view: "free" });
  }

  /** Moves a part of the way to the target; `still`: there at once. */
  glide(still) {
    for (const angle of ["azimuth", "height"]) {
      const away = this.wanted[angle] - this[angle];
      this[angle] += still || Math.abs(away) < 1e-3 ? away : 0.12 * away;
    }
  }

  /** Unit vectors to the right, up and towards the eye. */
  get axes() {
    const { azimuth, height } = this;
    const [s, c, high, flat] = [Math.sin(azimuth), Math.cos(azimuth), Math.sin(height), Math.cos(height)];
    return [[c, 0, -s], [-s * high, flat, -c * high], [s * flat, high, c * flat]];
  }
}

/** How the eye's picture lies on a canvas: `focal` length and `x`, `y` of the origin (px), `distance` of the eye. */
export class Lens {
  constructor(axes, distance) { Object.assign(this, { axes, distance, focal: 1, x: 0, y: 0 }); }

  /** Where the eye is. */
  get eye() { return this.axes[2].map((part) => part * this.distance); }

  /** Where a point, `at`, is on the canvas, and how many pixels a radius is there, `unit`. */
  place(at) {
    const [right, up, towards] = this.axes, unit = this.focal / (this.distance - dot(at, towards));
    return { at, x: this.x + unit * dot(at, right), y: this.y - unit * dot(at, up), unit };
  }

  /** The rectangle on the canvas around these points: left, top, right, bottom. */
  bounds(points) {
    const places = points.map((point) => this.place(point)), x = places.map((at) => at.x), y = places.map((at) => at.y);
    return [Math.min(...x), Math.min(...y), Math.max(...x), Math.max(...y)];
  }

  /** Shows `part`, a rectangle of its picture, as large as it fits onto a canvas of this size with a margin, but no
   *  larger than `most` px for a radius; where there is room, the middle of `all` is in the middle. */
  fit(part, all, width, height, margin, most) {
    const [left, top, right, bottom] = part, [wide, tall] = [width - 2 * margin, height - 2 * margin];
    const focal = Math.min(wide / (right - left), tall / (bottom - top), most * this.distance);
    const origin = (size, k) => Math.max(margin - focal * part[k],
      Math.min(size - margin - focal * part[k + 2], 0.5 * (size - focal * (all[k] + all[k + 2]))));
    Object.assign(this, { focal, x: origin(width, 0), y: origin(height, 1) });
  }
}
