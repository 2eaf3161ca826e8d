/** What the browser keeps for this page between visits; nothing is kept where it does not let us. */

const PREFIX = "lumenwalk ";

/** @param {string} name @returns {unknown} null if there is nothing that makes sense */
export function kept(name) {
  try {
    return JSON.parse(localStorage.getItem(PREFIX + name) ?? "null");
  } catch {
    return null;
  }
}

/** @param {string} name @param {unknown} value @returns {boolean} whether it is kept */
export function keep(name, value) {
  try {
    localStorage.setItem(PREFIX + name, JSON.stringify(value));
    return true;
  } catch {
    return false;
  }
}
