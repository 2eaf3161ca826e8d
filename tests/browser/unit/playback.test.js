import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { Playback } from "../../../web/playback.js";

/** @type {Playback} */
let playback;

beforeEach(() => {
  playback = new Playback();
  playback.seconds = 2;
});

/** Looks every tenth of a second. @param {number} begin @param {number} end [s] */
function run(begin, end) {
  for (let step = Math.round(begin * 10); step <= Math.round(end * 10); ++step) playback.advance(step * 100);
  return Number(playback.time.toFixed(6));
}

test("it goes as fast as asked for, and only while it plays", () => {
  assert.equal(run(0, 1), 0);
  playback.play();
  assert.equal(run(5, 6), 1);
  playback.speed = 0.5;
  assert.equal(run(6, 7), 1.5);
  playback.pause();
  assert.equal(run(7, 9), 1.5);
  playback.play();
  assert.equal(run(20, 20.2), 1.6);
});

test("it begins anew at its end, or stays there", () => {
  playback.play();
  assert.equal(run(0, 2.5), 0.5);
  playback.loops = false;
  assert.equal(run(2.5, 9), 2);
  assert.equal(playback.playing, false);
  playback.play();
  assert.equal(run(9, 9.5), 0.5);
});

test("a page that was hidden goes on where it was", () => {
  playback.play();
  playback.advance(0);
  playback.advance(1e6);
  assert.equal(playback.time, 0.25);
});

test("an animation of one moment shows it", () => {
  playback.seconds = 0;
  playback.play();
  assert.equal(run(0, 1), 0);
  assert.equal(playback.playing, false);
});
