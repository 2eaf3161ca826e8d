/** A view as the end of an address (#scene=…&at=…&look=…&fov=…&SETTING=…), short enough to read and to send. */

/** @typedef {import("./viewer/camera.js").Place} Place */
/**
 * at: in the coordinates of the scene's file; yfov: vertical, of the camera [rad]; near: of the camera, 0 if not said [m]
 * @typedef {Place & {yfov: number, near?: number}} View
 */
/** @typedef {{scene?: string, view?: View, settings: Record<string, string>}} Link  settings as words, not yet judged */

const DEGREE = Math.PI / 180;
/** Decimals of an angle in degrees: less than a pixel. */
const ANGLE_DECIMALS = 2;
/** What nobody needs: a link that long, a place that far, a field of view outside of these [degrees]. */
const MOST_CHARACTERS = 4096;
/** Significant digits of where a view begins. */
const NEAR_DIGITS = 6;
const FARTHEST = 1e12;
const FIELD_OF_VIEW = { min: 1, max: 170 };

/**
 * @param {string} scene id @param {View} view @param {number} decimals of its position
 * @param {Readonly<Record<string, unknown>>} settings that differ from the defaults, and how the file is read
 * @returns {string} without the #
 */
export function writeLink(scene, { at, look, yfov, near }, decimals, settings) {
  const degrees = (/** @type {number} */ angle) => Number((angle / DEGREE).toFixed(ANGLE_DECIMALS));
  const words = new URLSearchParams({
    scene,
    at: at.map((value) => Number(value.toFixed(decimals))).join(),
    look: look.map(degrees).join(),
    fov: String(degrees(yfov)),
    ...(near && { near: String(Number(near.toPrecision(NEAR_DIGITS))) }),
  });
  for (const [name, value] of Object.entries(settings)) words.set(name, String(value));
  return words.toString().replaceAll("%2C", ",").replaceAll("%2F", "/");
}

/** Whatever makes sense of the end of an address. @param {string} hash with or without the # @returns {Link} */
export function readLink(hash) {
  if (hash.length > MOST_CHARACTERS) return { settings: {} };
  const { scene, at, look, fov, near, ...settings } = Object.fromEntries(new URLSearchParams(hash.replace(/^#/, "")));
  const view = viewOf(at, look, fov, near);
  return { ...(scene && { scene }), ...(view && { view }), settings };
}

/**
 * @param {string | undefined} at @param {string | undefined} look @param {string | undefined} fov
 * @param {string | undefined} near
 * @returns {View | null}
 */
function viewOf(at, look, fov, near) {
  const [x, y, z] = numbers(at, 3, FARTHEST);
  const [yaw, pitch] = numbers(look, 2, 360);
  const [degrees] = numbers(fov, 1, FIELD_OF_VIEW.max);
  const [cut = 0] = numbers(near, 1, FARTHEST);
  if (x === undefined || y === undefined || z === undefined || yaw === undefined || pitch === undefined) return null;
  if (degrees === undefined || degrees < FIELD_OF_VIEW.min) return null;
  const cuts = cut > 0 ? { near: cut } : {};
  return { at: [x, y, z], look: [yaw * DEGREE, pitch * DEGREE], yfov: degrees * DEGREE, ...cuts };
}

/** So many numbers; none if one is missing or out of bounds. @param {string | undefined} words @param {number} count @param {number} most */
function numbers(words, count, most) {
  const values = (words ?? "").split(",").map((word) => (word.trim() === "" ? NaN : Number(word)));
  return values.length === count && values.every((value) => Math.abs(value) <= most) ? values : [];
}
