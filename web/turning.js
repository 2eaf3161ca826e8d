/**
 * Rotations: angles about the world's axes [°], as edits of objects have them, about Z first, then X, then Y, which is up;
 * quaternions, which turn on from there; and where a light shines, as a direction or as azimuth and elevation [°].
 */

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {[number, number, number, number]} Quaternion  x, y, z, w, of unit length, as in glTF */

const DEGREE = Math.PI / 180;
/** Sine of the angle about X beyond which those about Y and Z are about the same line: Y has it all then. */
const UPRIGHT = 1 - 1e-9;

/** @param {0 | 1 | 2} axis of the world @param {number} angle [rad] @returns {Quaternion} */
export function about(axis, angle) {
  /** @type {Quaternion} */
  const made = [0, 0, 0, Math.cos(angle / 2)];
  made[axis] = Math.sin(angle / 2);
  return made;
}

/** First `a`, then `b`. @param {Quaternion} a @param {Quaternion} b @returns {Quaternion} */
export const then = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  bw * ax + bx * aw + by * az - bz * ay,
  bw * ay - bx * az + by * aw + bz * ax,
  bw * az + bx * ay - by * ax + bz * aw,
  bw * aw - bx * ax - by * ay - bz * az,
];

/** A vector after a rotation. @param {Vec3} vector @param {Quaternion} by @returns {Vec3} */
export function turned([x, y, z], by) {
  const [qx, qy, qz, qw] = by;
  const [made, back] = [then([x, y, z, 0], by), /** @type {Quaternion} */ ([-qx, -qy, -qz, qw])];
  const [tx, ty, tz] = then(back, made);
  return [tx, ty, tz];
}

/** @param {Vec3} angles [°] @returns {Quaternion} */
export function fromAngles([x, y, z]) {
  return then(then(about(2, z * DEGREE), about(0, x * DEGREE)), about(1, y * DEGREE));
}

/** @param {Quaternion} rotation @returns {Vec3} [°] to a hundredth, from −180 to 180 */
export function toAngles([x, y, z, w]) {
  const sine = 2 * (w * x - y * z);
  const made = Math.abs(sine) > UPRIGHT
    ? [Math.sign(sine) * 90 * DEGREE, within(2 * Math.atan2(y, w)), 0]
    : [Math.asin(sine), Math.atan2(2 * (x * z + w * y), 1 - 2 * (x * x + y * y)), Math.atan2(2 * (x * y + w * z), 1 - 2 * (x * x + z * z))];
  const [aboutX = 0, aboutY = 0, aboutZ = 0] = made.map(hundredths);
  return [aboutX, aboutY, aboutZ];
}

/** Where a light of a direction shines: clockwise from −Z, seen from above, and up from the horizon. @param {Vec3} direction @returns {[number, number]} [°] */
export function toAim([x, y, z]) {
  const level = Math.hypot(x, z);
  const length = Math.hypot(level, y);
  return [level > 1e-6 * length ? hundredths(Math.atan2(x, -z)) : 0, hundredths(Math.atan2(y, level))];
}

/** @param {number} azimuth [°] @param {number} elevation [°] @returns {Vec3} of unit length, to six decimals */
export function fromAim(azimuth, elevation) {
  const level = Math.cos(elevation * DEGREE);
  return direction([level * Math.sin(azimuth * DEGREE), Math.sin(elevation * DEGREE), -level * Math.cos(azimuth * DEGREE)]);
}

/** A direction with as many decimals as it is worth. @param {Vec3} vector @returns {Vec3} */
export const direction = ([x, y, z]) => [decimals(x), decimals(y), decimals(z)];

/** @param {number} value */
const decimals = (value) => Number(value.toFixed(6)) + 0; // no −0

/** @param {number} angle [rad] @returns [°] */
const hundredths = (angle) => Number((angle / DEGREE).toFixed(2)) + 0;

/** An angle from −π to π. @param {number} angle */
const within = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
