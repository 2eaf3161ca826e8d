import assert from "node:assert/strict";
import { test } from "node:test";

import { filmOf, keepFilm, pathOf, PathError, stopsOf, timesOf, wayOf } from "../../../web/film.js";
import { keepAnew } from "./kept.js";

/** @typedef {import("../../../web/film.js").Stop} Stop */
/** @type {Stop} */
const door = { name: "door", view: { at: [1, 2, 3], look: [0.5, -0.25], yfov: 1, near: 0.5 }, seconds: 3 };
/** @type {Stop} */
const yard = { name: "yard", view: { at: [9, 2, 3], look: [-2, 0.25], yfov: 0.8 }, seconds: 2.5 };
const matrix = [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 5, 6, 7, 1];
const scene = /** @type {import("../../../web/protocol.js").SceneInfo} */ (
  /** @type {unknown} */ ({
    cameras: [{ name: "hall", matrix, yfov: 1.2, aspect: 1, orthographic: false, near: 0 }],
    frame: { up: "z", metres_per_unit: 0.001, origin: [456_789_000, 5_432_100_000, 0] },
  })
);
const kept = keepAnew();

/** @param {Stop} actual @param {Stop} expected */
function close(actual, expected) {
  const numbers = (/** @type {Stop} */ { view: { at, look, yfov, near }, seconds }) => [...at, ...look, yfov, near ?? 0, seconds];
  const found = numbers(actual);
  numbers(expected).forEach((value, index) => assert.ok(Math.abs(value - (found[index] ?? NaN)) < 1e-6, `${found}`));
  assert.equal(actual.name, expected.name);
}

test("each scene has its own film, and junk in it is passed over", () => {
  assert.ok(keepFilm("hall", [door, yard]));
  assert.deepEqual(filmOf("hall"), [door, yard]);
  assert.deepEqual(filmOf("attic"), []);
  kept.set("lumenwalk film hall", JSON.stringify([null, { ...door, seconds: 0 }, { ...door, view: {} }, yard]));
  assert.deepEqual(filmOf("hall"), [yard]);
  assert.equal(keepFilm("hall", Array(201).fill(door)), false);
});

test("the camera is at each stop when the ways before it have taken their time", () => {
  assert.deepEqual(timesOf([door, yard, door]), [0, 2.5, 5.5]);
  const way = wayOf([door, yard, door]);
  assert.equal(way.end, 5.5);
  assert.deepEqual(way.at(2.5).at, yard.view.at);
});

test("a path goes to a file and comes back, in the coordinates of the scene's file", () => {
  const stops = [door, yard].map((stop) => ({ ...stop, view: { ...stop.view, at: /** @type {[number, number, number]} */ ([456_790_500 + stop.view.at[0], 5_432_102_000, 1600]) } }));
  const path = pathOf(stops, scene);
  assert.deepEqual(path.keyframes.map(({ time, name }) => [time, name]), [[0, "door"], [2.5, "yard"]]);
  assert.deepEqual(path.keyframes[0]?.camera.position, stops[0]?.view.at);
  const [first, second] = stopsOf(JSON.stringify(path), scene);
  assert.ok(first && second && stops[0] && stops[1]);
  close(first, stops[0]);
  close(second, stops[1]);
});

test("a path may name the scene's cameras", () => {
  const text = JSON.stringify({ keyframes: [{ time: 1, camera: 0 }, { time: 3, camera: "hall", name: "again" }] });
  const [first, again] = stopsOf(text, scene);
  assert.deepEqual([first?.name, again?.name, again?.seconds], ["View 1", "again", 2]);
  assert.deepEqual(first?.view.at, [456_794_000, 5_432_093_000, 6000]);
  assert.ok(Math.abs((first?.view.look[0] ?? 0) - Math.PI / 2) < 1e-9);
});

for (const [what, text, words] of /** @type {const} */ ([
  ["no JSON", "{", /it is not JSON/],
  ["no keyframes", "{}", /needs "keyframes"/],
  ["one keyframe", '{"keyframes": [{"time": 0, "camera": 0}]}', /2 to 200/],
  ["times that do not grow", '{"keyframes": [{"time": 1, "camera": 0}, {"time": 1, "camera": 0}]}', /^keyframes\[1\]\.time: .* after 1/],
  ["an unknown camera", '{"keyframes": [{"time": 0, "camera": 0}, {"time": 1, "camera": "attic"}]}', /^keyframes\[1\]\.camera: is no camera/],
  ["junk", '{"keyframes": [null, 3]}', /^keyframes\[0\]/],
])) {
  test(`${what} is said of a file`, () => {
    assert.throws(() => stopsOf(text, scene), (error) => error instanceof PathError && words.test(error.message));
  });
}
