import assert from "node:assert/strict";
import { test } from "node:test";

import { Changes } from "../../../web/changes.js";

/** @typedef {import("../../../web/protocol.js").Change} Change */

/** @param {(changes: Changes, sent: [number, Change][]) => void | Promise<void>} body */
async function withChanges(body) {
  /** @type {[number, Change][]} */
  const sent = [];
  const changes = new Changes((id, change) => sent.push([id, change]));
  await body(changes, sent);
  changes.restart(); // ends the timer
}

test("the first change goes at once, newer ones merge until a frame answers it", () =>
  withChanges((changes, sent) => {
    changes.ask({ size: [10, 10] });
    changes.ask({ size: [20, 20] });
    changes.ask({ settings: { samples: 2 } });
    changes.ask({ size: [30, 30] });
    assert.deepEqual(sent, [[1, { size: [10, 10] }]]);
    changes.rendered(0); // ordered before the change
    assert.equal(sent.length, 1);
    changes.rendered(1);
    assert.deepEqual(sent.slice(1), [[2, { size: [30, 30], settings: { samples: 2 } }]]);
    changes.rendered(2);
    assert.equal(sent.length, 2);
  }));

test("a frame is current when it has all that was asked for", () =>
  withChanges((changes) => {
    assert.ok(changes.isCurrent(0));
    changes.ask({ size: [10, 10] });
    assert.ok(!changes.isCurrent(0));
    assert.ok(changes.isCurrent(1));
    changes.ask({ size: [20, 20] });
    assert.ok(!changes.isCurrent(1), "another change waits");
  }));

test("a refusal answers, and changes nothing", () =>
  withChanges((changes, sent) => {
    changes.ask({ size: [10, 10] });
    assert.deepEqual(changes.refused(), { size: [10, 10] });
    assert.ok(changes.isCurrent(0));
    changes.ask({ size: [20, 20] });
    assert.equal(sent.length, 2);
  }));

test("a slow answer holds nothing up for long", () =>
  withChanges(async (changes, sent) => {
    changes.ask({ settings: { samples: 4096 } });
    changes.ask({ settings: {} });
    while (sent.length < 2) await new Promise((resolve) => setTimeout(resolve, 20));
    assert.deepEqual(sent[1], [2, { settings: {} }]);
  }));

test("on a new connection ids start anew and nothing waits", () =>
  withChanges((changes, sent) => {
    changes.ask({ size: [10, 10] });
    changes.ask({ size: [20, 20] });
    changes.restart();
    assert.ok(changes.isCurrent(0));
    changes.ask({ size: [30, 30] });
    assert.deepEqual(sent.at(-1), [1, { size: [30, 30] }]);
    assert.equal(sent.length, 2);
  }));
