/** Handles over the picture that move what is chosen along the world's axes, by dragging or by arrow keys, and its box. */

import { add, scale } from "../viewer/camera.js";
import { alongAxis } from "../viewer/projection.js";
import { set, shape } from "./svg.js";

/** @typedef {import("../viewer/camera.js").Vec3} Vec3 */
/** @typedef {import("../viewer/projection.js").Projection} Projection */
/** @typedef {import("../messages.js").Bounds} Bounds */
/** @typedef {{name: string, at: Vec3, box: Bounds | null}} Target  in the world, as it is now; box: around it, if it has an extent */
/** @typedef {{group: SVGGElement, along: Vec3}} Handle */

/**
 * @typedef {object} GizmoEvents
 * @property {(to: Vec3) => void} move  what is chosen is to be there; many times until `end`
 * @property {() => void} end  a drag, or a key, is over
 * @property {() => number} step  of an arrow key [m]
 */

const AXES = /** @type {const} */ ([["X", [1, 0, 0]], ["Y", [0, 1, 0]], ["Z", [0, 0, 1]]]);
/** CSS pixels of a handle, and of one that is seen so much from its end that it cannot be told from its foot. */
const LENGTH = 84;
const LEAST_LENGTH = 18;
const KEYS = new Map([["ArrowRight", 1], ["ArrowUp", 1], ["ArrowLeft", -1], ["ArrowDown", -1], ["PageUp", 10], ["PageDown", -10]]);
/** Corners of a box, as which of its ends they have on each axis, that have edges between them. */
const EDGES = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((corner) => [1, 2, 4].filter((bit) => !(corner & bit)).map((bit) => [corner, corner | bit]));

export class Gizmo {
  #events;
  #box;
  #group;
  #handles;
  /** @type {Target | null} */
  #target = null;
  /** @type {Projection | null} */
  #projection = null;
  /** Where a drag began, and where on its axis the pointer was then. @type {{along: Vec3, from: Vec3, start: number} | null} */
  #drag = null;

  /** @param {SVGElement} parent @param {GizmoEvents} events */
  constructor(parent, events) {
    this.#events = events;
    this.#box = shape(parent, "path", { class: "chosen-box" });
    this.#group = shape(parent, "g", { class: "gizmo" });
    this.#handles = AXES.map(([name, along]) => this.#handle(name, [...along]));
  }

  /** @param {Target | null} target */
  show(target) {
    this.#target = target;
    this.#handles.forEach(({ group }, axis) => {
      const at = target?.at[axis] ?? 0;
      const label = `Move ${target?.name ?? "nothing"} along ${AXES[axis]?.[0] ?? ""}`;
      set(group, { "aria-label": label, "aria-valuenow": at, "aria-valuetext": `${Number(at.toFixed(3))} m` });
    });
    if (this.#projection) this.draw(this.#projection);
  }

  /** @param {Projection} projection */
  draw(projection) {
    this.#projection = projection;
    const target = this.#target;
    const foot = target && projection.point(target.at);
    this.#group.toggleAttribute("hidden", !foot);
    this.#box.toggleAttribute("hidden", !target?.box);
    if (target?.box) set(this.#box, { d: outline(target.box, projection) });
    if (!target || !foot) return;
    const length = LENGTH * projection.pixelAt(target.at);
    for (const { group, along } of this.#handles) {
      const tip = projection.point(add(target.at, scale(along, length)));
      const long = tip !== null && Math.hypot(tip.x - foot.x, tip.y - foot.y) > LEAST_LENGTH;
      group.toggleAttribute("hidden", !long);
      if (!tip) continue;
      for (const line of group.querySelectorAll("line")) set(line, { x1: foot.x, y1: foot.y, x2: tip.x, y2: tip.y });
      for (const end of group.querySelectorAll("circle, text")) set(end, { transform: `translate(${tip.x} ${tip.y})` });
    }
  }

  /** @param {string} name @param {Vec3} along @returns {Handle} */
  #handle(name, along) {
    const group = shape(this.#group, "g", { class: `axis axis-${name.toLowerCase()}`, role: "slider", tabindex: 0, "aria-valuenow": 0 });
    shape(group, "line", { class: "reach" });
    shape(group, "line", { class: "shaft" });
    shape(group, "circle", { r: 11 });
    shape(group, "text", { "text-anchor": "middle", dy: "0.36em" }).textContent = name;
    group.addEventListener("pointerdown", (event) => this.#down(event, group, along));
    group.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) group.addEventListener(end, () => this.#end());
    group.addEventListener("keydown", (event) => this.#key(event, along));
    group.addEventListener("keyup", () => this.#events.end());
    return { group, along };
  }

  /** @param {PointerEvent} event @param {SVGGElement} group @param {Vec3} along */
  #down(event, group, along) {
    const ray = this.#projection?.ray({ x: event.clientX, y: event.clientY });
    const start = ray && this.#target ? alongAxis(ray, this.#target.at, along) : null;
    if (event.button !== 0 || !this.#target || start === null) return;
    event.preventDefault();
    group.focus({ preventScroll: true });
    group.setPointerCapture(event.pointerId);
    this.#drag = { along, from: this.#target.at, start };
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const ray = this.#projection?.ray({ x: event.clientX, y: event.clientY });
    if (!this.#drag || !ray) return;
    const { along, from, start } = this.#drag;
    const now = alongAxis(ray, from, along);
    if (now !== null) this.#events.move(add(from, scale(along, now - start)));
  }

  #end() {
    if (this.#drag) this.#events.end();
    this.#drag = null;
  }

  /** @param {KeyboardEvent} event @param {Vec3} along */
  #key(event, along) {
    const steps = KEYS.get(event.key);
    if (steps === undefined || !this.#target || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault(); // the camera stays
    this.#events.move(add(this.#target.at, scale(along, steps * this.#events.step())));
  }
}

/** @param {Bounds} box @param {Projection} projection */
function outline({ min, max }, projection) {
  const corner = (/** @type {number} */ number) =>
    /** @type {Vec3} */ (min.map((low, axis) => (number & (1 << axis) ? (max[axis] ?? low) : low)));
  const lines = EDGES.map(([a = 0, b = 0]) => projection.line(corner(a), corner(b)));
  return lines.map((line) => line && `M${line.map(({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}`).join("");
}
