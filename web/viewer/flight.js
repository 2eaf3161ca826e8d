/** Flies the camera along a path, in the time that the film takes. */

/** @typedef {import("../link.js").View} View */
/** @typedef {import("./camera-path.js").CameraPath} CameraPath */

/**
 * @typedef {object} FlightEvents
 * @property {(view: View, seconds: number) => void} show  the view at a time of the film
 * @property {() => void} ended  at the last view, or where it was stopped
 * @property {() => void} wake  asks for `advance` in the next animation frame
 */

export class Flight {
  /** @type {CameraPath | null} */
  #way = null;
  /** Time of the first step [ms]. @type {number | null} */
  #began = null;
  #events;

  /** @param {FlightEvents} events */
  constructor(events) {
    this.#events = events;
  }

  get flies() {
    return this.#way !== null;
  }

  /** @param {CameraPath} way */
  start(way) {
    this.stop();
    this.#way = way;
    this.#began = null;
    this.#events.wake();
  }

  stop() {
    if (!this.#way) return;
    this.#way = null;
    this.#events.ended();
  }

  /** @param {number} now [ms] @returns {boolean} whether there is more to come */
  advance(now) {
    if (!this.#way) return false;
    this.#began ??= now;
    const { start, end } = this.#way;
    const seconds = Math.min((now - this.#began) / 1000, end - start);
    this.#events.show(this.#way.at(start + seconds), seconds);
    if (seconds === end - start) this.stop();
    return this.flies;
  }
}
