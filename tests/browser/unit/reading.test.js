import assert from "node:assert/strict";
import { test } from "node:test";

import { optionsOf, wordsOf } from "../../../web/reading.js";

test("what is said of a file goes through a link", () => {
  /** @type {import("../../../web/protocol.js").ImportOptions} */
  const options = { up: "z", unit: "mm", origin: [456789.5, -1, 0], variant: "dark oak", storeys: ["ground, east", "first"] };
  assert.deepEqual(optionsOf(Object.fromEntries(new URLSearchParams(new URLSearchParams(wordsOf(options)).toString()))), options);
});

test("nothing said is nothing in a link", () => {
  assert.deepEqual(wordsOf({ up: null, unit: null, origin: null, variant: null, storeys: [] }), {});
  assert.equal(optionsOf({ method: "path" }), null);
});

test("junk is passed over", () => {
  assert.equal(optionsOf({ up: "x", unit: "km", origin: "1,2" }), null);
  assert.deepEqual(optionsOf({ origin: "auto", storeys: "%zz" }), { origin: "auto", storeys: ["%zz"] });
});
