/** A gamepad of the standard layout as held keys are: sticks move and turn, triggers go down and up. */

import { bothOf } from "./keys.js";

/** @typedef {import("./keys.js").Wish} Wish */

/** @type {Wish} */
const REST = { move: [0, 0, 0], turn: [0, 0] };
/** Of a stick's way, which a worn one shows at rest. */
const DEAD = 0.15;
const TRIGGERS = { left: 6, right: 7 };
const BUMPERS = [4, 5];
/** Of the right hand: X and Y on many. */
const FACE = { left: 2, above: 3 };

/** @param {number} value of an axis, −1 to 1 @returns {number} 0 within the dead zone, gentle near it, still 1 at the end */
export function ease(value) {
  const way = Math.max(0, Math.abs(value) - DEAD) / (1 - DEAD);
  return value < 0 ? -(way ** 2) : way ** 2;
}

/** @param {Pick<Gamepad, "axes" | "buttons">} pad @returns {Wish} */
export function wishOf({ axes, buttons }) {
  const [moveX = 0, moveY = 0, turnX = 0, turnY = 0] = axes.map(ease);
  const up = (buttons[TRIGGERS.right]?.value ?? 0) - (buttons[TRIGGERS.left]?.value ?? 0);
  // Pushed forward, a stick's y is negative.
  return { move: [moveX, up, 0 - moveY], turn: [0 - turnX, 0 - turnY] };
}

/** Watches gamepads while one is connected, and only then. */
export class Gamepads {
  /** Of all gamepads together. @type {Wish} */
  wish = REST;
  /** A bumper is held: move faster. */
  fast = false;

  #wake;
  #actions;
  #polling = false;
  /** Buttons that were down at the last look. @type {Set<number>} */
  #down = new Set();

  /** @param {() => void} wake called while a stick is out of its middle @param {{home: () => void, mode: () => void}} actions */
  constructor(wake, actions) {
    this.#wake = wake;
    this.#actions = new Map([[FACE.above, actions.home], [FACE.left, actions.mode]]);
    window.addEventListener("gamepadconnected", () => this.#start());
  }

  #start() {
    if (this.#polling) return;
    this.#polling = true;
    const look = () => {
      const pads = navigator.getGamepads().filter((pad) => pad?.mapping === "standard");
      this.#polling = pads.length > 0;
      this.#read(pads.flatMap((pad) => pad ?? []));
      if (this.#polling) requestAnimationFrame(look);
    };
    look();
  }

  /** @param {Gamepad[]} pads */
  #read(pads) {
    const wish = pads.map(wishOf).reduce(bothOf, REST);
    this.wish = wish;
    this.fast = pads.some(({ buttons }) => BUMPERS.some((button) => buttons[button]?.pressed));
    if ([...wish.move, ...wish.turn].some((value) => value !== 0)) this.#wake();

    const down = new Set(pads.flatMap(({ buttons }) => buttons.flatMap(({ pressed }, index) => (pressed ? [index] : []))));
    for (const [button, action] of this.#actions) if (down.has(button) && !this.#down.has(button)) action();
    this.#down = down;
  }
}
