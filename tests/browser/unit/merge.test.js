import assert from "node:assert/strict";
import { test } from "node:test";

import { compose, difference, inverse, merge, removal, replaced, without } from "../../../web/merge.js";

const target = { lights: { lamp: { on: false, color: [1, 0, 0] } }, materials: {} };
const patches = [
  { lights: { lamp: { on: true } } },
  { lights: { lamp: { on: null } } },
  { lights: { sky: { intensity: 2 } }, materials: { wall: { color: [0, 0, 1] } } },
  { lights: { lamp: { color: null }, sky: { on: false } } },
];

test("a patch changes what it names, and null takes away", () => {
  const changed = merge(target, patches[3]);
  assert.deepEqual(changed, { lights: { lamp: { on: false }, sky: { on: false } }, materials: {} });
  assert.deepEqual(merge(target, { lights: null }), { materials: {} });
  assert.deepEqual(said(merge(target, removal(target))), {});
});

/** The parts of edits that say something. @param {unknown} edits @returns {unknown} */
function said(edits) {
  if (typeof edits !== "object" || edits === null || Array.isArray(edits)) return edits;
  const parts = Object.entries(edits).map(([name, value]) => [name, said(value)]);
  return Object.fromEntries(parts.filter(([, value]) => JSON.stringify(value) !== "{}"));
}

test("the difference of two is the patch that makes one of the other, and names nothing else", () => {
  const all = [target, {}, ...patches.map((patch) => merge(target, patch))];
  for (const from of all) for (const to of all) assert.deepEqual(said(merge(from, difference(from, to))), said(to));
  assert.deepEqual(difference({ time: 1, lights: { lamp: { on: false, color: null } } }, { time: null, lights: { lamp: { on: false } } }), { time: null });
});

test("two patches in one do what they do after each other", () => {
  for (const first of patches) {
    for (const second of patches) {
      assert.deepEqual(said(merge(target, compose(first, second))), said(merge(merge(target, first), second)));
    }
  }
});

test("an inverse brings back what was", () => {
  for (const patch of patches) assert.deepEqual(said(merge(merge(target, patch), inverse(target, patch))), said(target));
});

test("a patch takes values of another, or goes without what that changes", () => {
  const patch = { lights: { lamp: { on: true, color: [0, 1, 0] }, sky: { on: false } }, time: 1 };
  const other = { lights: { lamp: { on: null, intensity: 3 } }, time: 2, materials: {} };
  assert.deepEqual(replaced(patch, other), { lights: { lamp: { on: null, color: [0, 1, 0] }, sky: { on: false } }, time: 2 });
  assert.deepEqual(without(patch, other), { lights: { lamp: { color: [0, 1, 0] }, sky: { on: false } } });
});
