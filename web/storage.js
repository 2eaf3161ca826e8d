/** What the browser keeps for this page between visits, or in its tab; nothing is kept where it does not let us. */

const PREFIX = "lumenwalk ";

/** @param {string} name @param {"localStorage" | "sessionStorage"} [where] @returns {unknown} null if there is nothing that makes sense */
export function load(name, where = "localStorage") {
  try {
    return JSON.parse(globalThis[where].getItem(PREFIX + name) ?? "null");
  } catch {
    return null;
  }
}

/** @param {string} name @param {unknown} value @param {"localStorage" | "sessionStorage"} [where] @returns {boolean} whether it was saved */
export function save(name, value, where = "localStorage") {
  try {
    globalThis[where].setItem(PREFIX + name, JSON.stringify(value));
    return true;
  } catch {
    return false;
  }
}
