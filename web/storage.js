/** What the browser keeps for this page between visits; nothing is kept where it does not let us. */

const PREFIX = "lumenwalk ";

/** @param {string} name @returns {unknown} null if there is nothing that makes sense */
export function load(name) {
  try {
    return JSON.parse(localStorage.getItem(PREFIX + name) ?? "null");
  } catch {
    return null;
  }
}

/** @param {string} name @param {unknown} value @returns {boolean} whether it was saved */
export function save(name, value) {
  try {
    localStorage.setItem(PREFIX + name, JSON.stringify(value));
    return true;
  } catch {
    return false;
  }
}
