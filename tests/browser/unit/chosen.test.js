import assert from "node:assert/strict";
import { test } from "node:test";

import { movedTo, sizedTo, targetOf, turnedFrom } from "../../../web/chosen.js";

/** @typedef {import("../../../web/messages.js").SceneInfo} SceneInfo */
/** @typedef {[number, number, number]} Vec3 */

/** @type {Vec3} */
const DOWN = [0, -1, 0];
const bounds = { min: /** @type {Vec3} */ ([-1, -1, -1]), max: /** @type {Vec3} */ ([1, 1, 1]) };
const scene = /** @type {SceneInfo} */ (/** @type {unknown} */ ({
  bounds,
  objects: [{ id: "chair", box: { min: [0, 0, 0], max: [0.4, 0.2, 0.2] } }],
  lights: [{ id: "spot", position: [0, 1, 0], direction: DOWN }, { id: "sun", position: null, direction: DOWN }, { id: "lamp", position: null, direction: null }],
}));
const none = { lights: {}, objects: {}, suns: {} };

test("an object is turned about the middle of its box, then moved, with its box", () => {
  const chair = targetOf({ kind: "object", id: "chair" }, scene, { ...none, objects: { chair: { offset: [0, 0.5, 0], rotation: [0, 90, 0] } } });
  assert.deepEqual(chair?.at, [0.2, 0.6, 0.1]);
  const corner = chair?.corners?.[0]?.map((value) => Number(value.toFixed(9)));
  assert.deepEqual(corner, [0.1, 0.5, 0.3]);
  assert.deepEqual(movedTo({ kind: "object", id: "chair" }, scene, none, [0.3, 0.1, 9]), { objects: { chair: { offset: [0.1, 0, 0.8] } } });
});

test("what is turned goes on from how it was", () => {
  const chosen = /** @type {const} */ ({ kind: "object", id: "chair" });
  const from = targetOf(chosen, scene, { ...none, objects: { chair: { rotation: [0, 30, 0] } } });
  assert.ok(from);
  assert.deepEqual(turnedFrom(chosen, from, 1, Math.PI / 6), { objects: { chair: { rotation: [0, 60, 0] } } });
});

test("lights are turned that shine somewhere, and moved that have a place", () => {
  const sun = targetOf({ kind: "light", id: "sun" }, scene, none);
  assert.deepEqual([sun?.at, sun?.direction, sun?.angles], [null, DOWN, [-90, 0, -90]]);
  assert.ok(sun);
  assert.deepEqual(turnedFrom({ kind: "light", id: "sun" }, sun, 0, Math.PI / 2), { lights: { sun: { direction: [0, 0, -1] } } });
  assert.deepEqual(targetOf({ kind: "light", id: "spot" }, scene, { ...none, lights: { spot: { position: [1, 1, 1] } } })?.at, [1, 1, 1]);
  assert.equal(targetOf({ kind: "light", id: "lamp" }, scene, none), null);
  assert.deepEqual(targetOf({ kind: "light", id: "sun" }, scene, { ...none, suns: { sun: [1, 0, 0] } })?.direction, [1, 0, 0]);
});

test("an object is made larger about the middle of its box, within the scene", () => {
  const chosen = /** @type {const} */ ({ kind: "object", id: "chair" });
  const edits = { ...none, objects: { chair: { offset: /** @type {Vec3} */ ([0, 0.5, 0]), scale: 2 } } };
  const chair = targetOf(chosen, scene, edits);
  assert.deepEqual([chair?.at, chair?.size], [[0.2, 0.6, 0.1], 2]);
  assert.deepEqual([0, 7].map((corner) => chair?.corners?.[corner]?.map((value) => Number(value.toFixed(9)))), [[-0.2, 0.4, -0.1], [0.6, 0.8, 0.3]]);
  assert.deepEqual(movedTo(chosen, scene, edits, [9, 0.6, 0.1]), { objects: { chair: { offset: [0.4, 0.5, 0] } } });
  const sizes = [0.01, 1.5, 99].map((size) => sizedTo(chosen, scene, edits, size)?.objects?.chair?.scale);
  assert.deepEqual(sizes, [0.1, 1.5, 4]);
});

test("what is at an end of the scene goes no farther, which is told", () => {
  const chosen = /** @type {const} */ ({ kind: "object", id: "chair" });
  const full = { ...scene, objects: [{ id: "chair", box: bounds }] };
  assert.equal(movedTo(chosen, full, none, [0.1, 0, 0]), null);
  assert.deepEqual(movedTo(chosen, full, none, [0.0001, 0, 0]), { objects: { chair: { offset: [0, 0, 0] } } }); // held still
  assert.equal(sizedTo(chosen, full, none, 1.1), null);
  assert.deepEqual(sizedTo(chosen, full, none, 0.9), { objects: { chair: { scale: 0.9 } } });
  const edge = { ...none, objects: { chair: { offset: /** @type {Vec3} */ ([0.6, 0, 0]) } } };
  assert.equal(movedTo(chosen, scene, edge, [2, 0.1, 0.1]), null);
  assert.deepEqual(movedTo(chosen, scene, edge, [2, 0.3, 0.1]), { objects: { chair: { offset: [0.6, 0.2, 0] } } });
});
