/** Colours between light, which is linear, and what a browser's colour fields hold: "#rrggbb", sRGB (IEC 61966-2-1). */

/** @typedef {readonly [number, number, number]} Rgb  linear Rec. 709, from 0 to 1 */

/** @param {number} value */
const encode = (value) => (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);

/** @param {number} value */
const decode = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

/** @param {Rgb} color @returns {string} */
export function toHex(color) {
  const bytes = color.map((value) => Math.round(255 * encode(Math.min(Math.max(value, 0), 1))));
  return `#${bytes.map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}

/** @param {string} hex @returns {[number, number, number]} */
export function fromHex(hex) {
  const channel = (/** @type {number} */ at) => decode(Number.parseInt(hex.slice(at, at + 2), 16) / 255);
  return [channel(1), channel(3), channel(5)];
}
