/** What each quality costs here: as measured in this scene, or about what the server's counts of frames let expect. */

/** @typedef {import("./protocol.js").Frame} Frame */
/** @typedef {{ms: number, frames: number}} Cost  of a frame of a view at rest, and how many its final picture averages */

export class Costs {
  /** Frames that the server averages, by quality. @type {Readonly<Record<string, number>>} */
  frames = {};
  /** By quality, the one measured last at the end. @type {Map<string, Cost>} */
  #measured = new Map();
  #of = "";

  /** A frame has come, of a view at rest. @param {string} quality @param {Frame} frame @param {string} of  scene and method: what costs alike */
  learn(quality, { width, height, renderMs, stagesMs, targetSamples }, of) {
    if (Object.keys(stagesMs).every((name) => name === "display")) return; // a picture that was kept
    const what = `${of} ${width}×${height}`;
    if (what !== this.#of) this.#measured.clear();
    this.#of = what;
    const before = this.#measured.get(quality);
    this.#measured.delete(quality);
    // The first frame of a rest has to make what the others keep.
    this.#measured.set(quality, { ms: Math.min(before?.ms ?? Infinity, renderMs), frames: targetSamples });
  }

  /** @param {string} quality */
  words(quality) {
    const own = this.#measured.get(quality);
    if (own) return `${figure(own.ms)} ms a frame, sharp after ${count(own.frames)}: ${time(own)}`;
    const frames = this.frames[quality];
    if (frames === undefined) return "";
    const other = [...this.#measured.values()].at(-1);
    return `sharp after ${count(frames)} frames${other ? `: about ${time({ ms: other.ms, frames })}` : ""}`;
  }
}

/** @param {Cost} cost */
function time({ ms, frames }) {
  const seconds = (ms * frames) / 1000;
  return seconds < 90 ? `${figure(seconds)} s` : `${figure(seconds / 60)} min`;
}

/** @param {number} value */
const count = (value) => value.toLocaleString("en");

/** @param {number} value */
const figure = (value) => Number(value.toPrecision(2)).toLocaleString("en");
