import assert from "node:assert/strict";
import { test } from "node:test";

import { decimalsOf, toFile, toWorld } from "../../../web/frame.js";
import { readLink, writeLink } from "../../../web/link.js";

/** @type {import("../../../web/protocol.js").SceneFrame} */
const survey = { up: "z", metres_per_unit: 0.001, origin: [456789123, 5432100456, 120789] };

test("z up becomes y up, in metres from the origin", () => {
  const [x, y, z] = toWorld(survey, [456790123, 5432102456, 123789]);
  assert.deepEqual([x, y, z], [1, 3, -2]);
});

test("coordinates of a survey come back from a link to the tenth of a millimetre", () => {
  const at = /** @type {const} */ ([456789987.1, 5432100123.4, 122389.5]);
  const there = toFile(survey, toWorld(survey, [...at]));
  const words = writeLink("house.ifc", { at: there, look: [0, 0], yfov: 1 }, decimalsOf(survey, 20), {});
  assert.match(words, /at=456789987.1,5432100123.4,122389.5&/);
  assert.deepEqual(readLink(words).view?.at, [...at]);
});

test("positions are told as finely as a scene is small", () => {
  const metres = { ...survey, metres_per_unit: 1 };
  assert.equal(decimalsOf(metres, 1e6), 4);
  assert.equal(decimalsOf(metres, 10), 4);
  assert.equal(decimalsOf(metres, 0.1), 6);
  assert.equal(decimalsOf(survey, 10), 1);
});
