import assert from "node:assert/strict";
import { test } from "node:test";

import { fromHex, toHex } from "../../../web/colors.js";

test("every byte comes back", () => {
  for (let byte = 0; byte < 256; byte++) {
    const hex = `#${byte.toString(16).padStart(2, "0")}80ff`;
    assert.equal(toHex(fromHex(hex)), hex);
  }
});

test("light is linear, and what is too bright is white", () => {
  assert.equal(toHex([0.2158605, 0, 7]), "#8000ff");
  assert.ok(Math.abs(fromHex("#808080")[0] - 0.2158605) < 1e-6);
});
