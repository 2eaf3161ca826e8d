/** What the overlay shows, from frames as they come: smoothed, so that figures can be read. */

/** @typedef {import("../protocol.js").Frame} Frame */
/** @typedef {import("../session.js").Seen} Seen */

/** Where the time between sending a pose and seeing it goes, in the order in which it is spent. */
export const PARTS = /** @type {const} */ (["queue", "render", "encode", "network", "decode"]);
/** @typedef {Record<typeof PARTS[number], number>} Parts  [ms] */

/** Weight of the newest value. */
const NEWEST = 0.25;
/** Window of the frame rate [ms]. */
const RATE_WINDOW = 2000;
/** Without a frame for this long the picture is still [ms]. */
const STILL = 1000;
/** Frames that the timeline goes back. */
const HISTORY = 59;

/** @param {Frame} frame @param {number} ageMs @param {number} decodeMs @returns {Parts} the network's is what no one else claims */
export function partsOf({ queueMs: queue, renderMs: render, encodeMs: encode }, ageMs, decodeMs) {
  const network = Math.max(0, ageMs - queue - render - encode - decodeMs);
  return { queue, render, encode, network, decode: decodeMs };
}

export class Statistics {
  /** From sending a pose to seeing it [ms]; null before the first. @type {number | null} */
  latency = null;
  /** Smoothed parts of it. @type {Parts | null} */
  parts = null;
  /** Of the last frames that showed a new pose, the oldest first. @type {Parts[]} */
  history = [];
  /** Smoothed times of the renderer's stages [ms]. @type {Map<string, number>} */
  stages = new Map();
  /** Times of the last frames [ms]. @type {number[]} */
  #times = [];

  /** @param {Frame} frame @param {readonly string[]} stages names of `frame.stagesMs` @param {Seen} seen @param {number} now [ms] */
  add(frame, stages, { ageMs, decodeMs }, now) {
    this.#times = [...this.#times.filter((time) => now - time < RATE_WINDOW), now];
    stages.forEach((name, slot) => this.stages.set(name, smooth(this.stages.get(name), frame.stagesMs[slot] ?? 0)));
    if (ageMs === null) return;
    const parts = partsOf(frame, ageMs, decodeMs);
    this.latency = smooth(this.latency ?? undefined, ageMs);
    this.history = [...this.history.slice(1 - HISTORY), parts];
    const before = this.parts;
    this.parts = { ...parts };
    for (const name of PARTS) this.parts[name] = smooth(before?.[name], parts[name]);
  }

  /** Frames a second; null while the picture is still. @param {number} now [ms] */
  rate(now) {
    const [first, last] = [this.#times[0], this.#times.at(-1)];
    if (first === undefined || last === undefined || now - last > STILL || last === first) return null;
    return (1000 * (this.#times.length - 1)) / (last - first);
  }
}

/** @param {number | undefined} before @param {number} now */
const smooth = (before, now) => (before === undefined ? now : before + NEWEST * (now - before));
