import assert from "node:assert/strict";
import { test } from "node:test";

import { fitFov, frameSize } from "../../../web/viewer/lens.js";
import { Resolution } from "../../../web/viewer/resolution.js";

const limits = { max_pixels: 1920 * 1080, max_side: 4096 };

test("a frame has the window's proportions and stays within the limits", () => {
  assert.deepEqual(frameSize({ width: 1280, height: 720 }, 1, limits), [1280, 720]);
  assert.deepEqual(frameSize({ width: 1280, height: 720 }, 0.4, limits), [512, 288]);
  const [width, height] = frameSize({ width: 3840, height: 2160 }, 1, limits);
  assert.ok(width * height <= limits.max_pixels && width > 1900);
  assert.deepEqual(frameSize({ width: 9000, height: 10 }, 1, limits), [4096, 4]);
  assert.deepEqual(frameSize({ width: 0, height: 0 }, 1, limits), [2, 2]);
});

test("a wide picture has the camera's field of view, an upright one more", () => {
  assert.equal(fitFov(1, 2), 1);
  assert.ok(fitFov(1, 0.5) > 1.2 && fitFov(1, 0.5) < 2);
});

test("a quick device gets all pixels of use at once", () => {
  const resolution = new Resolution();
  const start = resolution.pixels;
  assert.equal(resolution.observe(start, 5, 1280 * 720), true);
  assert.equal(resolution.pixels, 1280 * 720);
  assert.equal(resolution.observe(1280 * 720, 25, 1280 * 720), false);
});

test("a slow device keeps a modest size while that is bearable, less when it is not", () => {
  const resolution = new Resolution();
  const modest = resolution.pixels;
  for (let frame = 0; frame < 10; frame++) assert.equal(resolution.observe(modest, 150, 1e6), false);
  resolution.restart();
  for (let frame = 0; frame < 3; frame++) assert.equal(resolution.observe(modest, 900, 1e6), false);
  assert.equal(resolution.observe(modest, 900, 1e6), true);
  assert.equal(resolution.pixels, modest / 2);
  for (let frame = 0; frame < 10; frame++) assert.equal(resolution.observe(modest / 2, 900, 1e6), false);
});

test("one slow first frame does not shrink the picture", () => {
  const resolution = new Resolution();
  const modest = resolution.pixels;
  assert.equal(resolution.observe(modest, 5000, 1e6), false);
  for (let frame = 0; frame < 10; frame++) assert.equal(resolution.observe(modest, 120, 1e6), false);
});
