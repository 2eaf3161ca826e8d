import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { CameraPath } from "../../../web/viewer/camera-path.js";

/** @typedef {import("../../../web/link.js").View} View */
/** @type {{keyframes: ({time: number} & View)[], samples: ({time: number} & View)[]}} */
const shared = JSON.parse(readFileSync(new URL("camera-path.json", import.meta.url), "utf8"));

/** The difference of angles, whole turns apart. @param {number} a @param {number} b */
const turned = (a, b) => Math.abs(Math.sin((a - b) / 2));

test("the page flies the way of rendered films (tests/gpu/scene/test_camera_path.py)", () => {
  const path = new CameraPath(shared.keyframes.map(({ time, ...view }) => ({ time, view })));
  assert.deepEqual([path.start, path.end], [0, 8]);
  for (const { time, at, look, yfov, near } of shared.samples) {
    const found = path.at(time);
    found.at.forEach((value, axis) => assert.ok(Math.abs(value - (at[axis] ?? NaN)) < 1e-9, `at ${time}: ${found.at}`));
    assert.ok(turned(found.look[0], look[0]) < 1e-9 && turned(found.look[1], look[1]) < 1e-9, `at ${time}: ${found.look}`);
    assert.ok(Math.abs(found.yfov - yfov) < 1e-9, `at ${time}: ${found.yfov}`);
    assert.ok(Math.abs((found.near ?? 0) - (near ?? 0)) < 1e-9, `at ${time}: ${found.near}`);
  }
});

test("two views are a straight way, in the coordinates of any file", () => {
  /** @type {View} */
  const view = { at: [456_789_000, 0, 0], look: [3, 0], yfov: 1 };
  const path = new CameraPath([{ time: 1, view }, { time: 3, view: { ...view, at: [456_789_200, 0, 0], look: [-3, 0] } }]);
  const { at, look } = path.at(2);
  assert.ok(Math.abs(at[0] - 456_789_100) < 1e-6);
  assert.ok(turned(look[0], Math.PI) < 1e-12);
  assert.deepEqual(path.at(9).at, [456_789_200, 0, 0]);
});
