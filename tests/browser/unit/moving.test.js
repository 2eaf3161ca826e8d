import assert from "node:assert/strict";
import { test } from "node:test";

import { middleOf, offsetWithin, rounded, stepIn } from "../../../web/moving.js";

/** @typedef {import("../../../web/messages.js").Bounds} Bounds */

/** @type {Bounds} */
const ROOM = { min: [0, 0, 0], max: [4, 3, 5] };
/** @type {Bounds} */
const CHAIR = { min: [1, 0, 1], max: [2, 1, 2] };

test("steps are round, and about a hundredth of the scene", () => {
  assert.deepEqual([0.9, 2, 3.5, 7, 60, 1000].map(stepIn), [0.005, 0.02, 0.02, 0.05, 0.5, 10]);
});

test("an object stays within its scene", () => {
  assert.deepEqual(offsetWithin(CHAIR, ROOM, [0.5, 0.25, -0.5]), [0.5, 0.25, -0.5]);
  assert.deepEqual(offsetWithin(CHAIR, ROOM, [9, -1, -9]), [2, 0, -1]);
  assert.deepEqual(offsetWithin({ min: [-9, 0, 1], max: [9, 1, 2] }, ROOM, [1, 1, 1]), [0, 1, 1]); // far away on X
  const wall = /** @type {Bounds} */ ({ min: [0, 0, 0], max: [4 - 1e-7, 3, 5] }); // there is no room to speak of
  assert.deepEqual(offsetWithin(wall, ROOM, [1, 1, 1]), [0, 0, 0]);
});

test("places have as many digits as can be seen", () => {
  assert.equal(rounded(1 / 3, 5), 0.3333);
  assert.equal(rounded(1000 / 3, 50000), 333);
  assert.equal(rounded(0.0001234567, 0.001), 0.00012346);
});

test("a box moves as a whole", () => {
  assert.deepEqual(middleOf(CHAIR), [1.5, 0.5, 1.5]);
});
