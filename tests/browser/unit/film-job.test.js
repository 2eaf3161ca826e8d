import assert from "node:assert/strict";
import { afterEach, test } from "node:test";

import { FilmError, findFilm } from "../../../web/film-job.js";

const { fetch } = globalThis;
afterEach(() => (globalThis.fetch = fetch));

const API = new URL("http://here/walk/api/v1/");
const JOB = { url: "/walk/api/v1/jobs/1", state: "running" };

/** @param {number} status @param {unknown} body */
const answer = (status, body) => (globalThis.fetch = async () => new Response(JSON.stringify(body), { status }));

test("a film is found again, or is known to be gone", async () => {
  answer(200, [{ url: "/walk/api/v1/jobs/0" }, JOB]);
  assert.deepEqual(await findFilm(API, JOB.url), JOB);
  answer(200, []);
  assert.equal(await findFilm(API, JOB.url), null);
});

test("a server that does not say is not one that knows of it no more", async () => {
  answer(503, { code: "stopping" });
  await assert.rejects(findFilm(API, JOB.url), FilmError);
  globalThis.fetch = () => Promise.reject(new TypeError());
  await assert.rejects(findFilm(API, JOB.url));
});
