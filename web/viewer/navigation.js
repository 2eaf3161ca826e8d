/** Walking through the scene: input devices on one side, the camera on the other, orbit or fly between them. */

import { dot, distance as between } from "./camera.js";
import { Fly, paceIn } from "./fly.js";
import { Gamepads } from "./gamepad.js";
import { Gestures } from "./gestures.js";
import { bothOf, HeldKeys } from "./keys.js";
import { Motion } from "./motion.js";
import { Orbit } from "./orbit.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {"fly" | "orbit"} Mode */
/** @typedef {{min: Vec3, max: Vec3}} Bounds */

/** Seconds that the first step after rest counts. */
const FIRST_STEP = 1 / 60;

export class Navigation {
  /** @type {Mode} */
  mode = "fly";
  /** The scene's diagonal [m]. */
  size = 1;
  /** tan(vertical field of view / 2) of the picture on the canvas. */
  halfHeight = 0.5;
  /** Called with the new speed [m/s] when the wheel changes the flying speed. @type {(speed: number) => void} */
  onSpeed = () => {};
  /** Called when a gamepad asks for the start of the view, and for the other way to move. */
  onHome = () => {};
  onMode = () => {};
  /** Called when something in the picture is clicked, in CSS pixels. @type {(x: number, y: number) => void} */
  onClick = () => {};

  #canvas;
  #camera;
  #fly;
  #orbit;
  #keys;
  #gamepads;
  #motion = new Motion();
  #wake;
  /** Time of the step before this one; null after rest. @type {number | null} */
  #last = null;

  /** @param {HTMLCanvasElement} canvas @param {Camera} camera @param {() => void} wake asks for `advance` in the next animation frame */
  constructor(canvas, camera, wake) {
    this.#canvas = canvas;
    this.#camera = camera;
    this.#wake = wake;
    this.#fly = new Fly(camera);
    this.#orbit = new Orbit(camera);
    this.#keys = new HeldKeys(window, wake);
    this.#gamepads = new Gamepads(wake, { home: () => this.onHome(), mode: () => this.onMode() });
    new Gestures(canvas, {
      drag: (dx, dy, kind, touch) => this.#drag(dx, dy, kind, touch),
      pinch: (ratio, dx, dy) => this.#pinch(ratio, dx, dy),
      click: (x, y) => this.onClick(x, y),
      wheel: (steps) => this.#wheel(steps),
    });
  }

  /** Starts where the camera stands: the pivot is what it looks at of the scene's middle. @param {Bounds} bounds */
  start(bounds) {
    const { min, max } = bounds;
    /** @type {Vec3} */
    const middle = [(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, (min[2] + max[2]) / 2];
    this.size = Math.max(between(min, max), 1e-9);
    this.#motion.stop();
    const { back } = this.#camera.axes();
    const ahead = dot(back, this.#camera.position) - dot(back, middle);
    this.#orbit.distance = Math.max(ahead, 0.1 * this.size);
    this.#orbit.nearest = 1e-3 * this.size;
    this.#wake();
  }

  /** Whether the mouse steers without a button held (only while flying). */
  get locked() {
    return document.pointerLockElement === this.#canvas;
  }

  /** @param {Mode} mode */
  setMode(mode) {
    this.mode = mode;
    if (mode === "orbit" && this.locked) document.exitPointerLock();
  }

  async lockPointer() {
    this.setMode("fly");
    this.#canvas.focus({ preventScroll: true });
    await this.#canvas.requestPointerLock();
  }

  /** Moves by the held keys and sticks. @param {number} now [ms] @returns {boolean} whether there is more motion to come */
  advance(now) {
    const seconds = this.#last === null ? FIRST_STEP : (now - this.#last) / 1000;
    const motion = this.#motion.advance(bothOf(this.#keys.wish(), this.#gamepads.wish), seconds);
    this.#last = motion && now;
    if (!motion) return false;
    const fast = this.#keys.fast || this.#gamepads.fast;
    if (this.mode === "fly") this.#fly.walk(motion, this.size, fast);
    else this.#orbit.walk(motion, fast);
    return true;
  }

  /** Metres a CSS pixel at the pivot. */
  get #unit() {
    return (2 * this.halfHeight * this.#orbit.distance) / Math.max(this.#canvas.clientHeight, 1);
  }

  /** @param {number} dx @param {number} dy @param {import("./gestures.js").DragKind} kind @param {boolean} touch */
  #drag(dx, dy, kind, touch) {
    if (kind === "pan") (this.mode === "fly" ? this.#fly : this.#orbit).pan(dx, dy, this.#unit);
    else if (this.mode === "fly") this.#fly.look(dx, dy, touch);
    else this.#orbit.drag(dx, dy);
    this.#wake();
  }

  /** @param {number} ratio @param {number} dx @param {number} dy */
  #pinch(ratio, dx, dy) {
    if (this.mode === "fly") this.#fly.pinch(ratio, this.size);
    else this.#orbit.dolly(1 / ratio);
    this.#drag(dx, dy, "pan", true);
  }

  /** @param {number} steps */
  #wheel(steps) {
    if (this.mode === "fly") {
      this.#fly.wheel(steps);
      this.onSpeed(paceIn(this.size) * this.#fly.speed);
    } else {
      this.#orbit.wheel(steps);
      this.#wake();
    }
  }
}
