/** Orbiting: the camera turns about a pivot straight ahead of it, nears it, and carries it along sideways. */

/** @typedef {import("./camera.js").Camera} Camera */

/** Radians a CSS pixel of pointer travel. */
const DRAG_PACE = 0.006;
/** Radians a second by the arrow keys. */
const TURN_PACE = 1.4;
/** Of the distance: e-folds a second by the keys, factor a notch by the wheel. */
const DOLLY_PACE = 1.2;
const WHEEL_FACTOR = 1.12;
const PAN_PACE = 0.8;
const FAST = 3;

export class Orbit {
  /** From the camera to the pivot. */
  distance = 1;
  /** The nearest that the camera comes to the pivot; set with the scene. */
  nearest = 1e-3;
  #camera;

  /** @param {Camera} camera */
  constructor(camera) {
    this.#camera = camera;
  }

  /** @param {import("./motion.js").Wish} motion seconds at full speed @param {boolean} fast */
  walk(motion, fast) {
    const pace = fast ? FAST : 1;
    const [right, up, forward] = motion.move;
    this.#camera.orbit(this.distance, -motion.turn[0] * TURN_PACE, -motion.turn[1] * TURN_PACE);
    this.#camera.move(right * this.distance * PAN_PACE * pace, up * this.distance * PAN_PACE * pace, 0);
    this.dolly(Math.exp(-forward * DOLLY_PACE * pace));
  }

  /** @param {number} dx @param {number} dy in CSS pixels */
  drag(dx, dy) {
    this.#camera.orbit(this.distance, -dx * DRAG_PACE, -dy * DRAG_PACE);
  }

  /** The pivot stays under the pointer. @param {number} dx @param {number} dy in CSS pixels @param {number} unit world units a pixel */
  pan(dx, dy, unit) {
    this.#camera.move(-dx * unit, dy * unit, 0);
  }

  /** @param {number} steps notches towards the user: farther */
  wheel(steps) {
    this.dolly(WHEEL_FACTOR ** steps);
  }

  /** @param {number} factor on the distance to the pivot, which stays put */
  dolly(factor) {
    const wanted = Math.max(this.nearest, this.distance * factor);
    this.#camera.move(0, 0, this.distance - wanted);
    this.distance = wanted;
  }
}
