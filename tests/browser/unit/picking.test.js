import assert from "node:assert/strict";
import { afterEach, test } from "node:test";

import { pick, PickError, wordsOf } from "../../../web/picking.js";

const { fetch } = globalThis;
afterEach(() => (globalThis.fetch = fetch));

const API = new URL("http://here/walk/api/v1/");
const OPTIONS = { up: "z" };
const VIEW = /** @type {import("../../../web/picking.js").View} */ (/** @type {unknown} */ ({
  scene: { id: "rooms/hall.glb", options: OPTIONS }, edits: null, matrix: [1], yfov: Math.PI / 2, near: 0.5, size: [80, 40],
}));
const NOTHING = { object: null, material: null, light: null, point: null, distance: null };

/** @param {number} status @param {unknown} body */
function answer(status, body) {
  /** @type {{url: string, body: unknown}[]} */
  const asked = [];
  globalThis.fetch = async (url, init) => {
    asked.push({ url: String(url), body: JSON.parse(String(init?.body)) });
    return new Response(JSON.stringify(body), { status });
  };
  return asked;
}

test("the server is asked for a pixel of the view", async () => {
  const asked = answer(200, NOTHING);
  assert.deepEqual(await pick(API, VIEW, [20, 10]), NOTHING);
  const camera = { matrix: [1], yfov_degrees: 90, near: 0.5 };
  const body = { scene: "rooms/hall.glb", scene_options: OPTIONS, edits: null, camera, size: [80, 40], pixel: [20, 10] };
  assert.deepEqual(asked, [{ url: "http://here/walk/api/v1/pick", body }]);
});

test("a refusal is told in the server's words", async () => {
  answer(429, { code: "too-busy", message: "more than 10 picks" });
  await assert.rejects(pick(API, VIEW, [0, 0]), new PickError("more than 10 picks"));
  globalThis.fetch = () => Promise.reject(new TypeError());
  await assert.rejects(pick(API, VIEW, [0, 0]), /does not answer/);
});

test("what is there is named once", () => {
  assert.equal(wordsOf(NOTHING), "Nothing is there");
  assert.equal(wordsOf({ ...NOTHING, light: "sky" }), "sky");
  assert.equal(wordsOf({ ...NOTHING, object: "chair", material: "oak", distance: 1.23456 }), "chair, oak: 1.23 m away");
  assert.equal(wordsOf({ ...NOTHING, object: "lamp", material: "lamp", light: "lamp", distance: 2 }), "lamp: 2 m away");
});
