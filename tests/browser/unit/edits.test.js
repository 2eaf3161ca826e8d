import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { EditHistory } from "../../../web/edits.js";

/** @typedef {import("../../../web/messages.js").ScenePatch} ScenePatch */

const RUN = "first";

/** @type {{id: number, patch: ScenePatch}[]} */
let sent = [];
/** @type {[number, boolean, boolean][]} */
let owned = [];
/** @type {EditHistory} */
let history;

beforeEach((context) => {
  const { timers } = /** @type {import("node:test").TestContext} */ (context).mock;
  timers.reset();
  timers.enable({ apis: ["setTimeout"] });
  sent = [];
  owned = [];
  history = new EditHistory((id, patch) => sent.push({ id, patch }), (...asked) => owned.push(asked), () => {});
  history.restart(false, RUN);
});

/** The server says what differs. @param {unknown} edits @param {number} edit @param {boolean} [own] */
const told = (edits, edit, own = false) => history.told(/** @type {any} */ ({ edits, edit, own, suns: {} }));

/** @param {number} intensity @returns {ScenePatch} */
const lamp = (intensity) => ({ lights: { lamp: { intensity } } });

const shown = () => history.edits.lights["lamp"]?.intensity;

test("what is on its way stays over what the server says", (context) => {
  history.edit(lamp(1), "drag");
  history.edit(lamp(2), "drag");
  assert.deepEqual(sent, [{ id: 1, patch: lamp(1) }]);
  told({ lights: { lamp: { intensity: 1 } }, materials: {}, objects: {} }, 1);
  assert.equal(shown(), 2);
  context.mock.timers.tick(50);
  assert.deepEqual(sent.at(-1), { id: 2, patch: lamp(2) });
  told({ lights: { lamp: { intensity: 7 } }, materials: {}, objects: {} }, 2);
  assert.equal(shown(), 7);
});

test("a gesture is undone as one, and done again", () => {
  for (const intensity of [1, 2, 3]) history.edit(lamp(intensity), "drag");
  history.end();
  history.edit(lamp(4), "drag");
  history.end();
  assert.equal(shown(), 4);
  history.undo();
  assert.equal(shown(), 3);
  history.undo();
  assert.equal(shown(), undefined);
  assert.equal(history.canUndo, false);
  history.redo();
  history.redo();
  assert.equal(shown(), 4);
  history.undo();
  history.edit(lamp(9));
  assert.equal(history.canRedo, false);
});

test("an undo leaves what others did elsewhere", () => {
  history.edit(lamp(2));
  told({ lights: { lamp: { intensity: 2, on: false }, sky: { on: false } }, materials: {}, objects: {} }, 1);
  history.undo();
  assert.deepEqual(JSON.parse(JSON.stringify(history.edits.lights)), { lamp: { on: false }, sky: { on: false } });
});

test("after a new start nothing is left", () => {
  history.edit(lamp(2));
  history.restart(false, RUN);
  assert.deepEqual([history.canUndo, shown()], [false, undefined]);
});

test("what was done can be undone on another connection", () => {
  history.edit(lamp(2), "drag");
  history.restart(true, RUN);
  told({ lights: { lamp: { intensity: 2 } }, materials: {}, objects: {} }, 0);
  history.edit(lamp(3), "drag"); // another gesture
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 2);
  history.undo();
  assert.equal(shown(), 2);
  history.undo();
  assert.deepEqual([shown(), history.canUndo], [undefined, false]);
});

test("what was not answered on a connection is sent on the next", () => {
  history.edit(lamp(1));
  told({ lights: { lamp: { intensity: 1 } }, materials: {}, objects: {} }, 1);
  history.edit(lamp(2), "drag");
  history.set({ time: 1 });
  history.restart(true, RUN);
  assert.deepEqual([sent.at(-1), shown(), history.edits.time], [{ id: 2, patch: { ...lamp(2), time: 1 } }, 2, 1]);
  told({ lights: { lamp: { intensity: 1 } }, materials: {}, objects: {} }, 0);
  assert.equal(shown(), 2);
  told({ lights: { lamp: { intensity: 2 } }, time: 1, materials: {}, objects: {} }, 2);
  const count = sent.length;
  history.restart(true, RUN);
  assert.equal(sent.length, count);
});

test("what is on its way in another scene is not taken for what was sent in the one before", () => {
  history.edit(lamp(2));
  history.restart(false, RUN);
  history.edit(lamp(3));
  told({ time: null, animation: null, lights: {}, materials: {}, objects: {} }, 1);
  assert.equal(shown(), 3);
});

test("what is set is sent, and no step to be undone", () => {
  history.edit(lamp(2));
  history.set({ time: 1.5 });
  assert.deepEqual([history.edits.time, history.edits.animation], [1.5, null]);
  history.undo();
  assert.deepEqual([shown(), history.edits.time, history.canUndo], [undefined, 1.5, false]);
  history.reset();
  assert.equal(history.edits.time, null);
});

test("edits are this viewer's own from when it asks, whatever others do, and nothing before can be undone", () => {
  history.edit(lamp(1));
  history.setOwn(true);
  assert.deepEqual([owned, history.own, history.canUndo], [[[2, true, false]], true, false]);
  told({ lights: {}, materials: {}, objects: {} }, 1);
  assert.equal(history.own, true); // the server does not know yet
  told({ lights: {}, materials: {}, objects: {} }, 2, false); // and refuses
  assert.equal(history.own, false);
  history.setOwn(false, true);
  assert.deepEqual(owned.at(-1), [3, false, true]);
});

test("own edits of a scene outlast a connection", (context) => {
  history.setOwn(true);
  history.edit(lamp(3));
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 2, true);
  history.restart(true, RUN);
  history.restart(true, RUN); // and one that ends before the server says what differs
  told({ lights: { sky: { on: false } }, materials: {}, objects: {} }, 0);
  assert.deepEqual([owned.at(-1), history.canUndo, shown()], [[3, true, false], true, 3]);
  context.mock.timers.tick(50);
  assert.equal(sent.length, 1); // as long as all would see them
  told({ lights: { sky: { on: false } }, materials: {}, objects: {} }, 3, true);
  context.mock.timers.tick(50);
  assert.deepEqual(sent.at(-1)?.patch.lights, { lamp: { intensity: 3 }, sky: { on: null } });
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 4, true);
  history.restart(false, RUN);
  told({ lights: {}, materials: {}, objects: {} }, 0);
  assert.deepEqual([history.own, shown()], [false, undefined]);
});

test("own edits that cannot be so on the next connection are shown to nobody", (context) => {
  history.setOwn(true);
  history.edit(lamp(3));
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 2, true);
  history.restart(true, RUN);
  told({ lights: {}, materials: {}, objects: {} }, 0);
  history.refused(3);
  told({ lights: {}, materials: {}, objects: {} }, 3);
  context.mock.timers.tick(50);
  assert.deepEqual([sent.length, shown(), history.own, history.canUndo], [1, undefined, false, false]);
});

test("what is done before own edits are so again is shown to nobody else", (context) => {
  history.restart(false, RUN, /** @type {any} */ (lamp(3)));
  history.edit({ lights: { sky: { on: false } } });
  context.mock.timers.tick(50);
  assert.deepEqual([sent, history.edits.lights], [[], { lamp: { intensity: 3 }, sky: { on: false } }]);
  told({ lights: {}, materials: {}, objects: {} }, 0);
  told({ lights: {}, materials: {}, objects: {} }, 1, true);
  assert.deepEqual([owned, sent.map(({ id }) => id)], [[[1, true, false]], [2]]);
  assert.deepEqual(sent[0]?.patch.lights, { lamp: { intensity: 3 }, sky: { on: false } });
  history.undo();
  context.mock.timers.tick(50);
  assert.deepEqual([shown(), history.edits.lights["sky"]?.on], [3, undefined]);
});

test("own edits that are given up before they are so again are sent to nobody", (context) => {
  history.restart(false, RUN, /** @type {any} */ (lamp(3)));
  told({ lights: {}, materials: {}, objects: {} }, 0);
  history.setOwn(false);
  told({ lights: {}, materials: {}, objects: {} }, 1, true);
  told({ lights: {}, materials: {}, objects: {} }, 2);
  context.mock.timers.tick(50);
  assert.deepEqual([sent, shown(), history.own], [[], undefined, false]);
});

test("sharing own edits is one step, before all that is done since", (context) => {
  const [before, after] = [{ lights: { lamp: { intensity: 1 }, spot: { on: false } } }, { lights: { lamp: { intensity: 3 }, spot: { on: false } } }];
  history.setOwn(true);
  history.edit(lamp(2));
  history.edit(lamp(3));
  told({ ...after, materials: {}, objects: {} }, 3, true);
  history.setOwn(false, true);
  history.edit({ lights: { sky: { on: false } } });
  history.told(/** @type {any} */ ({ edits: after, edit: 4, own: false, suns: {}, shared_over: before }));
  assert.deepEqual([history.canUndo, shown()], [true, 3]);
  history.undo();
  assert.deepEqual([history.edits.lights["sky"]?.on, shown(), history.canUndo], [undefined, 3, true]);
  history.undo();
  context.mock.timers.tick(50);
  assert.deepEqual([history.edits.lights["lamp"], history.edits.lights["spot"], history.canUndo], [{ intensity: 1 }, { on: false }, false]);
  history.redo();
  assert.equal(shown(), 3);
});

test("sharing what differs in nothing is no step", () => {
  history.setOwn(true);
  history.setOwn(false, true);
  history.told(/** @type {any} */ ({ edits: lamp(1), edit: 2, own: false, suns: {}, shared_over: lamp(1) }));
  assert.equal(history.canUndo, false);
});

for (const share of [false, true])
  test(`own edits that are given up without a connection are ${share ? "shared" : "shown to nobody"} on the next`, (context) => {
    history.setOwn(true);
    history.edit(lamp(3));
    told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 2, true);
    context.mock.timers.tick(50);
    history.edit({ lights: { sky: { on: false } } });
    history.setOwn(false, share);
    sent = [];
    history.restart(true, RUN);
    const lights = share ? { lamp: { intensity: 3 }, sky: { on: false } } : undefined;
    assert.deepEqual([sent.length, sent.at(-1)?.patch.lights], [Number(share), lights]);
    told({ lights: lights ?? {}, materials: {}, objects: {} }, sent.at(-1)?.id ?? 0);
    assert.deepEqual([history.own, history.edits.lights], [false, lights ?? {}]);
  });

test("own edits that the browser kept are so again", () => {
  history.restart(false, RUN, /** @type {any} */ (lamp(3)));
  assert.equal(shown(), 3);
  told({ lights: {}, materials: {}, objects: {} }, 0);
  told({ lights: {}, materials: {}, objects: {} }, 1, true);
  assert.deepEqual([owned, sent.at(-1)?.patch.lights], [[[1, true, false]], { lamp: { intensity: 3 } }]);
});

test("what the server refuses is no step to be undone", (context) => {
  const known = { lights: { lamp: { intensity: 1 } }, materials: {}, objects: {} };
  history.edit(lamp(1));
  told(known, 1);
  history.edit(lamp(-1));
  context.mock.timers.tick(50);
  history.refused(2);
  told(known, 2);
  history.undo();
  assert.equal(shown(), undefined);
  assert.equal(history.canUndo, false);
});

test("of a gesture that the server refuses the end of, what it took is done again", (context) => {
  const known = { lights: { lamp: { intensity: 1 } }, materials: {}, objects: {} };
  history.edit(lamp(1), "typed");
  told(known, 1);
  history.edit(lamp(-1), "typed");
  context.mock.timers.tick(50);
  history.refused(2);
  told(known, 2);
  history.undo();
  assert.equal(shown(), undefined);
  history.redo();
  assert.equal(shown(), 1);
});

/** Each in a message of its own. @param {import("node:test").TestContext} context @param {ScenePatch[]} patches */
function apart(context, ...patches) {
  for (const patch of patches) {
    history.edit(patch);
    context.mock.timers.tick(50);
  }
}

test("of several steps that are not answered yet the one that the server refuses is none", (context) => {
  apart(context, lamp(1), { lights: { sky: { intensity: -1 } } }, lamp(3));
  history.refused(2);
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 3);
  history.undo();
  assert.equal(shown(), 1);
  history.undo();
  assert.deepEqual([shown(), history.canUndo], [undefined, false]);
});

test("steps after one that the server refuses bring back what was before that", (context) => {
  apart(context, lamp(1), lamp(-1), lamp(3), lamp(4));
  history.undo();
  context.mock.timers.tick(50);
  history.refused(2);
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 5);
  history.undo();
  assert.equal(shown(), 1);
  history.redo();
  history.redo();
  assert.equal(shown(), 4);
  history.undo();
  assert.equal(shown(), 3);
});

test("an undo that the server refuses can be done again", (context) => {
  apart(context, lamp(1), lamp(2), lamp(3));
  told({ lights: { lamp: { intensity: 3 } }, materials: {}, objects: {} }, 3);
  history.undo();
  history.undo();
  history.undo();
  history.redo();
  context.mock.timers.tick(50);
  history.refused(5);
  assert.deepEqual([shown(), history.canUndo, history.canRedo], [2, true, true]);
  history.refused(4);
  assert.deepEqual([shown(), history.canRedo], [3, false]);
  for (const intensity of [2, 1, undefined]) {
    history.undo();
    assert.equal(shown(), intensity);
  }
});

test("of undos in several messages those that the server refuses are in force, whichever these are", (context) => {
  const undos = (/** @type {number[]} */ ...refused) => {
    history.restart(false, RUN);
    sent = [];
    apart(context, lamp(1), { lights: { sky: { intensity: 2 } } }, lamp(3));
    for (let count = 0; count < 2; count++) {
      history.undo();
      context.mock.timers.tick(50);
    }
    const [, , , first, second] = sent.map(({ id }) => id);
    for (const number of refused) history.refused(/** @type {number} */ ([first, second][number]));
  };
  undos(0, 1);
  assert.deepEqual([shown(), history.canRedo], [3, false]);
  history.undo();
  assert.deepEqual([shown(), history.edits.lights["sky"]?.intensity], [1, 2]);
  undos(0);
  assert.deepEqual([shown(), history.edits.lights["sky"]?.intensity, history.canRedo], [3, undefined, true]);
  history.redo();
  assert.deepEqual([shown(), history.edits.lights["sky"]?.intensity, history.canRedo], [3, 2, false]);
  history.undo();
  assert.deepEqual([shown(), history.edits.lights["sky"]?.intensity], [1, 2]);
});

test("what was not answered on a connection and is refused on the next is no step", () => {
  history.edit(lamp(-1));
  history.restart(true, RUN);
  history.refused(2);
  assert.deepEqual([shown(), history.canUndo], [undefined, false]);
});

test("steps of a service that is gone can be undone where the next one knows of them", () => {
  const known = { lights: { lamp: { intensity: 2 } }, materials: {}, objects: {} };
  history.edit(lamp(2));
  assert.equal(told(known, 1), false);
  history.restart(true, "second");
  assert.equal(told(known, 0), false);
  assert.equal(history.canUndo, true);
  history.restart(true, "third");
  assert.equal(told({ lights: {}, materials: {}, objects: {} }, 0), true);
  assert.deepEqual([history.canUndo, shown()], [false, undefined]);
});

test("steps of this viewer's own edits can be undone in another service", () => {
  history.setOwn(true);
  history.edit(lamp(3));
  history.restart(true, "third");
  assert.equal(history.canUndo, true);
});
