import assert from "node:assert/strict";
import { test } from "node:test";

import { CameraPath } from "../../../web/viewer/camera-path.js";
import { Flight } from "../../../web/viewer/flight.js";

/** @type {import("../../../web/link.js").View} */
const view = { at: [0, 0, 0], look: [0, 0], yfov: 1 };
const way = new CameraPath([{ time: 1, view }, { time: 3, view: { ...view, at: [2, 0, 0] } }]);

function flown() {
  /** @type {[number, number][]} */
  const shown = [];
  const counts = { ended: 0, woken: 0 };
  const flight = new Flight({
    show: (seen, seconds) => shown.push([seen.at[0], seconds]),
    ended: () => (counts.ended += 1),
    wake: () => (counts.woken += 1),
  });
  return { flight, shown, counts };
}

test("a flight takes the film's time and ends at its last view", () => {
  const { flight, shown, counts } = flown();
  assert.equal(flight.advance(0), false);
  flight.start(way);
  assert.equal(counts.woken, 1);
  assert.deepEqual([10_000, 10_500, 12_500].map((now) => flight.advance(now)), [true, true, false]);
  assert.deepEqual(shown, [[0, 0], [0.5, 0.5], [2, 2]]);
  assert.deepEqual([counts.ended, flight.flies], [1, false]);
});

test("a flight that is stopped stays where it is", () => {
  const { flight, shown, counts } = flown();
  flight.start(way);
  flight.advance(0);
  flight.stop();
  flight.stop();
  assert.equal(flight.advance(16), false);
  assert.deepEqual([shown.length, counts.ended], [1, 1]);
});
