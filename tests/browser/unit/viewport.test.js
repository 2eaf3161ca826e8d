import assert from "node:assert/strict";
import { test } from "node:test";

import { fitFov, frameSize } from "../../../web/viewer/viewport.js";

const limits = { max_pixels: 1920 * 1080, max_side: 4096 };

test("a frame has the window's proportions and stays within the limits", () => {
  assert.deepEqual(frameSize({ width: 1280, height: 720 }, limits), [1280, 720]);
  const [width, height] = frameSize({ width: 3840, height: 2160 }, limits);
  assert.ok(width * height <= limits.max_pixels && width > 1900);
  assert.deepEqual(frameSize({ width: 9000, height: 10 }, limits), [4096, 4]);
  assert.deepEqual(frameSize({ width: 1365, height: 767 }, limits), [1365, 767]); // pixel by pixel, odd or not
  assert.deepEqual(frameSize({ width: 0, height: 0 }, limits), [1, 1]);
});

test("a wide picture has the camera's field of view, an upright one more", () => {
  assert.equal(fitFov(1, 2), 1);
  assert.ok(fitFov(1, 0.5) > 1.2 && fitFov(1, 0.5) < 2);
  assert.ok(fitFov(3.08, 0.5) < 3.1); // else the server would refuse the pose
});
