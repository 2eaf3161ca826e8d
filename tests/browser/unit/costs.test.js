import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { Costs } from "../../../web/costs.js";

/** @type {Costs} */
let costs;
beforeEach(() => {
  costs = new Costs();
  costs.frames = { draft: 64, balanced: 512, best: 2048 };
});

/** @param {number} renderMs @param {number} targetSamples @param {Record<string, number>} [stagesMs] */
const frame = (renderMs, targetSamples, stagesMs = { gbuffer: 1, display: 1 }) =>
  /** @type {import("../../../web/protocol.js").Frame} */ (/** @type {unknown} */ ({ width: 80, height: 40, renderMs, stagesMs, targetSamples }));

test("what was not measured costs about as much a frame as what was", () => {
  assert.equal(costs.words("best"), "sharp after 2,048 frames");
  costs.learn("balanced", frame(30, 500), "hall path");
  costs.learn("balanced", frame(10, 500), "hall path");
  assert.equal(costs.words("balanced"), "10 ms a frame, sharp after 500: 5 s");
  assert.equal(costs.words("draft"), "sharp after 64 frames: about 0.64 s");
  assert.equal(costs.words("best"), "sharp after 2,048 frames: about 20 s");
  costs.learn("draft", frame(1000, 64), "hall path");
  assert.equal(costs.words("best"), "sharp after 2,048 frames: about 34 min");
});

test("a picture that is shown again costs nothing, and tells nothing", () => {
  costs.learn("balanced", frame(1000, 16), "hall path");
  costs.learn("balanced", frame(4, 16, { display: 4 }), "hall path");
  assert.equal(costs.words("balanced"), "1,000 ms a frame, sharp after 16: 16 s");
});

test("another scene, method or size costs something else", () => {
  costs.learn("balanced", frame(10, 500), "hall path");
  costs.learn("draft", frame(20, 64), "hall fuzzy-vpl");
  assert.equal(costs.words("balanced"), "sharp after 512 frames: about 10 s");
});

test("nothing is said of what the server does not count", () => {
  costs.frames = {};
  assert.equal(costs.words("draft"), "");
});
