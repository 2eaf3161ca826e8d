/** How a scene's file is read, as words of a link. */

/** @typedef {import("./protocol.js").ImportOptions} ImportOptions */

export const UPS = /** @type {const} */ (["y", "z"]);
export const UNITS = /** @type {const} */ (["m", "cm", "mm", "ft", "in"]);

/** @param {ImportOptions} options @returns {Record<string, string>} */
export function wordsOf({ up, unit, origin, variant, storeys }) {
  return {
    ...(up && { up }),
    ...(unit && { unit }),
    ...(origin && { origin: String(origin) }),
    ...(variant && { variant }),
    ...(storeys?.length && { storeys: storeys.map(encodeURIComponent).join() }),
  };
}

/** What makes sense of the words; null where nothing is said. @param {Readonly<Record<string, string>>} words @returns {ImportOptions | null} */
export function optionsOf(words) {
  const up = UPS.find((axis) => axis === words.up);
  const unit = UNITS.find((name) => name === words.unit);
  const origin = originOf(words.origin);
  const options = {
    ...(up && { up }),
    ...(unit && { unit }),
    ...(origin && { origin }),
    ...(words.variant && { variant: words.variant }),
    ...(words.storeys && { storeys: words.storeys.split(",").map(decoded) }),
  };
  return Object.keys(options).length > 0 ? options : null;
}

/** The point "x,y,z" that metres count from, or "auto"; null where it is neither. @param {string | undefined} words @returns {[number, number, number] | "auto" | null} */
export function originOf(words) {
  if (words?.trim() === "auto") return "auto";
  const [x, y, z, ...more] = (words ?? "").split(",").map((word) => (word.trim() === "" ? NaN : Number(word)));
  if (x === undefined || y === undefined || z === undefined || more.length > 0) return null;
  return [x, y, z].every(Number.isFinite) ? [x, y, z] : null;
}

/** @param {string} word */
function decoded(word) {
  try {
    return decodeURIComponent(word);
  } catch {
    return word;
  }
}
