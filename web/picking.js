/** Asks the server what is at a place of the picture. */

/** @typedef {import("./messages.js").PickedPart} PickedPart */

/**
 * @typedef {object} View
 * @property {import("./protocol.js").SceneInfo} scene
 * @property {import("./messages.js").SceneEdits | null} edits  if they are the viewer's own
 * @property {number[]} matrix  camera to world, column-major
 * @property {number} yfov  vertical field of view [rad]
 * @property {number} near  what is less far in front of the camera is cut away [m]
 * @property {[number, number]} size  of the picture
 */

export class PickError extends Error {}

/** @param {URL} api @param {View} view @param {[number, number]} pixel @returns {Promise<PickedPart>} rejects with PickError and words for the user */
export async function pick(api, { scene, edits, matrix, yfov, near, size }, pixel) {
  const camera = { matrix, yfov_degrees: (yfov * 180) / Math.PI, near };
  const body = JSON.stringify({ scene: scene.id, scene_options: scene.options, edits, camera, size, pixel });
  let answer;
  try {
    answer = await fetch(new URL("pick", api), { method: "POST", headers: { "Content-Type": "application/json" }, body });
  } catch {
    throw new PickError("The server does not answer; try again.");
  }
  const found = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new PickError(found.message ?? `The server cannot tell what is there (status ${answer.status}).`);
  return found;
}

/** What was picked, in words. @param {PickedPart} part */
export function wordsOf({ object, material, light, distance }) {
  const names = [object, material !== object && material, light !== object && light !== material && light].filter(Boolean);
  if (names.length === 0) return "Nothing is there";
  return distance === null ? names.join(", ") : `${names.join(", ")}: ${Number(distance.toPrecision(3))} m away`;
}
