import assert from "node:assert/strict";
import { test } from "node:test";

import { pause } from "../../../web/connection.js";
import { partsOf, Statistics } from "../../../web/ui/statistics.js";

/** @type {import("../../../web/protocol.js").Frame} */
const frame = {
  codec: "jpeg",
  phase: "moving",
  quality: 85,
  samples: 1,
  targetSamples: 1,
  width: 4,
  height: 2,
  pose: 1,
  frame: 1,
  settings: 0,
  queueMs: 2,
  renderMs: 10,
  encodeMs: 1,
  stagesMs: { gbuffer: 4, shade: 6 },
  image: new Uint8Array(),
};

test("the frame rate is that of the last frames, and none when the picture is still", () => {
  const statistics = new Statistics();
  for (let now = 0; now <= 3000; now += 50) statistics.add(frame, { decodeMs: 1, ageMs: null }, now);
  assert.equal(Math.round(statistics.rate(3000) ?? 0), 20);
  assert.equal(statistics.rate(4500), null);
});

test("latency is split into the parts of its way; what no one claims is the network's", () => {
  assert.deepEqual(partsOf(frame, 20, 3), { queue: 2, render: 10, encode: 1, network: 4, decode: 3 });
  assert.equal(partsOf(frame, 15, 3).network, 0);
});

test("figures are smoothed; a frame of a pose that was seen before says nothing of latency", () => {
  const statistics = new Statistics();
  statistics.add(frame, { decodeMs: 3, ageMs: 20 }, 0);
  assert.equal(statistics.latency, 20);
  assert.deepEqual([...statistics.stages], [["gbuffer", 4], ["shade", 6]]);
  statistics.add({ ...frame, renderMs: 900 }, { decodeMs: 3, ageMs: null }, 10);
  assert.equal(statistics.latency, 20);
  assert.equal(statistics.history.length, 1);
  statistics.add(frame, { decodeMs: 3, ageMs: 40 }, 20);
  assert.equal(statistics.latency, 25);
  assert.equal(statistics.parts?.network, 9);
});

test("stages are those that frames bring, in the order they run; one that runs no more is forgotten", () => {
  const statistics = new Statistics();
  const seen = { decodeMs: 1, ageMs: null };
  statistics.add(frame, seen, 0);
  statistics.add({ ...frame, stagesMs: { first: 1, gbuffer: 4, cluster: 2, shade: 6 } }, seen, 10);
  assert.deepEqual([...statistics.stages.keys()], ["first", "gbuffer", "cluster", "shade"]);
  statistics.add({ ...frame, stagesMs: { trace: 5 } }, seen, 20);
  assert.equal(statistics.stages.get("shade"), 4.5);
  for (let now = 30; now < 400; now += 10) statistics.add({ ...frame, stagesMs: { trace: 5 } }, seen, now);
  assert.deepEqual([...statistics.stages], [["trace", 5]]);
});

test("the timeline forgets the oldest frames", () => {
  const statistics = new Statistics();
  for (let now = 0; now < 500; now++) statistics.add(frame, { decodeMs: now, ageMs: 1000 }, now);
  assert.ok(statistics.history.length < 100);
  assert.equal(statistics.history.at(-1)?.decode, 499);
});

test("pauses between attempts grow, up to a limit", () => {
  const pauses = Array.from({ length: 12 }, (_, attempt) => pause(attempt));
  assert.ok(pauses.every((seconds, index) => index === 0 || seconds >= (pauses[index - 1] ?? 0)));
  assert.deepEqual([pauses[0], pauses.at(-1)], [0.5, 10]);
});
