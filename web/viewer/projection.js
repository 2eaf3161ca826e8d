/** Where points of the world are on the page, and back: a camera's view as CSS pixels of its canvas. */

import { add, dot, scale } from "./camera.js";

/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {{x: number, y: number}} Point  CSS pixels from the canvas's top left */
/** @typedef {{from: Vec3, along: Vec3}} Ray  along: unit length */
/** @typedef {{yfov: number, near: number, width: number, height: number}} Lens  yfov: vertical field of view [rad]; near [m]; the canvas [CSS px] */

/** Nearest that a line is drawn to the camera, of its distance at 1 px a pixel: what is nearer has no place. */
const LEAST_DEPTH = 1e-6;
/** Sine of the angle between a ray and an axis below which a pixel would be a long way along the axis. */
const LEAST_SINE = 0.05;

export class Projection {
  #camera;
  #axes;
  #lens;
  #unit;

  /** @param {import("./camera.js").Camera} camera @param {Lens} lens */
  constructor(camera, lens) {
    this.#camera = camera.position;
    this.#axes = camera.axes();
    this.#lens = lens;
    this.#unit = (2 * Math.tan(lens.yfov / 2)) / Math.max(lens.height, 1);
  }

  /** Metres a CSS pixel at a point, which is in front of the camera. @param {Vec3} point */
  pixelAt(point) {
    return this.#unit * Math.max(this.#depth(this.#seen(point)), LEAST_DEPTH);
  }

  /** Where a point is; null for one behind the camera, or nearer than what is shown. @param {Vec3} point @returns {Point | null} */
  point(point) {
    const seen = this.#seen(point);
    return this.#depth(seen) >= this.#least ? this.#place(seen) : null;
  }

  /** The part of a line that is in front of the camera. @param {Vec3} a @param {Vec3} b @returns {[Point, Point] | null} */
  line(a, b) {
    let [start, end] = [this.#seen(a), this.#seen(b)];
    const [first, last] = [this.#depth(start) - this.#least, this.#depth(end) - this.#least];
    if (first < 0 && last < 0) return null;
    const cut = add(start, scale(add(end, scale(start, -1)), first / (first - last)));
    if (first < 0) start = cut;
    if (last < 0) end = cut;
    return [this.#place(start), this.#place(end)];
  }

  /** What is seen at a place of the canvas. @param {Point} point @returns {Ray} */
  ray({ x, y }) {
    const { right, up, back } = this.#axes;
    const aside = add(scale(right, this.#unit * (x - this.#lens.width / 2)), scale(up, this.#unit * (this.#lens.height / 2 - y)));
    const along = add(aside, scale(back, -1));
    return { from: this.#camera, along: scale(along, 1 / Math.hypot(...along)) };
  }

  /** The unit vector from the camera to a point. @param {Vec3} point @returns {Vec3} */
  towards(point) {
    const offset = add(point, scale(this.#camera, -1));
    return scale(offset, 1 / Math.max(Math.hypot(...offset), LEAST_DEPTH));
  }

  /** A point for what has no place of its own: above the middle of the picture, where no sheet of a phone is. @returns {Vec3} */
  ahead() {
    const { from, along } = this.ray({ x: this.#lens.width / 2, y: this.#lens.height / 3 });
    return add(from, scale(along, Math.max(1, 2 * this.#least)));
  }

  get #least() {
    return Math.max(this.#lens.near, LEAST_DEPTH);
  }

  /** A point by the camera's axes: right, up, back. @param {Vec3} point @returns {Vec3} */
  #seen(point) {
    const offset = add(point, scale(this.#camera, -1));
    return [dot(offset, this.#axes.right), dot(offset, this.#axes.up), dot(offset, this.#axes.back)];
  }

  /** @param {Vec3} seen */
  #depth(seen) {
    return -seen[2];
  }

  /** @param {Vec3} seen @returns {Point} */
  #place([right, up, back]) {
    const pixels = 1 / (this.#unit * -back);
    return { x: this.#lens.width / 2 + right * pixels, y: this.#lens.height / 2 - up * pixels };
  }
}

/**
 * How far along an axis through `at` the point is that a ray passes nearest to [m]; null where it runs along the axis,
 * so that nothing can be told.
 * @param {Ray} ray @param {Vec3} at @param {Vec3} axis unit length @returns {number | null}
 */
export function alongAxis(ray, at, axis) {
  const between = add(at, scale(ray.from, -1));
  const cosine = dot(ray.along, axis);
  const square = 1 - cosine * cosine; // of the sine
  if (square < LEAST_SINE ** 2) return null;
  return (cosine * dot(ray.along, between) - dot(axis, between)) / square;
}

/** How far from a point a ray passes [m]. @param {Ray} ray @param {Vec3} at */
export function besides(ray, at) {
  const between = add(at, scale(ray.from, -1));
  return Math.hypot(...add(between, scale(ray.along, -dot(ray.along, between))));
}

/**
 * The angle about an axis of the world of the point that a ray holds of a ball around `at`: where it meets the ball, or
 * passes nearest to it [rad].
 * @param {Ray} ray @param {Vec3} at @param {0 | 1 | 2} axis @param {number} radius [m] @returns {number}
 */
export function aroundAxis(ray, at, axis, radius) {
  const between = add(at, scale(ray.from, -1));
  const nearest = dot(ray.along, between);
  const square = dot(between, between) - nearest * nearest; // of the distance that it passes at
  const far = nearest - Math.sqrt(Math.max(radius * radius - square, 0));
  const held = add(scale(ray.along, far), scale(between, -1));
  const [u, v] = /** @type {const} */ ([[1, 2], [2, 0], [0, 1]])[axis];
  return Math.atan2(held[v], held[u]);
}
