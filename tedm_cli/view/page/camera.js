"use strict";
// Where one looks from, and how mouse, fingers and keys change it.
class Camera {
  /** `centre` and `radius` (m) of a ball around all that is drawn. */
  constructor(centre, radius, changed) {
    this.home = centre;
    this.radius = radius;
    this.changed = changed;
    this.look("iso");
  }

  look(from) {
    const d = Math.PI / 180;
    const [yaw, pitch] = { iso: [-52 * d, 28 * d], x: [0, 0], y: [-90 * d, 0], z: [-90 * d, 90 * d] }[from];
    Object.assign(this, { yaw, pitch, distance: 4.0 * this.radius, target: [...this.home] });
    this.changed();
  }

  turn(right, up) {
    this.yaw -= right;
    this.pitch = Math.min(Math.max(this.pitch + up, -Math.PI / 2), Math.PI / 2);
    this.changed();
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance / factor, 0.15 * this.radius), 20 * this.radius);
    this.changed();
  }

  /** By parts of the height of the picture. */
  shift(right, up) {
    const span = 2 * this.distance * Math.tan(Camera.HALF);
    const [r, u] = this.axes();
    this.target = this.target.map((t, c) => t - span * (right * r[c] + up * u[c]));
    this.changed();
  }

  /** Unit vectors to the right, up, and towards the eye. */
  axes() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    return [[-sy, cy, 0], [-cy * sp, -sy * sp, cp], [cy * cp, sy * cp, sp]];
  }

  /** Basic frame to clip space, column by column, for a picture of this width over height. */
  matrix(aspect) {
    const [r, u, b] = this.axes();
    const eye = this.target.map((t, c) => t + this.distance * b[c]);
    const dot = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    // Narrow pictures are fitted by their width.
    const f = (1 / Math.tan(Camera.HALF)) * Math.min(1, aspect / 1.15);
    const near = Math.max(this.distance - 3 * this.radius, 0.02 * this.distance);
    const far = this.distance + 4 * this.radius;
    const [a, c] = [(far + near) / (near - far), (2 * far * near) / (near - far)];
    const rows = [
      [...r, dot(r)].map((v) => (v * f) / aspect),
      [...u, dot(u)].map((v) => v * f),
      [...b.map((v) => v * a), dot(b) * a + c],
      [...b.map((v) => -v), -dot(b)],
    ];
    return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
  }

  /** Let an element turn, move and zoom the view. `tap(x, y)` is called for a click that was no drag. */
  follow(element, tap) {
    const fingers = new Map();
    let moved = 0;
    element.addEventListener("pointerdown", (e) => {
      element.setPointerCapture(e.pointerId);
      fingers.set(e.pointerId, e);
      if (fingers.size === 1) moved = 0;
    });
    element.addEventListener("pointermove", (e) => {
      const before = fingers.get(e.pointerId);
      if (!before) return;
      const [dx, dy] = [e.clientX - before.clientX, e.clientY - before.clientY];
      moved += Math.abs(dx) + Math.abs(dy);
      const height = element.clientHeight;
      if (fingers.size === 2) {
        const other = [...fingers.entries()].find(([id]) => id !== e.pointerId)[1];
        const span = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
        if (span(before) > 0) this.zoom(span(e) / span(before));
        this.shift(dx / 2 / height, -dy / 2 / height);
      } else if (e.shiftKey || before.buttons === 2 || before.buttons === 4) {
        this.shift(dx / height, -dy / height);
      } else {
        this.turn((3 * dx) / height, (3 * dy) / height);
      }
      fingers.set(e.pointerId, e);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      element.addEventListener(end, (e) => {
        if (end === "pointerup" && fingers.size === 1 && moved < 5) tap(e.offsetX, e.offsetY);
        fingers.delete(e.pointerId);
      });
    }
    element.addEventListener("contextmenu", (e) => e.preventDefault());
    element.addEventListener(
      "wheel",
      (e) => {
        e.preventDefault();
        this.zoom(Math.exp(-e.deltaY * (e.deltaMode === 1 ? 0.05 : 0.0015)));
      },
      { passive: false },
    );
    element.addEventListener("keydown", (e) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
      if (e.ctrlKey || e.altKey || e.metaKey) return;
      if (way && e.shiftKey) this.shift(0.05 * way[0], 0.05 * way[1]);
      else if (way) this.turn(0.12 * way[0], 0.12 * way[1]);
      else if (e.key === "+" || e.key === "=") this.zoom(1.15);
      else if (e.key === "-") this.zoom(1 / 1.15);
      else if (e.key === "0") this.look("iso");
      else if ("xyz".includes(e.key)) this.look(e.key);
      else return;
      e.preventDefault();
    });
  }
}
Camera.HALF = (13 * Math.PI) / 180; // half of the angle of view
