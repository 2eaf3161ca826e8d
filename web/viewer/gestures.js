/** Pointer and wheel events of one element, told as gestures: drags, pinches and wheel steps. */

/**
 * @typedef {"look" | "pan"} DragKind  main button or one finger; any other button
 * @typedef {object} GestureHandler
 * @property {(dx: number, dy: number, kind: DragKind, touch: boolean) => void} drag  in CSS pixels
 * @property {(ratio: number, dx: number, dy: number) => void} pinch  growth of the fingers' distance; their middle's way
 * @property {(x: number, y: number) => void} click  the main button or one finger, without a drag; in CSS pixels of the page
 * @property {(steps: number) => void} wheel  notches, positive towards the user
 */

const PIXELS_A_NOTCH = 100;
const PIXELS_A_LINE = 33;
/** Farther than this from where it went down, a pointer drags [CSS px]. */
const CLICK_REACH = 5;

/** @typedef {{x: number, y: number}} Point */

export class Gestures {
  /** @type {Map<number, Point>} */
  #pointers = new Map();
  /** @type {DragKind} */
  #kind = "look";
  /** Where the one pointer went down, as long as it may be a click. @type {Point | null} */
  #start = null;
  #element;
  #handler;

  /** @param {HTMLElement} element @param {GestureHandler} handler */
  constructor(element, handler) {
    this.#element = element;
    this.#handler = handler;
    element.addEventListener("pointerdown", (event) => this.#down(event));
    element.addEventListener("pointermove", (event) => this.#move(event));
    element.addEventListener("pointerup", (event) => this.#up(event));
    for (const end of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
      element.addEventListener(end, (event) => this.#pointers.delete(event.pointerId));
    }
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  get #locked() {
    return document.pointerLockElement === this.#element;
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (this.#locked) return;
    this.#element.focus({ preventScroll: true });
    this.#element.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.#kind = event.button === 0 && !event.shiftKey ? "look" : "pan";
    this.#start = this.#kind === "look" && this.#pointers.size === 1 ? { x: event.clientX, y: event.clientY } : null;
  }

  /** @param {PointerEvent} event */
  #up(event) {
    if (this.#start && this.#pointers.has(event.pointerId)) this.#handler.click(event.clientX, event.clientY);
    this.#start = null;
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (this.#locked) {
      this.#handler.drag(event.movementX, event.movementY, "look", false);
      return;
    }
    const last = this.#pointers.get(event.pointerId);
    if (!last) return;
    const now = { x: event.clientX, y: event.clientY };
    if (this.#start) {
      if (gap(this.#start, now) <= CLICK_REACH) return;
      this.#start = null;
    }
    this.#pointers.set(event.pointerId, now);
    const [dx, dy] = [now.x - last.x, now.y - last.y];
    if (this.#pointers.size === 1) {
      this.#handler.drag(dx, dy, this.#kind, event.pointerType === "touch");
    } else if (this.#pointers.size === 2) {
      const other = this.#otherThan(event.pointerId);
      // Each finger moves the middle by half of its own way.
      if (other) this.#handler.pinch(gap(now, other) / Math.max(gap(last, other), 1), dx / 2, dy / 2);
    }
  }

  /** @param {number} id @returns {Point | undefined} */
  #otherThan(id) {
    for (const [pointer, point] of this.#pointers) if (pointer !== id) return point;
    return undefined;
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? PIXELS_A_LINE : 1);
    this.#handler.wheel(Math.max(-3, Math.min(3, pixels / PIXELS_A_NOTCH)));
  }
}

/** @param {Point} a @param {Point} b */
const gap = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);
