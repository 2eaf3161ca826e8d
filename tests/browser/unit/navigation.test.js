import assert from "node:assert/strict";
import { test } from "node:test";

import { Camera, distance } from "../../../web/viewer/camera.js";
import { Fly, paceIn } from "../../../web/viewer/fly.js";
import { Motion } from "../../../web/viewer/motion.js";
import { Orbit } from "../../../web/viewer/orbit.js";

/** @typedef {import("../../../web/viewer/keys.js").Wish} Wish */

/** @type {Wish} */
const rest = { move: [0, 0, 0], turn: [0, 0] };
/** @type {Wish} */
const forward = { move: [0, 0, 1], turn: [0, 0] };

test("motion eases in, keeps its pace and comes to rest", () => {
  const motion = new Motion();
  const first = motion.advance(forward, 0.01)?.move[2] ?? 0;
  let steady = 0;
  for (let step = 0; step < 100; step++) steady = motion.advance(forward, 0.01)?.move[2] ?? 0;
  assert.ok(first > 0 && first < 0.5 * steady);
  assert.ok(Math.abs(steady - 0.01) < 1e-6);
  let steps = 0;
  while (motion.advance(rest, 0.01) !== null) assert.ok(++steps < 100, "never comes to rest");
  assert.ok(steps > 5, "stops dead");
});

test("a page that stalled does not leap", () => {
  const motion = new Motion();
  motion.advance(forward, 1);
  assert.ok((motion.advance(forward, 60)?.move[2] ?? 1) <= 0.1);
});

test("flying goes a walker's pace, but for what is small or vast", () => {
  assert.deepEqual([0.1, 1, 10, 20, 100, 200, 1e4].map(paceIn), [0.012, 0.12, 1.2, 2, 2, 2, 100]);
});

test("flying goes as far as the pace says, and up is up whatever the gaze", () => {
  const camera = new Camera();
  const fly = new Fly(camera);
  fly.walk(forward, 10, false);
  const slow = -camera.position[2];
  assert.ok(slow > 0);
  fly.walk(forward, 5, false);
  assert.ok(Math.abs(-camera.position[2] - 1.5 * slow) < 1e-9);
  camera.pitch = 1;
  const before = camera.position;
  fly.walk({ move: [0, 1, 0], turn: [0, 0] }, 10, true);
  assert.deepEqual([camera.position[0], camera.position[2]], [before[0], before[2]]);
});

test("the wheel changes the flying speed within bounds", () => {
  const fly = new Fly(new Camera());
  fly.wheel(-1);
  assert.ok(fly.speed > 1);
  for (let step = 0; step < 100; step++) fly.wheel(3);
  assert.equal(fly.speed, 1 / 64);
});

test("a mouse turns the gaze along, a finger drags the scene", () => {
  const camera = new Camera();
  const fly = new Fly(camera);
  fly.look(10, 10, false);
  assert.ok(camera.yaw < 0 && camera.pitch < 0);
  fly.look(10, 10, true);
  assert.ok(camera.yaw > 0 && camera.pitch > 0);
});

test("orbiting nears the pivot but never passes it", () => {
  const camera = new Camera();
  const orbit = new Orbit(camera);
  orbit.distance = 2;
  orbit.nearest = 0.1;
  const pivot = camera.ahead(2);
  orbit.drag(100, -30);
  orbit.wheel(-1);
  assert.ok(orbit.distance < 2);
  for (let step = 0; step < 100; step++) orbit.wheel(-3);
  assert.equal(orbit.distance, 0.1);
  assert.ok(distance(camera.ahead(orbit.distance), pivot) < 1e-9);
});

test("the pivot stays under the pointer while panning", () => {
  const camera = new Camera();
  const orbit = new Orbit(camera);
  orbit.pan(10, -4, 0.5);
  assert.deepEqual(camera.position, [-5, -2, 0]);
});
