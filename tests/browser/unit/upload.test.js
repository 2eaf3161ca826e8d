import assert from "node:assert/strict";
import { afterEach, test } from "node:test";

import { listScenes, UploadError } from "../../../web/upload.js";

const { fetch } = globalThis;
afterEach(() => (globalThis.fetch = fetch));

const SCENES = new URL("http://here/walk/api/v1/scenes");

test("scenes are listed, or it is said why not", async () => {
  globalThis.fetch = async () => new Response(JSON.stringify([{ id: "hall" }]));
  assert.deepEqual(await listScenes(SCENES), [{ id: "hall" }]);
  globalThis.fetch = async () => new Response("", { status: 503 });
  await assert.rejects(listScenes(SCENES), new UploadError("The server does not list its scenes (status 503)."));
  globalThis.fetch = () => Promise.reject(new TypeError());
  await assert.rejects(listScenes(SCENES), UploadError);
});
