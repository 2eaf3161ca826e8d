/** How objects and lights are moved: steps that suit a scene, and places that objects can have in it. */

/** @typedef {import("./messages.js").Bounds} Bounds */
/** @typedef {[number, number, number]} Vec3 */

/** Of a scene's diagonal, about what a step is. */
const STEP_SHARE = 0.01;
/** As the server has them: how many times as large an object can be. */
const LEAST_SCALE = 0.1;
const MOST_SCALE = 10;

/** A step for a scene so large: 1, 2 or 5 times a power of ten [m]. @param {number} diagonal [m] */
export function stepIn(diagonal) {
  const about = Math.max(diagonal, 1e-9) * STEP_SHARE;
  const power = 10 ** Math.floor(Math.log10(about));
  const digit = [5, 2].find((one) => one * power <= about * 1.0001) ?? 1;
  return Number((digit * power).toPrecision(1));
}

/** The middle of a box. @param {Bounds} box @returns {Vec3} */
export const middleOf = ({ min, max }) => [(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, (min[2] + max[2]) / 2];

/** A box that is made so many times as large about its middle. @param {Bounds} box @param {number} scale @returns {Bounds} */
export function scaled(box, scale) {
  const middle = middleOf(box);
  const corner = (/** @type {Vec3} */ at) => /** @type {Vec3} */ (at.map((value, axis) => (middle[axis] ?? 0) + scale * (value - (middle[axis] ?? 0))));
  return { min: corner(box.min), max: corner(box.max) };
}

/**
 * The scale nearest to `wanted` that an object can have whose box, which is moved by `offset`, stays within a scene's
 * bounds, as the server demands.
 * @param {Bounds} box as the file has it @param {Bounds} bounds @param {Vec3} offset @param {number} wanted
 */
export function scaleWithin(box, bounds, offset, wanted) {
  const middle = sum(middleOf(box), offset);
  const room = middle.map((at, axis) => {
    const half = ((box.max[axis] ?? 0) - (box.min[axis] ?? 0)) / 2;
    return half > 0 ? Math.min(at - (bounds.min[axis] ?? at), (bounds.max[axis] ?? at) - at) / half : MOST_SCALE;
  });
  return rounded(Math.max(Math.min(wanted, MOST_SCALE, ...room), LEAST_SCALE), 1);
}

/**
 * The offset nearest to `wanted` with which a box stays within a scene's bounds, as the server demands. What is not
 * within them, as it is far away, stays.
 * @param {Bounds} box as the file has it @param {Bounds} bounds @param {Vec3} wanted @returns {Vec3}
 */
export function offsetWithin(box, bounds, wanted) {
  const size = Math.max(bounds.max[0] - bounds.min[0], bounds.max[1] - bounds.min[1], bounds.max[2] - bounds.min[2]);
  const clamp = (/** @type {0 | 1 | 2} */ axis) => {
    const [low, high] = [bounds.min[axis] - box.min[axis], bounds.max[axis] - box.max[axis]];
    return low > high ? 0 : rounded(Math.min(Math.max(wanted[axis], low), high), size);
  };
  return [clamp(0), clamp(1), clamp(2)];
}

/** As many digits as a picture shows. @param {number} value @param {number} range that it is of */
export function rounded(value, range) {
  const digits = Math.min(Math.max(5 - Math.ceil(Math.log10(Math.max(range, 1e-9))), 0), 12);
  return Number(value.toFixed(digits));
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
export const sum = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
