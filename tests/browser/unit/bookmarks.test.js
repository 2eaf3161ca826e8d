import assert from "node:assert/strict";
import { test } from "node:test";

import { addBookmark, bookmarksOf, removeBookmark } from "../../../web/bookmarks.js";
import { keepAnew } from "./kept.js";

/** @type {import("../../../web/link.js").View} */
const view = { at: [1, 2, 3], look: [0.1, 0.2], yfov: 1 };
const kept = keepAnew();

test("each scene has its own bookmarks, in the order in which they were made", () => {
  assert.ok(addBookmark("hall", " door ", view));
  assert.ok(addBookmark("hall", "", { ...view, yfov: 2 }));
  assert.ok(addBookmark("attic", "roof", view));
  assert.deepEqual(bookmarksOf("hall"), [{ name: "door", view }, { name: "View 2", view: { ...view, yfov: 2 } }]);
  removeBookmark("hall", 0);
  assert.deepEqual(bookmarksOf("hall").map(({ name }) => name), ["View 2"]);
  assert.equal(bookmarksOf("attic").length, 1);
});

test("junk in the storage is passed over", () => {
  addBookmark("hall", "door", view);
  const [name = ""] = kept.keys();
  const junk = [null, 1, { name: "x" }, { name: "y", view: { at: [1, 2], look: [0, 0], yfov: 1 } }, { name: "z", view }];
  kept.set(name, JSON.stringify(junk));
  assert.deepEqual(bookmarksOf("hall"), [{ name: "z", view }]);
  kept.set(name, "{");
  assert.deepEqual(bookmarksOf("hall"), []);
});

test("a browser that keeps nothing is no error", () => {
  Object.defineProperty(globalThis, "localStorage", {
    configurable: true,
    get() {
      throw new Error("denied");
    },
  });
  assert.deepEqual(bookmarksOf("hall"), []);
  assert.equal(addBookmark("hall", "door", view), false);
});
