/** Flying: the camera turns where it stands and moves where it looks, at a walker's pace. */

/** @typedef {import("./camera.js").Camera} Camera */

/** At speed 1: so many scene diagonals a second in what is small, fewer in what is vast, and between them a walk [m/s]. */
const SMALL_PACE = 0.12;
const VAST_PACE = 0.01;
const WALK = 2;
const FAST = 4;
/** Radians a second by the arrow keys. */
const TURN_PACE = 1.4;
/** Radians a CSS pixel of mouse travel. */
const LOOK_PACE = 0.0025;
const WHEEL_FACTOR = 1.2;
const SPEED_RANGE = 64;

/** Metres a second at speed 1. @param {number} size the scene's diagonal [m] */
export const paceIn = (size) => Math.min(SMALL_PACE * size, Math.max(WALK, VAST_PACE * size));

export class Fly {
  /** The user's factor on the pace, by the wheel. */
  speed = 1;
  #camera;

  /** @param {Camera} camera */
  constructor(camera) {
    this.#camera = camera;
  }

  /**
   * @param {import("./motion.js").Wish} motion seconds at full speed
   * @param {number} size the scene's diagonal [m]
   * @param {boolean} fast
   */
  walk(motion, size, fast) {
    const pace = paceIn(size) * this.speed * (fast ? FAST : 1);
    const [right, up, forward] = motion.move;
    this.#camera.turn(motion.turn[0] * TURN_PACE, motion.turn[1] * TURN_PACE);
    this.#camera.move(right * pace, 0, forward * pace);
    this.#camera.position[1] += up * pace;
  }

  /** A mouse turns the gaze along; a finger drags the scene. @param {number} dx @param {number} dy @param {boolean} touch */
  look(dx, dy, touch) {
    const pace = touch ? 2 * LOOK_PACE : -LOOK_PACE;
    this.#camera.turn(dx * pace, dy * pace);
  }

  /** Moves sideways with the pointer. @param {number} dx @param {number} dy in CSS pixels @param {number} unit world units a pixel */
  pan(dx, dy, unit) {
    this.#camera.move(-dx * unit, dy * unit, 0);
  }

  /** @param {number} steps notches towards the user: slower */
  wheel(steps) {
    const speed = this.speed * WHEEL_FACTOR ** -steps;
    this.speed = Math.min(SPEED_RANGE, Math.max(1 / SPEED_RANGE, speed));
  }

  /** @param {number} ratio of the fingers' distance @param {number} size the scene's diagonal [m] */
  pinch(ratio, size) {
    this.#camera.move(0, 0, Math.log(ratio) * paceIn(size) * 2);
  }
}
