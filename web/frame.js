/** Coordinates of a scene's file, and of the world, which is in metres with +Y up. */

/** @typedef {import("./protocol.js").SceneFrame} SceneFrame */
/** @typedef {import("./viewer/camera.js").Vec3} Vec3 */

/** A tenth of a millimetre, and of the scene's size: less than a pixel. */
const STEP = { metres: 1e-4, size: 1e-5 };

/** @param {SceneFrame} frame @param {Vec3} at in the file @returns {Vec3} */
export function toWorld({ up, metres_per_unit: metres, origin }, at) {
  const [x, y, z] = [(at[0] - origin[0]) * metres, (at[1] - origin[1]) * metres, (at[2] - origin[2]) * metres];
  return up === "z" ? [x, z, -y] : [x, y, z];
}

/** @param {SceneFrame} frame @param {Vec3} at in the world @returns {Vec3} */
export function toFile({ up, metres_per_unit: metres, origin }, [x, y, z]) {
  const turned = /** @type {Vec3} */ (up === "z" ? [x, -z, y] : [x, y, z]);
  return [turned[0] / metres + origin[0], turned[1] / metres + origin[1], turned[2] / metres + origin[2]];
}

/** Decimals of a coordinate of the file that are worth writing. @param {SceneFrame} frame @param {number} size of the scene [m] */
export function decimalsOf({ metres_per_unit: metres }, size) {
  const step = Math.min(STEP.metres, STEP.size * size) / metres;
  return Math.min(Math.max(Math.ceil(-Math.log10(step)), 0), 15);
}
