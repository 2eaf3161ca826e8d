/**
 * The viewer's camera: a position, a heading and a pitch about the world's up (+Y), as in glTF: it looks along −Z.
 * Angles are radians; positions are metres of the world.
 */

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {{right: Vec3, up: Vec3, back: Vec3}} Axes */
/** @typedef {{at: Vec3, look: [number, number]}} Place  position; yaw and pitch */

/** Closest that the gaze comes to straight up or down; beyond it left and right would swap. */
export const MAX_PITCH = Math.PI / 2 - 0.01;

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

/** @param {Vec3} a @param {number} s @returns {Vec3} */
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];

/** @param {Vec3} a @param {Vec3} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @param {Vec3} a @param {Vec3} b */
export const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

export class Camera {
  /** @type {Vec3} */
  position = [0, 0, 0];
  /** Counter-clockwise about +Y; 0 looks along −Z. */
  yaw = 0;
  /** Above the horizon. */
  pitch = 0;

  /**
   * Takes the place and gaze of a matrix; a roll about the gaze is levelled.
   * @param {readonly number[]} toWorld 16 numbers, column-major, camera to world
   */
  setMatrix(toWorld) {
    const [backX = 0, backY = 0, backZ = 1] = toWorld.slice(8, 11);
    const [x = 0, y = 0, z = 0] = toWorld.slice(12, 15);
    const level = Math.hypot(backX, backZ);
    if (level > 1e-6 * Math.abs(backY)) {
      this.yaw = Math.atan2(backX, backZ);
    } else {
      // Straight up or down: the heading is where the top of the picture points (or its opposite).
      const [upX = 0, , upZ = 1] = toWorld.slice(4, 7);
      const sign = Math.sign(backY);
      this.yaw = Math.atan2(-sign * upX, -sign * upZ);
    }
    this.pitch = clampPitch(Math.atan2(-backY, level));
    this.position = [x, y, z];
  }

  /** @returns {Place} */
  get place() {
    return { at: this.position, look: [this.yaw, this.pitch] };
  }

  /** @param {Place} place */
  set place({ at, look: [yaw, pitch] }) {
    this.position = at;
    this.yaw = wrapAngle(yaw);
    this.pitch = clampPitch(pitch);
  }

  /** @returns {number[]} 16 numbers, column-major, camera to world */
  matrix() {
    const { right, up, back } = this.axes();
    return [...right, 0, ...up, 0, ...back, 0, ...this.position, 1];
  }

  /** @returns {Axes} unit vectors of the camera in the world */
  axes() {
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    return { right: [cy, 0, -sy], up: [sy * sp, cp, cy * sp], back: [sy * cp, -sp, cy * cp] };
  }

  /** Turns the gaze where the camera stands. @param {number} yaw @param {number} pitch */
  turn(yaw, pitch) {
    this.yaw = wrapAngle(this.yaw + yaw);
    this.pitch = clampPitch(this.pitch + pitch);
  }

  /**
   * Moves along the camera's own axes.
   * @param {number} right @param {number} up @param {number} forward
   */
  move(right, up, forward) {
    const axes = this.axes();
    const step = add(add(scale(axes.right, right), scale(axes.up, up)), scale(axes.back, -forward));
    this.position = add(this.position, step);
  }

  /** The point straight ahead. @param {number} distance @returns {Vec3} */
  ahead(distance) {
    return add(this.position, scale(this.axes().back, -distance));
  }

  /** Turns about the point straight ahead, which stays put. @param {number} distance @param {number} yaw @param {number} pitch */
  orbit(distance, yaw, pitch) {
    const pivot = this.ahead(distance);
    this.turn(yaw, pitch);
    this.position = add(pivot, scale(this.axes().back, distance));
  }
}

/** @param {number} pitch */
const clampPitch = (pitch) => Math.min(MAX_PITCH, Math.max(-MAX_PITCH, pitch));

/** Into (−π, π], so that a long walk loses no precision. @param {number} angle */
function wrapAngle(angle) {
  const turn = 2 * Math.PI;
  const wrapped = angle - turn * Math.floor(angle / turn);
  return wrapped > Math.PI ? wrapped - turn : wrapped;
}
