import assert from "node:assert/strict";
import { test } from "node:test";

import { Camera, distance, dot, MAX_PITCH, scale } from "../../../web/viewer/camera.js";

/** @typedef {import("../../../web/viewer/camera.js").Vec3} Vec3 */

/** @param {readonly number[]} actual @param {readonly number[]} expected */
function close(actual, expected) {
  assert.equal(actual.length, expected.length);
  actual.forEach((value, index) => {
    assert.ok(Math.abs(value - (expected[index] ?? NaN)) < 1e-9, `${actual} is not ${expected}`);
  });
}

/** @param {Vec3} position @param {number} yaw @param {number} pitch */
function camera(position, yaw, pitch) {
  return Object.assign(new Camera(), { position, yaw, pitch });
}

test("at rest the camera looks along -Z", () => {
  close(new Camera().matrix(), [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
});

test("the axes are a right-handed rotation for any gaze", () => {
  for (const [yaw, pitch] of [[0.3, 0.2], [-2.5, 1.2], [3.1, -1.5]]) {
    const { right, up, back } = camera([0, 0, 0], yaw ?? 0, pitch ?? 0).axes();
    close([dot(right, right), dot(up, up), dot(back, back)], [1, 1, 1]);
    close([dot(right, up), dot(up, back), dot(back, right)], [0, 0, 0]);
    close([right[1] * up[2] - right[2] * up[1], right[2] * up[0] - right[0] * up[2], right[0] * up[1] - right[1] * up[0]], back);
  }
});

test("a matrix gives the pose it was made of", () => {
  for (const pose of [camera([1, 2, 3], 0.7, -0.4), camera([-5, 0, 9], -3, 1.5)]) {
    const copy = new Camera();
    copy.setMatrix(pose.matrix());
    close([...copy.position, copy.yaw, copy.pitch], [...pose.position, pose.yaw, pose.pitch]);
  }
});

test("looking straight down keeps the heading of the picture's top", () => {
  // Up of the picture is +X: the heading is -X to +X, that is a quarter turn to the right.
  const down = [0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 0, 1];
  const pose = new Camera();
  pose.setMatrix(down);
  close([pose.yaw, pose.pitch], [-Math.PI / 2, -MAX_PITCH]);
});

test("yaw turns left, pitch turns up and stops short of the zenith", () => {
  const pose = new Camera();
  pose.turn(Math.PI / 2, 0);
  close(scale(pose.axes().back, -1), [-1, 0, 0]);
  pose.turn(0, 10);
  assert.equal(pose.pitch, MAX_PITCH);
  pose.turn(100, 0);
  assert.ok(Math.abs(pose.yaw) <= Math.PI);
});

test("moving follows the gaze", () => {
  const pose = camera([0, 0, 0], Math.PI / 2, 0);
  pose.move(0, 0, 2);
  close(pose.position, [-2, 0, 0]);
  pose.move(1, 3, 0);
  close(pose.position, [-2, 3, -1]);
});

test("orbiting keeps the pivot where it is, straight ahead", () => {
  const pose = camera([1, 2, 3], 0.5, -0.3);
  const pivot = pose.ahead(4);
  pose.orbit(4, 0.8, 0.4);
  close(pose.ahead(4), pivot);
  close([distance(pose.position, pivot)], [4]);
});
