/** Which movement keys are held, by key code (`event.code`), so that a keyboard's layout does not matter. */

/**
 * Right, up and forward; yaw to the left and pitch up: each from −1 to 1.
 * @typedef {{move: [number, number, number], turn: [number, number]}} Wish
 */

const MOVES = new Map(
  /** @type {[string, [number, number, number]][]} */ ([
    ["KeyD", [1, 0, 0]],
    ["KeyA", [-1, 0, 0]],
    ["KeyE", [0, 1, 0]],
    ["KeyQ", [0, -1, 0]],
    ["KeyW", [0, 0, 1]],
    ["KeyS", [0, 0, -1]],
  ]),
);
const TURNS = new Map(
  /** @type {[string, [number, number]][]} */ ([
    ["ArrowLeft", [1, 0]],
    ["ArrowRight", [-1, 0]],
    ["ArrowUp", [0, 1]],
    ["ArrowDown", [0, -1]],
  ]),
);

export class HeldKeys {
  /** @type {Set<string>} */
  #held = new Set();

  /** Shift held: move faster. */
  fast = false;

  /** @param {Window} window @param {() => void} onChange called when a key goes down or up */
  constructor(window, onChange) {
    window.addEventListener("keydown", (event) => {
      this.fast = event.shiftKey;
      if (!this.#isMovement(event)) return;
      event.preventDefault();
      this.#held.add(event.code);
      onChange();
    });
    window.addEventListener("keyup", (event) => {
      this.fast = event.shiftKey;
      if (event.key === "Meta") release(); // on a Mac, what is let go while it is held is never seen
      if (this.#held.delete(event.code)) onChange();
    });
    // A key released elsewhere is never seen here: let go of all when the page loses the keyboard.
    const release = () => {
      this.#held.clear();
      onChange();
    };
    window.addEventListener("blur", release);
    window.document.addEventListener("visibilitychange", release);
  }

  /** Ctrl, Alt and Meta belong to the browser, and keys typed into a control belong to it. @param {KeyboardEvent} event */
  #isMovement(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return false;
    return !belongsToControl(event) && (MOVES.has(event.code) || TURNS.has(event.code));
  }

  /** Sum of what the held keys ask for; opposite keys cancel. @returns {Wish} */
  wish() {
    /** @type {Wish} */
    const wish = { move: [0, 0, 0], turn: [0, 0] };
    for (const code of this.#held) {
      MOVES.get(code)?.forEach((value, axis) => (wish.move[axis] = (wish.move[axis] ?? 0) + value));
      TURNS.get(code)?.forEach((value, axis) => (wish.turn[axis] = (wish.turn[axis] ?? 0) + value));
    }
    return wish;
  }
}

/** What two devices ask for together. @param {Wish} a @param {Wish} b @returns {Wish} */
export function bothOf(a, b) {
  const sum = (/** @type {number} */ x, /** @type {number} */ y) => Math.max(-1, Math.min(1, x + y));
  return {
    move: [sum(a.move[0], b.move[0]), sum(a.move[1], b.move[1]), sum(a.move[2], b.move[2])],
    turn: [sum(a.turn[0], b.turn[0]), sum(a.turn[1], b.turn[1])],
  };
}

/** Whether a key is for the control that has the focus. @param {KeyboardEvent} event */
export function belongsToControl({ target, code }) {
  if (!(target instanceof Element)) return false;
  if (target.matches("input[type=radio], input[type=checkbox]")) return code.startsWith("Arrow");
  return target.closest("input, select, textarea, dialog") !== null;
}
