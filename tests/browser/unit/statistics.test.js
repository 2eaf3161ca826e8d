import assert from "node:assert/strict";
import { test } from "node:test";

import { pause } from "../../../web/connection.js";
import { Statistics } from "../../../web/ui/statistics.js";

/** @type {import("../../../web/protocol.js").Frame} */
const frame = {
  codec: "image/jpeg",
  width: 4,
  height: 2,
  pose: 1,
  frame: 1,
  settings: 0,
  queueMs: 2,
  renderMs: 10,
  encodeMs: 1,
  stagesMs: [4, 6],
  image: new Uint8Array(),
};

test("the frame rate is that of the last frames, and none when the picture is still", () => {
  const statistics = new Statistics();
  for (let now = 0; now <= 3000; now += 50) statistics.add(frame, [], { now, decodeMs: 1, latencyMs: null });
  assert.equal(Math.round(statistics.rate(3000) ?? 0), 20);
  assert.equal(statistics.rate(4500), null);
});

test("latency is split into the parts of its way; what no one claims is the network's", () => {
  const statistics = new Statistics();
  statistics.add(frame, ["gbuffer", "shade"], { now: 0, decodeMs: 3, latencyMs: 20 });
  assert.deepEqual(
    statistics.parts.map(({ name, ms }) => [name, ms]),
    [["queue", 2], ["gbuffer", 4], ["shade", 6], ["encode", 1], ["network", 4], ["decode", 3]],
  );
  assert.equal(statistics.latency, 20);
});

test("pauses between attempts grow, up to a limit", () => {
  const pauses = Array.from({ length: 12 }, (_, attempt) => pause(attempt));
  assert.ok(pauses.every((seconds, index) => index === 0 || seconds >= (pauses[index - 1] ?? 0)));
  assert.deepEqual([pauses[0], pauses.at(-1)], [0.5, 10]);
});
