/** Named views of each scene, kept by the browser. */

import { load, save } from "./storage.js";

/** @typedef {import("./link.js").View} View */
/** @typedef {{name: string, view: View}} Bookmark */

const MOST = 99;
const LONGEST_NAME = 60;

/** @param {string} scene id */
const key = (scene) => `bookmarks ${scene}`;

/** @param {string} scene id @returns {Bookmark[]} */
export function bookmarksOf(scene) {
  const list = load(key(scene));
  return Array.isArray(list) ? list.filter(isBookmark) : [];
}

/** Adds a view at the end; a nameless one is called by its number. @param {string} scene id @param {string} name @param {View} view */
export function addBookmark(scene, name, view) {
  const list = bookmarksOf(scene);
  const called = name.trim().slice(0, LONGEST_NAME) || `View ${list.length + 1}`;
  return list.length < MOST && save(key(scene), [...list, { name: called, view }]);
}

/** @param {string} scene id @param {number} index */
export function removeBookmark(scene, index) {
  save(key(scene), bookmarksOf(scene).toSpliced(index, 1));
}

/** @param {unknown} value @returns {value is Bookmark} */
function isBookmark(value) {
  const { name, view } = /** @type {Partial<Bookmark>} */ (value ?? {});
  return typeof name === "string" && isView(view);
}

/** Whether something that was kept, or came from a file, is a view. @param {unknown} value @returns {value is View} */
export function isView(value) {
  const { at, look, yfov, near = 0 } = /** @type {Partial<View>} */ (value ?? {});
  if (!Array.isArray(at) || !Array.isArray(look) || yfov === undefined) return false;
  const numbers = [...at, ...look, yfov, near];
  return numbers.length === 7 && numbers.every(Number.isFinite) && yfov > 0.01 && yfov < 3.1;
}
