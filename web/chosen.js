/** What is chosen in a scene: where its handles are, and the edits that moving and turning it make. */

import { middleOf, offsetWithin, rounded, scaled, scaleWithin, sum } from "./moving.js";
import { about, direction, fromAngles, then, toAim, toAngles, turned } from "./turning.js";

/** @typedef {import("./messages.js").ObjectEdit} ObjectEdit */
/** @typedef {import("./messages.js").ScenePatch} ScenePatch */
/** @typedef {import("./messages.js").SceneInfo} SceneInfo */
/** @typedef {Pick<import("./messages.js").SceneEdits, "lights" | "objects"> & Pick<import("./messages.js").Edits, "suns">} Edits */
/** @typedef {[number, number, number]} Vec3 */
/** @typedef {{kind: "object" | "light", id: string}} Chosen */

/** Of the scene, or as large as in a file: what nobody asks for who lets handles be where they are. */
const NEAR = 1e-3;

/**
 * What handles move and turn, in the world, as it is now.
 * @typedef {object} Target
 * @property {string} name
 * @property {Vec3 | null} at  null: it has no place, and cannot be moved
 * @property {Vec3[] | null} corners  of the box around it, if it has an extent: as middleOf's box, in binary order of x, y, z
 * @property {Vec3 | null} direction  where it shines
 * @property {Vec3 | null} angles  about each axis, as far as they tell how it is turned; null: it cannot be turned [°]
 * @property {number | null} size  times as large as in its file; null: it has none
 */

/** @param {Chosen | null} chosen @param {SceneInfo | null} scene @param {Edits} edits @returns {Target | null} */
export function targetOf(chosen, scene, { lights, objects, suns }) {
  if (chosen?.kind === "light") {
    const light = scene?.lights.find(({ id }) => id === chosen.id);
    if (!light?.position && !light?.direction) return null;
    const edit = lights[chosen.id];
    const [at, shines] = [light.position && (edit?.position ?? light.position), light.direction && (edit?.direction ?? suns[light.id] ?? light.direction)];
    const [azimuth, elevation] = shines ? toAim(shines) : [0, 0];
    return { name: light.id, at, corners: null, direction: shines, angles: shines && [elevation, azimuth, elevation], size: null };
  }
  const box = chosen && scene?.objects.find(({ id }) => id === chosen.id)?.box;
  if (!box) return null;
  const { rotation: turn, scale: by } = objects[chosen.id] ?? {};
  const [angles, size] = [turn ?? /** @type {Vec3} */ ([0, 0, 0]), by ?? 1];
  const [rotation, middle, { min, max }] = [fromAngles(angles), middleOf(box), scaled(box, size)];
  const at = sum(middle, objects[chosen.id]?.offset ?? [0, 0, 0]);
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((number) => {
    const corner = /** @type {Vec3} */ (min.map((low, axis) => (number & (1 << axis) ? (max[axis] ?? low) : low)));
    return sum(at, turned(sum(corner, [-middle[0], -middle[1], -middle[2]]), rotation));
  });
  return { name: chosen.id, at, corners, direction: null, angles, size };
}

/** Has what is chosen be there, as far as it can; null: no farther than it is. @param {Chosen} chosen @param {SceneInfo} scene @param {Edits} edits @param {Vec3} to @returns {ScenePatch | null} */
export function movedTo({ kind, id }, { bounds, objects }, edits, to) {
  const size = Math.max(...bounds.max.map((high, axis) => high - (bounds.min[axis] ?? high)));
  if (kind === "light") {
    return { lights: { [id]: { position: /** @type {Vec3} */ (to.map((value) => rounded(value, size))) } } };
  }
  const box = objects.find((object) => object.id === id)?.box;
  if (!box) return {};
  const [x, y, z] = middleOf(box);
  const { offset: now = null, scale = 1 } = edits.objects[id] ?? {};
  const wanted = /** @type {Vec3} */ ([to[0] - x, to[1] - y, to[2] - z]);
  const offset = offsetWithin(scaled(box, scale ?? 1), bounds, wanted);
  const stays = offset.every((value, axis) => value === (now?.[axis] ?? 0));
  const away = wanted.some((value, axis) => Math.abs(value - (offset[axis] ?? value)) > NEAR * size);
  return stays && away ? null : { objects: { [id]: { offset } } };
}

/** Has an object that is chosen be so many times as large as in its file, as far as it can; null: no more than it is. @param {Chosen} chosen @param {SceneInfo} scene @param {Edits} edits @param {number} size @returns {ScenePatch | null} */
export function sizedTo({ id }, { bounds, objects }, edits, size) {
  const box = objects.find((object) => object.id === id)?.box;
  if (!box) return {};
  const { offset, scale: now } = edits.objects[id] ?? {};
  const scale = scaleWithin(box, bounds, offset ?? [0, 0, 0], size);
  return scale === (now ?? 1) && Math.abs(size - scale) > NEAR ? null : { objects: { [id]: { scale } } };
}

/** Turns what is chosen on from where it was. @param {Chosen} chosen @param {Target} from @param {0 | 1 | 2} axis @param {number} angle [rad] @returns {ScenePatch} */
export function turnedFrom({ kind, id }, from, axis, angle) {
  if (kind === "light") return from.direction ? { lights: { [id]: { direction: direction(turned(from.direction, about(axis, angle))) } } } : {};
  return { objects: { [id]: { rotation: toAngles(then(fromAngles(from.angles ?? [0, 0, 0]), about(axis, angle))) } } };
}
