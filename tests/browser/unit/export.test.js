import assert from "node:assert/strict";
import { test } from "node:test";

import { exportAddress, ExportError, withEdits } from "../../../web/export.js";

const API = new URL("http://here/walk/api/v1/");

/** @param {string} id @param {import("../../../web/protocol.js").ImportOptions} options */
const address = (id, options) =>
  exportAddress(API, /** @type {import("../../../web/protocol.js").SceneInfo} */ (/** @type {unknown} */ ({ id, options })));

test("a scene is named by its id, and by how it is read", () => {
  assert.equal(address("rooms/a hall?.glb", {}), "http://here/walk/api/v1/scenes/rooms/a%20hall%3F.glb/export.glb");
  const words = new URL(address("a.ifc", { up: "z", origin: [1, 2, 3], storeys: ["ground, east", "first"] })).searchParams;
  assert.equal(words.get("up"), "z");
  assert.equal(words.get("origin"), "1,2,3");
  assert.deepEqual(words.getAll("storeys"), ["ground, east", "first"]);
});

test("a viewer's own edits go along, and a refusal is told in the server's words", async () => {
  const edits = { time: null, animation: null, lights: { "a & b": { on: false } }, materials: {}, objects: {} };
  /** @type {unknown[]} */
  const asked = [];
  const { fetch } = globalThis;
  const answers = [new Response("glTF"), new Response('{"message": "too busy"}', { status: 429 })];
  globalThis.fetch = async (url, init) => {
    asked.push([url, init?.method, JSON.parse(String(init?.body))]);
    return /** @type {Response} */ (answers.shift());
  };
  const url = address("a.ifc", { up: "z" });
  assert.equal(await (await withEdits(url, edits)).text(), "glTF");
  assert.deepEqual(asked, [[url, "POST", edits]]);
  await assert.rejects(withEdits(url, edits), new ExportError("too busy"));
  globalThis.fetch = fetch;
});
