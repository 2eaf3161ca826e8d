/** What the overlay shows, from frames as they come: smoothed, so that figures can be read. */

/** @typedef {import("../protocol.js").Frame} Frame */
/** @typedef {{name: string, ms: number, transport: boolean}} Part  transport: on the way rather than in the renderer */

/** Weight of the newest value. */
const NEWEST = 0.25;
/** Window of the frame rate [ms]. */
const RATE_WINDOW = 2000;
/** Without a frame for this long the picture is still [ms]. */
const STILL = 1000;

export class Statistics {
  /** @type {Map<string, Part>} */
  #parts = new Map();
  /** Times of the last frames [ms]. @type {number[]} */
  #times = [];
  /** From sending a pose to seeing it [ms]; null before the first. @type {number | null} */
  latency = null;

  /**
   * @param {Frame} frame
   * @param {readonly string[]} stages names of `frame.stagesMs`
   * @param {{now: number, decodeMs: number, latencyMs: number | null}} seen
   */
  add(frame, stages, seen) {
    this.#times = [...this.#times.filter((time) => seen.now - time < RATE_WINDOW), seen.now];
    this.#update("queue", frame.queueMs, true);
    stages.forEach((name, slot) => this.#update(name, frame.stagesMs[slot] ?? 0, false));
    this.#update("encode", frame.encodeMs, true);
    if (seen.latencyMs !== null) {
      this.latency = smooth(this.latency, seen.latencyMs);
      const rest = seen.latencyMs - frame.queueMs - frame.renderMs - frame.encodeMs - seen.decodeMs;
      this.#update("network", Math.max(rest, 0), true);
    }
    this.#update("decode", seen.decodeMs, true);
  }

  /** Frames a second; null while the picture is still. @param {number} now [ms] */
  rate(now) {
    const [first, last] = [this.#times[0], this.#times.at(-1)];
    if (first === undefined || last === undefined || now - last > STILL || last === first) return null;
    return (1000 * (this.#times.length - 1)) / (last - first);
  }

  /** Where the time of a frame goes, in the order in which it is spent. @returns {Part[]} */
  get parts() {
    return [...this.#parts.values()];
  }

  /** @param {string} name @param {number} ms @param {boolean} transport */
  #update(name, ms, transport) {
    this.#parts.set(name, { name, ms: smooth(this.#parts.get(name)?.ms ?? null, ms), transport });
  }
}

/** @param {number | null} before @param {number} now */
const smooth = (before, now) => (before === null ? now : before + NEWEST * (now - before));
