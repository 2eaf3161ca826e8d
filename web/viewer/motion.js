/** Held keys as smooth motion: speed eases towards what the keys ask for, and to rest when they are let go. */

/** @typedef {import("./keys.js").Wish} Wish */

/** Seconds in which the motion closes 63 % of the way to the wished speed. */
const EASE = 0.07;
/** Of full speed; below it, motion without a wish is rest. */
const REST = 0.01;
/** The longest step taken at once [s]: a stalled page must not leap. */
const LONGEST_STEP = 0.1;

export class Motion {
  /** Right, up, forward, yaw, pitch: each of full speed. @type {[number, number, number, number, number]} */
  #speed = [0, 0, 0, 0, 0];

  /** Stands still at once. */
  stop() {
    this.#speed = [0, 0, 0, 0, 0];
  }

  /**
   * Advances by `seconds` towards the wish.
   * @param {Wish} wish
   * @param {number} seconds
   * @returns {{move: [number, number, number], turn: [number, number]} | null} how far, in seconds at full speed; null at rest
   */
  advance(wish, seconds) {
    const step = Math.min(seconds, LONGEST_STEP);
    const share = 1 - Math.exp(-step / EASE);
    const wished = [...wish.move, ...wish.turn];
    const [right, up, forward, yaw, pitch] = this.#speed;
    const eased = /** @type {[number, number, number, number, number]} */ (
      [right, up, forward, yaw, pitch].map((speed, axis) => {
        const next = speed + ((wished[axis] ?? 0) - speed) * share;
        return wished[axis] === 0 && Math.abs(next) < REST ? 0 : next;
      })
    );
    this.#speed = eased;
    if (eased.every((speed) => speed === 0)) return null;
    return {
      move: [eased[0] * step, eased[1] * step, eased[2] * step],
      turn: [eased[3] * step, eased[4] * step],
    };
  }
}
