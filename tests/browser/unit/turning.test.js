import assert from "node:assert/strict";
import { test } from "node:test";

import { about, fromAim, fromAngles, then, toAim, toAngles, turned } from "../../../web/turning.js";

const QUARTER = Math.PI / 2;

/** @param {readonly number[]} found @param {readonly number[]} wanted */
function near(found, wanted) {
  wanted.forEach((value, index) => assert.ok(Math.abs((found[index] ?? NaN) - value) < 1e-6, `${found} is not ${wanted}`));
}

test("rotations are counter-clockwise, Z first and Y last, as the server has them", () => {
  near(turned([0, 1, 0], about(0, QUARTER)), [0, 0, 1]);
  near(turned([0, 0, 1], about(1, QUARTER)), [1, 0, 0]);
  near(turned([1, 0, 0], about(2, QUARTER)), [0, 1, 0]);
  near(turned([1, 0, 0], fromAngles([90, 0, 90])), [0, 0, 1]);
  near(turned([0, 1, 0], fromAngles([90, 90, 0])), [1, 0, 0]);
});

test("angles are found again, and where two axes are one they tell the same rotation", () => {
  for (const angles of /** @type {[number, number, number][]} */ ([[10, -120, 170], [-80, 5, 0], [0, 0, -90], [0, 0, 0]])) {
    assert.deepEqual(toAngles(fromAngles(angles)), angles);
  }
  for (const upright of [90, -90]) {
    const rotation = fromAngles([upright, 30, 50]);
    for (const axis of /** @type {[number, number, number][]} */ ([[1, 0, 0], [0, 1, 0], [0, 0, 1]])) {
      near(turned(axis, fromAngles(toAngles(rotation))), turned(axis, rotation));
    }
  }
  assert.deepEqual(toAngles(then(fromAngles([0, 170, 0]), about(1, (20 * Math.PI) / 180))), [0, -170, 0]);
});

test("a light shines by azimuth and elevation", () => {
  assert.deepEqual(fromAim(90, 0), [1, 0, 0]);
  assert.deepEqual(fromAim(0, -90), [0, -1, 0]);
  assert.deepEqual(toAim([0, -3, 0]), [0, -90]);
  assert.deepEqual(toAim(fromAim(-135, -30)), [-135, -30]);
});
