/**
 * Handles over the picture that move what is chosen along the world's axes, turn it about them, or make it larger, by
 * dragging or by arrow keys; its box, and where it shines.
 */

import { add, scale } from "../viewer/camera.js";
import { arrow, grip, NAMES, ring } from "./handles.js";
import { set, shape, strokes } from "./svg.js";

/** @typedef {import("../chosen.js").Target} Target */
/** @typedef {import("../viewer/camera.js").Vec3} Vec3 */
/** @typedef {import("../viewer/projection.js").Projection} Projection */
/** @typedef {import("./handles.js").Handle} Handle */

/**
 * @typedef {object} GizmoEvents
 * @property {(to: Vec3) => void} move  what is chosen is to be there; many times until `end`
 * @property {(from: Target, axis: 0 | 1 | 2, angle: number) => void} turn  and to be turned on from there [rad]
 * @property {(size: number) => void} size  and to be so many times as large as in its file
 * @property {() => void} end  a drag, or a key, is over
 * @property {() => number} step  of an arrow key [m]
 * @property {() => number} turnStep  and [rad]
 */

/** CSS pixels of the line that tells where a light shines. */
const SHINES = 120;
const KEYS = new Map([["ArrowRight", 1], ["ArrowUp", 1], ["ArrowLeft", -1], ["ArrowDown", -1], ["PageUp", 10], ["PageDown", -10]]);
/** What a step of an arrow key makes larger by, as a logarithm. */
const SIZE_STEP = Math.log(1.05);
/** Corners of a box that have edges between them. */
const EDGES = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((corner) => [1, 2, 4].filter((bit) => !(corner & bit)).map((bit) => [corner, corner | bit]));

export class Gizmo {
  #events;
  #box;
  #shines;
  #group;
  /** @type {Handle[]} */
  #handles;
  /** @type {Target | null} */
  #target = null;
  /** @type {Projection | null} */
  #projection = null;
  /** What a drag began with, where it is shown, and where the pointer was then. @type {{handle: Handle, from: Target, at: Vec3, start: number} | null} */
  #drag = null;

  /** @param {SVGElement} parent @param {GizmoEvents} events */
  constructor(parent, events) {
    this.#events = events;
    this.#box = shape(parent, "path", { class: "chosen-box" });
    this.#shines = shape(parent, "path", { class: "shines" });
    this.#group = shape(parent, "g", { class: "gizmo" });
    this.#handles = /** @type {const} */ ([0, 1, 2]).flatMap((axis) => [arrow(this.#group, axis), ring(this.#group, axis)]);
    this.#handles.push(grip(this.#group));
    for (const handle of this.#handles) this.#listen(handle);
  }

  /** @param {Target | null} target @param {"move" | "turn" | "size"} kind of the handles that it has, if it can have them */
  show(target, kind) {
    this.#target = target;
    const name = target?.name ?? "nothing";
    for (const { kind: own, axis, group } of this.#handles) {
      const values = { move: target?.at, turn: target?.angles, size: target?.size === null ? null : [target?.size ?? 1] }[own];
      group.toggleAttribute("data-off", own !== kind || !values);
      const value = values?.[axis] ?? 0;
      const label = { move: `Move ${name} along ${NAMES[axis]}`, turn: `Turn ${name} about ${NAMES[axis]}`, size: `Make ${name} larger` }[own];
      const words = { move: `${Number(value.toFixed(3))} m`, turn: `${value}°`, size: `${Number(value.toFixed(3))} times` }[own];
      set(group, { "aria-label": label, "aria-valuenow": value, "aria-valuetext": words });
    }
    if (this.#projection) this.draw(this.#projection);
  }

  /** @param {Projection} projection */
  draw(projection) {
    this.#projection = projection;
    const { at, corners, direction } = this.#target ?? { at: null, corners: null, direction: null };
    const place = this.#target && (at ?? projection.ahead());
    const foot = place && projection.point(place);
    this.#group.toggleAttribute("hidden", !foot);
    this.#box.toggleAttribute("hidden", !corners);
    if (corners) set(this.#box, { d: strokes(EDGES.map(([a = 0, b = 0]) => [corners[a] ?? [0, 0, 0], corners[b] ?? [0, 0, 0]]), projection) });
    this.#shines.toggleAttribute("hidden", !foot || !direction);
    if (place && direction) {
      const end = add(place, scale(direction, (SHINES * projection.pixelAt(place)) / Math.hypot(...direction)));
      set(this.#shines, { d: strokes([[place, end]], projection) });
    }
    if (place && foot) for (const handle of this.#handles) handle.draw(projection, place);
  }

  /** @param {Handle} handle */
  #listen(handle) {
    const { group } = handle;
    group.addEventListener("pointerdown", (event) => this.#down(event, handle));
    group.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) group.addEventListener(end, () => this.#end());
    group.addEventListener("keydown", (event) => this.#key(event, handle));
    group.addEventListener("keyup", () => this.#events.end());
  }

  /** @param {PointerEvent} event @param {Handle} handle */
  #down(event, handle) {
    const at = this.#target && (this.#target.at ?? this.#projection?.ahead());
    const start = at ? this.#measure(event, handle, at) : null;
    if (event.button !== 0 || !this.#target || !at || start === null) return;
    event.preventDefault();
    handle.group.focus({ preventScroll: true });
    handle.group.setPointerCapture(event.pointerId);
    this.#drag = { handle, from: this.#target, at, start };
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (!this.#drag) return;
    const { handle, from, at, start } = this.#drag;
    const now = this.#measure(event, handle, at);
    if (now !== null) this.#change(handle, from, now - start);
  }

  /** @param {PointerEvent} event @param {Handle} handle @param {Vec3} at */
  #measure({ clientX: x, clientY: y }, handle, at) {
    return this.#projection && handle.measure(this.#projection.ray({ x, y }), this.#projection, at);
  }

  #end() {
    if (this.#drag) this.#events.end();
    this.#drag = null;
  }

  /** @param {KeyboardEvent} event @param {Handle} handle */
  #key(event, handle) {
    const steps = KEYS.get(event.key);
    if (steps === undefined || !this.#target || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault(); // the camera stays
    const step = { move: this.#events.step, turn: this.#events.turnStep, size: () => SIZE_STEP }[handle.kind];
    this.#change(handle, this.#target, steps * step());
  }

  /** @param {Handle} handle @param {Target} from @param {number} by [m, rad, logarithm of size] */
  #change({ kind, axis }, from, by) {
    if (kind === "size") return this.#events.size((from.size ?? 1) * Math.exp(by));
    if (kind === "turn") return this.#events.turn(from, axis, by);
    if (!from.at) return;
    const to = /** @type {Vec3} */ ([...from.at]);
    to[axis] += by;
    this.#events.move(to);
  }
}
