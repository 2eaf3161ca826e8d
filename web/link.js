/** A view as the end of an address (#scene=…&at=…&look=…&fov=…&SETTING=…), short enough to read and to send. */

/** @typedef {import("./viewer/camera.js").Place} Place */
/** @typedef {Place & {yfov: number}} View  at: in the coordinates of the scene's file; yfov: vertical, of the camera [rad] */
/** @typedef {{scene?: string, view?: View, settings: Record<string, string>}} Link  settings as words, not yet judged */

const DEGREE = Math.PI / 180;
/** Decimals of an angle in degrees: less than a pixel. */
const ANGLE_DECIMALS = 2;
/** What nobody needs: a link that long, a place that far, a field of view outside of these [degrees]. */
const MOST_CHARACTERS = 4096;
const FARTHEST = 1e12;
const FIELD_OF_VIEW = { min: 1, max: 170 };

/**
 * @param {string} scene id @param {View} view @param {number} decimals of its position
 * @param {Readonly<Record<string, unknown>>} settings that differ from the defaults, and how the file is read
 * @returns {string} without the #
 */
export function writeLink(scene, { at, look, yfov }, decimals, settings) {
  const degrees = (/** @type {number} */ angle) => Number((angle / DEGREE).toFixed(ANGLE_DECIMALS));
  const words = new URLSearchParams({
    scene,
    at: at.map((value) => Number(value.toFixed(decimals))).join(),
    look: look.map(degrees).join(),
    fov: String(degrees(yfov)),
  });
  for (const [name, value] of Object.entries(settings)) words.set(name, String(value));
  return words.toString().replaceAll("%2C", ",").replaceAll("%2F", "/");
}

/** Whatever makes sense of the end of an address. @param {string} hash with or without the # @returns {Link} */
export function readLink(hash) {
  if (hash.length > MOST_CHARACTERS) return { settings: {} };
  const { scene, at, look, fov, ...settings } = Object.fromEntries(new URLSearchParams(hash.replace(/^#/, "")));
  const view = viewOf(at, look, fov);
  return { ...(scene && { scene }), ...(view && { view }), settings };
}

/** @param {string | undefined} at @param {string | undefined} look @param {string | undefined} fov @returns {View | null} */
function viewOf(at, look, fov) {
  const [x, y, z] = numbers(at, 3, FARTHEST);
  const [yaw, pitch] = numbers(look, 2, 360);
  const [degrees] = numbers(fov, 1, FIELD_OF_VIEW.max);
  if (x === undefined || y === undefined || z === undefined || yaw === undefined || pitch === undefined) return null;
  if (degrees === undefined || degrees < FIELD_OF_VIEW.min) return null;
  return { at: [x, y, z], look: [yaw * DEGREE, pitch * DEGREE], yfov: degrees * DEGREE };
}

/** So many numbers; none if one is missing or out of bounds. @param {string | undefined} words @param {number} count @param {number} most */
function numbers(words, count, most) {
  const values = (words ?? "").split(",").map((word) => (word.trim() === "" ? NaN : Number(word)));
  return values.length === count && values.every((value) => Math.abs(value) <= most) ? values : [];
}
