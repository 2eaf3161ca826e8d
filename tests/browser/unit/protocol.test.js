import assert from "node:assert/strict";
import { test } from "node:test";

import { isFinalClose, parseFrame } from "../../../web/protocol.js";

/** A frame as `server/wire/frame_header.py` packs it, of these stages. @param {Record<string, number>} stages [ms] */
function frame(stages = {}) {
  const text = new TextEncoder().encode(JSON.stringify(stages));
  const header = 38 + text.length;
  const bytes = new ArrayBuffer(header + 3);
  const view = new DataView(bytes);
  view.setUint8(0, 3);
  view.setUint8(1, 2);
  view.setUint16(2, header, true);
  view.setUint16(4, 640, true);
  view.setUint16(6, 360, true);
  view.setUint32(8, 7, true);
  view.setUint32(12, 4_000_000_000, true);
  view.setUint32(16, 3, true);
  [1.5, 20, 0.25].forEach((ms, slot) => view.setFloat32(20 + 4 * slot, ms, true));
  view.setUint8(32, 1);
  view.setUint8(33, 85);
  view.setUint16(34, 3, true);
  view.setUint16(36, 64, true);
  new Uint8Array(bytes, 38).set(text);
  new Uint8Array(bytes, header).set([255, 216, 255]);
  return bytes;
}

test("a frame's fields are where the protocol puts them", () => {
  const { image, ...fields } = parseFrame(frame({ gbuffer: 0.5, trace: 12 }));
  assert.deepEqual(fields, {
    codec: "png",
    phase: "still",
    quality: 85,
    samples: 3,
    targetSamples: 64,
    width: 640,
    height: 360,
    pose: 7,
    frame: 4_000_000_000,
    settings: 3,
    queueMs: 1.5,
    renderMs: 20,
    encodeMs: 0.25,
    stagesMs: { gbuffer: 0.5, trace: 12 },
  });
  assert.deepEqual([...image], [255, 216, 255]);
});

test("what is not a frame of this version is refused", () => {
  const other = frame();
  new DataView(other).setUint8(0, 1);
  assert.throws(() => parseFrame(other), /not a frame/);
  assert.throws(() => parseFrame(new ArrayBuffer(37)), /not a frame/);
  const codec = frame();
  new DataView(codec).setUint8(1, 9);
  assert.throws(() => parseFrame(codec), /codec: 9/);
  const phase = frame();
  new DataView(phase).setUint8(32, 3);
  assert.throws(() => parseFrame(phase), /phase: 3/);
});

test("the page comes back after all closes but those that are its own fault", () => {
  assert.deepEqual([1000, 1001, 1002, 1006, 1008, 1009, 1012, 1013].filter(isFinalClose), [1002, 1008, 1009]);
});
