/** The shapes of the handles that the gizmo has: an arrow along an axis of the world, which moves, a ring about it, which turns, and a grip, which makes larger. */

import { add, dot, scale } from "../viewer/camera.js";
import { alongAxis, aroundAxis, besides } from "../viewer/projection.js";
import { set, shape, strokes } from "./svg.js";

/** @typedef {import("../viewer/camera.js").Vec3} Vec3 */
/** @typedef {import("../viewer/projection.js").Projection} Projection */
/** @typedef {import("../viewer/projection.js").Ray} Ray */
/** @typedef {0 | 1 | 2} Axis */

/**
 * @typedef {object} Handle
 * @property {"move" | "turn" | "size"} kind
 * @property {Axis} axis
 * @property {SVGGElement} group
 * @property {(projection: Projection, at: Vec3) => void} draw
 * @property {(ray: Ray, projection: Projection, at: Vec3) => number | null} measure  where the pointer holds it, to be compared with where it held it before [m, rad, logarithm of size]
 */

export const NAMES = /** @type {const} */ (["X", "Y", "Z"]);
/** CSS pixels of a handle, and of one that is seen so much from its end that it cannot be told from its foot. */
const LENGTH = 84;
const LEAST_LENGTH = 18;
const RADIUS = 68;
/** Parts of a ring; those that are farther behind its middle than this share of its radius are not drawn. */
const PARTS = 72;
const BEHIND = 0.12;

/** @param {SVGElement} parent @param {Axis} axis @returns {Handle} */
export function arrow(parent, axis) {
  const group = handle(parent, axis, "line");
  const along = unit(axis);
  return {
    kind: "move",
    axis,
    group,
    draw(projection, at) {
      const foot = projection.point(at);
      const tip = projection.point(add(at, scale(along, LENGTH * projection.pixelAt(at))));
      group.toggleAttribute("hidden", !foot || !tip || Math.hypot(tip.x - foot.x, tip.y - foot.y) <= LEAST_LENGTH);
      if (!foot || !tip) return;
      for (const line of group.querySelectorAll("line")) set(line, { x1: foot.x, y1: foot.y, x2: tip.x, y2: tip.y });
      placeKnob(group, tip);
    },
    measure: (ray, _, at) => alongAxis(ray, at, along),
  };
}

/** @param {SVGElement} parent @param {Axis} axis @returns {Handle} */
export function ring(parent, axis) {
  const group = handle(parent, axis, "path");
  group.classList.add("ring");
  const [u, v] = [unit((axis + 1) % 3), unit((axis + 2) % 3)];
  const on = (/** @type {number} */ angle) => add(scale(u, Math.cos(angle)), scale(v, Math.sin(angle)));
  return {
    kind: "turn",
    axis,
    group,
    draw(projection, at) {
      const [radius, away] = [RADIUS * projection.pixelAt(at), projection.towards(at)];
      const points = Array.from({ length: PARTS + 1 }, (_, part) => on((2 * Math.PI * part) / PARTS));
      const lines = points.slice(1).flatMap((end, part) => {
        const start = points[part] ?? end;
        return dot(end, away) < BEHIND ? [/** @type {[Vec3, Vec3]} */ ([add(at, scale(start, radius)), add(at, scale(end, radius))])] : [];
      });
      for (const path of group.querySelectorAll("path")) set(path, { d: strokes(lines, projection) });
      const knob = on(Math.PI / 4);
      const place = projection.point(add(at, scale(knob, dot(knob, away) < BEHIND ? radius : -radius)));
      group.toggleAttribute("hidden", !place);
      if (place) placeKnob(group, place);
    },
    measure: (ray, projection, at) => aroundAxis(ray, at, axis, RADIUS * projection.pixelAt(at)),
  };
}

/** @param {SVGElement} parent @returns {Handle} */
export function grip(parent) {
  const group = handle(parent, 0, "line", "size", "↔");
  return {
    kind: "size",
    axis: 0,
    group,
    draw(projection, at) {
      const foot = projection.point(at);
      group.toggleAttribute("hidden", !foot);
      if (!foot) return;
      const tip = { x: foot.x + LENGTH * Math.SQRT1_2, y: foot.y - LENGTH * Math.SQRT1_2 };
      for (const line of group.querySelectorAll("line")) set(line, { x1: foot.x, y1: foot.y, x2: tip.x, y2: tip.y });
      placeKnob(group, tip);
    },
    measure: (ray, projection, at) => Math.log(Math.max(besides(ray, at), projection.pixelAt(at))),
  };
}

/** @param {SVGElement} parent @param {Axis} axis @param {"line" | "path"} of @param {string} kind @param {string} name */
function handle(parent, axis, of, kind = NAMES[axis].toLowerCase(), name = NAMES[axis]) {
  const group = shape(parent, "g", { class: `axis axis-${kind}`, role: "slider", tabindex: 0, "aria-valuenow": 0 });
  shape(group, of, { class: "reach" });
  shape(group, of, { class: "shaft" });
  shape(group, "circle", { r: 11 });
  shape(group, "text", { "text-anchor": "middle", dy: "0.36em" }).textContent = name;
  return group;
}

/** @param {SVGGElement} group @param {import("../viewer/projection.js").Point} place */
function placeKnob(group, { x, y }) {
  for (const end of group.querySelectorAll("circle, text")) set(end, { transform: `translate(${x} ${y})` });
}

/** @param {number} axis @returns {Vec3} */
const unit = (axis) => [Number(axis === 0), Number(axis === 1), Number(axis === 2)];
