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
/** Stages that ran once and took less since, on average, are forgotten [ms]. */
const FORGOTTEN = 0.02;

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
  /** Smoothed times of the renderer's stages [ms], in the order they run. @type {Map<string, number>} */
  stages = new Map();
  /** Times of the last frames [ms]. @type {number[]} */
  #times = [];

  /** @param {Frame} frame @param {Seen} seen @param {number} now [ms] */
  add(frame, { ageMs, decodeMs }, now) {
    this.#times = [...this.#times.filter((time) => now - time < RATE_WINDOW), now];
    this.#addStages(frame.stagesMs);
    if (ageMs === null) return;
    const parts = partsOf(frame, ageMs, decodeMs);
    this.latency = smooth(this.latency ?? undefined, ageMs);
    this.history = [...this.history.slice(1 - HISTORY), parts];
    const before = this.parts;
    this.parts = { ...parts };
    for (const name of PARTS) this.parts[name] = smooth(before?.[name], parts[name]);
  }

  /** @param {Readonly<Record<string, number>>} times [ms]; stages that did not run took none */
  #addStages(times) {
    const order = merged([...this.stages.keys()], Object.keys(times));
    const smoothed = order.map((name) => /** @type {const} */ ([name, smooth(this.stages.get(name), times[name] ?? 0)]));
    this.stages = new Map(smoothed.filter(([name, ms]) => name in times || ms >= FORGOTTEN));
  }

  /** Frames a second; null while the picture is still. @param {number} now [ms] */
  rate(now) {
    const [first, last] = [this.#times[0], this.#times.at(-1)];
    if (first === undefined || last === undefined || now - last > STILL || last === first) return null;
    return (1000 * (this.#times.length - 1)) / (last - first);
  }
}

/**
 * Known names and new ones, each of these after the one that it follows.
 * @param {readonly string[]} known @param {readonly string[]} names in their order
 */
function merged(known, names) {
  const order = [...known];
  names.forEach((name, index) => {
    if (!order.includes(name)) order.splice(order.indexOf(names[index - 1] ?? "") + 1, 0, name);
  });
  return order;
}

/** @param {number | undefined} before @param {number} now */
const smooth = (before, now) => (before === undefined ? now : before + NEWEST * (now - before));
