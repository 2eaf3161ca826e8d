import assert from "node:assert/strict";
import { test } from "node:test";

import { readLink, writeLink } from "../../../web/link.js";

/** @type {import("../../../web/link.js").View} */
const view = { at: [1.5, -0.25, 1234.5678], look: [Math.PI / 4, -0.1], yfov: 1 };

test("a link gives back the scene, the view and the settings, and can be read", () => {
  const words = writeLink("rooms/große halle.glb", view, 2, { method: "path", samples: 4 });
  assert.match(words, /^scene=rooms\/gro%C3%9Fe\+halle.glb&at=1.5,-0.25,1234.57&look=45,-5.73&fov=57.3&method=path&samples=4$/);
  const link = readLink(`#${words}`);
  assert.equal(link.scene, "rooms/große halle.glb");
  assert.deepEqual(link.settings, { method: "path", samples: "4" });
  assert.deepEqual(link.view?.at, [1.5, -0.25, 1234.57]);
  assert.ok(Math.abs((link.view?.look[0] ?? 0) - Math.PI / 4) < 1e-4);
  assert.ok(Math.abs((link.view?.yfov ?? 0) - 1) < 1e-3);
});

test("a link keeps where a section begins", () => {
  const words = writeLink("hall", { ...view, near: 4.25 }, 2, {});
  assert.match(words, /&fov=57.3&near=4.25$/);
  assert.equal(readLink(words).view?.near, 4.25);
  assert.equal(readLink(words.replace("4.25", "-1")).view?.near, undefined);
});

test("a link may say a part only", () => {
  assert.deepEqual(readLink(""), { settings: {} });
  assert.deepEqual(readLink("#scene=atrium"), { scene: "atrium", settings: {} });
  assert.deepEqual(readLink("#samples=4"), { settings: { samples: "4" } });
});

test("junk in a link is passed over", () => {
  for (const hash of ["#%%%", "#=&=&", "#at=1,2&look=1,2&fov=50", "#at=1,2,x&look=1,2&fov=50", "#at=1,2,3&look=1,2&fov=0"]) {
    assert.equal(readLink(hash).view, undefined, hash);
  }
  assert.equal(readLink("#at=1,2,1e99&look=0,0&fov=50").view, undefined);
  assert.equal(readLink("#at=1,,3&look=0,0&fov=50").view, undefined);
  assert.equal(readLink("#at=1,2,3&look=0,0&fov=Infinity").view, undefined);
  assert.deepEqual(readLink(`#scene=${"a".repeat(5000)}`), { settings: {} });
});
