import assert from "node:assert/strict";
import { test } from "node:test";

import { ease, wishOf } from "../../../web/viewer/gamepad.js";
import { bothOf } from "../../../web/viewer/keys.js";

/** @param {number[]} axes @param {Record<number, number>} [pressed] value by index of the button */
function pad(axes, pressed = {}) {
  const buttons = Array.from({ length: 17 }, (_, index) => {
    const value = pressed[index] ?? 0;
    return { value, pressed: value > 0, touched: value > 0 };
  });
  return { axes, buttons };
}

test("a worn stick at rest asks for nothing; a stick at its end for all", () => {
  assert.equal(Math.abs(ease(0.1)), 0);
  assert.equal(Math.abs(ease(-0.1)), 0);
  assert.equal(ease(1), 1);
  assert.equal(ease(-1), -1);
  assert.ok(ease(0.5) > 0 && ease(0.5) < 0.5);
});

test("the left stick moves, the right one turns, triggers go down and up", () => {
  assert.deepEqual(wishOf(pad([1, -1, 0, 0])), { move: [1, 0, 1], turn: [0, 0] });
  assert.deepEqual(wishOf(pad([0, 0, 1, -1])).turn, [-1, 1]);
  assert.equal(wishOf(pad([0, 0, 0, 0], { 7: 0.5 })).move[1], 0.5);
  assert.equal(wishOf(pad([0, 0, 0, 0], { 6: 1 })).move[1], -1);
  assert.deepEqual(wishOf(pad([])), { move: [0, 0, 0], turn: [0, 0] });
});

test("keys and sticks together go no faster than either", () => {
  const all = bothOf({ move: [1, 0, 1], turn: [0, 0] }, { move: [1, 0.5, -1], turn: [-0.5, 0] });
  assert.deepEqual(all, { move: [1, 0.5, 0], turn: [-0.5, 0] });
});
