import assert from "node:assert/strict";
import { test } from "node:test";

import { archiveName } from "../../../web/dropped.js";

const file = /** @type {File} */ ({});
/** @param {...string} paths */
const named = (...paths) => archiveName(paths.map((path) => ({ path, file })), [".gltf", ".obj"]);

test("an archive is called as the folder, or as the scene in it", () => {
  assert.equal(named("house/scene.gltf", "house/maps/a.png"), "house.zip");
  assert.equal(named("a.png", "my.scene.GLTF", "other.obj"), "my.scene.zip");
  assert.equal(named("maps/a.png", "scene.obj"), "scene.zip");
  assert.equal(named("a.png", "b.png"), "a.zip");
  assert.equal(named("one/a.obj", "two/b.png"), "a.zip");
});
