import assert from "node:assert/strict";
import { test } from "node:test";

import { add, Camera, scale } from "../../../web/viewer/camera.js";
import { alongAxis, aroundAxis, Projection } from "../../../web/viewer/projection.js";

/** @typedef {import("../../../web/viewer/camera.js").Vec3} Vec3 */

/** @param {number} actual @param {number} expected */
const close = (actual, expected) => assert.ok(Math.abs(actual - expected) < 1e-6, `${actual} is not ${expected}`);

const LENS = { yfov: Math.PI / 2, near: 0, width: 400, height: 200 };
const ahead = new Projection(new Camera(), LENS);
const turned = new Projection(Object.assign(new Camera(), { position: [1, 2, 3], yaw: 0.7, pitch: -0.4 }), LENS);

test("a point is where the picture shows it", () => {
  assert.deepEqual(ahead.point([0, 0, -2]), { x: 200, y: 100 });
  const { x, y } = ahead.point([2, 1, -2]) ?? assert.fail();
  close(x, 300);
  close(y, 50);
  close(ahead.pixelAt([0, 0, -2]), 0.02);
});

test("what is behind the camera or cut away is nowhere", () => {
  assert.equal(ahead.point([0, 0, 1]), null);
  const cut = new Projection(new Camera(), { ...LENS, near: 3 });
  assert.equal(cut.point([0, 0, -2]), null);
  assert.notEqual(cut.point([0, 0, -4]), null);
});

test("the ray of a place leads to what is shown there", () => {
  const { from, along } = turned.ray({ x: 123, y: 45 });
  const place = turned.point(add(from, scale(along, 5)));
  close(place?.x ?? NaN, 123);
  close(place?.y ?? NaN, 45);
});

test("a line is cut where it goes behind the camera", () => {
  const cut = new Projection(new Camera(), { ...LENS, near: 1 });
  const [start, end] = cut.line([0, 0, -2], [2, 0, 0]) ?? assert.fail();
  close(start.x, 200);
  close(end.x, 300); // at (1, 0, −1)
  const [last, first] = cut.line([2, 0, 0], [0, 0, -2]) ?? assert.fail();
  close(first.x, start.x);
  close(last.x, end.x);
  assert.equal(cut.line([0, 0, 1], [5, 0, 2]), null);
});

test("a pointer tells how far along an axis it is", () => {
  const at = /** @type {Vec3} */ ([1.5, 1, 0]);
  const axis = /** @type {Vec3} */ ([0, 1, 0]);
  const place = turned.point(add(at, scale(axis, 0.25))) ?? assert.fail();
  close(alongAxis(turned.ray(place), at, axis) ?? NaN, 0.25);
});

test("an axis that is seen from its end tells nothing", () => {
  assert.equal(alongAxis(ahead.ray({ x: 201, y: 100 }), [0, 0, -2], [0, 0, 1]), null);
});

test("a ring that is dragged follows the pointer, seen from above or from its edge", () => {
  const at = /** @type {Vec3} */ ([0, 0, -2]);
  const held = (/** @type {0 | 1 | 2} */ axis, /** @type {Vec3} */ point) => aroundAxis(ahead.ray(ahead.point(point) ?? assert.fail()), at, axis, 0.5);
  close(held(2, [0.5, 0, -2]), 0);
  close(held(2, [0, 0.9, -2]), Math.PI / 2);
  close(held(1, [0, 0, -1.5]), 0); // about Y, from Z to X
  close(held(1, [0.3, 0, -1.6]), Math.atan2(0.3, 0.4));
});

test("what has no place is above the middle", () => {
  const { x, y } = ahead.point(ahead.ahead()) ?? assert.fail();
  close(x, 200);
  close(y, 200 / 3);
  assert.deepEqual(ahead.towards([0, 0, -4]), [0, 0, -1]);
});
