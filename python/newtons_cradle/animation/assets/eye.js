// Where the eye is. It aims at the balls, and never comes so close that one of them is cut off.

const AZIMUTH = 0.28, HEIGHT = 0.2; // rad, where the eye is at first
const OPENING = Math.PI / 6;        // rad, from the lower to the upper edge of the picture
const GLIDE = 1;                    // s on the viewer's clock to the close-up of a click and back
const AIR = 1.08;                   // how much wider than what must be seen

class Eye {
  constructor(canvas) {
    this.canvas = canvas;
    this.camera = new THREE.PerspectiveCamera(180 * OPENING / Math.PI, 1, 1, 10);
    this.close = 0; // 0 to 1, part of the way to the close-up
    this.home();
    this.listen();
  }

  /** The first view: all of the cradle. */
  home() {
    Object.assign(this, { azimuth: AZIMUTH, height: HEIGHT, zoom: 1, changed: true });
  }

  turn(right, up) {
    this.azimuth -= right;
    this.height = Math.min(1.45, Math.max(-0.25, this.height + up));
    this.changed = true;
  }

  /** Factor < 1 comes closer. `zoom` is 0 where the balls fill the picture, 1 where all of the cradle is seen. */
  approach(factor) {
    this.zoom = Math.min(2, Math.max(0, this.zoom + 0.7 * Math.log(factor)));
    this.changed = true;
  }

  /** Glides to the close-up or back, for `seconds` of the viewer's. */
  glide(wanted, seconds) {
    if (this.close === wanted) return;
    const step = STILL.matches ? 1 : seconds / GLIDE;
    this.close = wanted > this.close ? Math.min(wanted, this.close + step) : Math.max(wanted, this.close - step);
    this.changed = true;
  }

  /** Puts the camera where it belongs, given what must be seen: boxes {low, high} of all, of the balls' paths, and of
   *  the balls now. */
  place(whole, paths, now) {
    const { camera } = this, all = this.view(whole), near = this.view(paths), closest = this.view(now);
    const further = Math.max(all.distance, near.distance);
    const wanted = near.distance * (further / near.distance) ** this.zoom;
    // Views between two that show the balls show them as well, as centre and distance go the same part of the way.
    const part = Math.min(1, (wanted - near.distance) / (further - near.distance || 1));
    const eased = this.close * this.close * (3 - 2 * this.close);
    const centre = near.centre.lerp(all.centre, part).lerp(closest.centre, eased);
    const distance = this.distance = wanted + eased * (closest.distance - wanted);
    camera.near = 0.02 * distance;
    camera.far = 20 * further + distance;
    camera.position.copy(this.towards).multiplyScalar(distance).add(centre);
    camera.lookAt(centre);
    camera.updateProjectionMatrix();
  }

  /** The centre of a box, and the distance from which all its corners are seen. */
  view({ low, high }) {
    const { azimuth, camera } = this, centre = low.clone().add(high).multiplyScalar(0.5), up = Math.tan(OPENING / 2);
    const across = up * camera.aspect;
    const towards = this.towards, right = new THREE.Vector3(Math.cos(azimuth), 0, -Math.sin(azimuth));
    const top = towards.clone().cross(right);
    const distances = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => {
      const corner = new THREE.Vector3(k & 1 ? low.x : high.x, k & 2 ? low.y : high.y, k & 4 ? low.z : high.z)
        .sub(centre);
      return corner.dot(towards) + AIR * Math.max(Math.abs(corner.dot(right)) / across, Math.abs(corner.dot(top)) / up);
    });
    return { centre, distance: Math.max(0, ...distances) };
  }

  /** From what is seen to the eye. */
  get towards() {
    const { azimuth, height } = this;
    return new THREE.Vector3(Math.sin(azimuth) * Math.cos(height), Math.sin(height),
      Math.cos(azimuth) * Math.cos(height));
  }

  /** Dragging and arrow keys turn, two fingers, wheel, + and - come closer, 0 and double clicks go home. */
  listen() {
    const { canvas } = this, grips = new Map(), spread = () => {
      const [a, b] = grips.values();
      return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
    };
    canvas.onpointerdown = (event) => { grips.set(event.pointerId, event); canvas.setPointerCapture(event.pointerId); };
    canvas.onpointerup = canvas.onpointercancel = ({ pointerId }) => grips.delete(pointerId);
    canvas.onpointermove = (event) => {
      const last = grips.get(event.pointerId), before = grips.size === 2 ? spread() : 0;
      if (!last) return;
      grips.set(event.pointerId, event);
      if (before) this.approach(before / Math.max(1, spread()));
      else this.turn(0.006 * (event.clientX - last.clientX), 0.006 * (event.clientY - last.clientY));
    };
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.approach(Math.exp(0.001 * event.deltaY));
    }, { passive: false });
    canvas.ondblclick = () => this.home();
  }
}
