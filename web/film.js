/** The film of each scene, kept by the browser: views in order, and camera paths as the server takes them. */

import { isView } from "./bookmarks.js";
import { toFile, toWorld } from "./frame.js";
import { load, save } from "./storage.js";
import { add, Camera } from "./viewer/camera.js";
import { CameraPath } from "./viewer/camera-path.js";

/** @typedef {import("./link.js").View} View */
/** @typedef {import("./protocol.js").SceneInfo} SceneInfo */
/** @typedef {{name: string, view: View, seconds: number}} Stop  seconds: that the way there takes, from the one before */
/** @typedef {{position: number[], target: number[], yfov_degrees: number, near?: number}} LookAtCamera */
/** @typedef {{keyframes: {time: number, camera: LookAtCamera, name: string}[]}} PathFile */

/** What the server takes (server/wire/camera_path.py). */
const MOST_STOPS = 200;
export const SECONDS = { least: 0.1, most: 3600, usual: 3 };
const LONGEST_NAME = 60;
const DEGREE = Math.PI / 180;

export class PathError extends Error {}

/** @param {string} scene id */
const key = (scene) => `film ${scene}`;

/** @param {string} scene id @returns {Stop[]} */
export function filmOf(scene) {
  const list = load(key(scene));
  return Array.isArray(list) ? list.filter(isStop).slice(0, MOST_STOPS) : [];
}

/** @param {string} scene id @param {readonly Stop[]} stops @returns {boolean} whether they are kept */
export function keepFilm(scene, stops) {
  return stops.length <= MOST_STOPS && save(key(scene), stops);
}

/** When the camera is at each stop [s]. @param {readonly Stop[]} stops */
export function timesOf(stops) {
  let time = 0;
  return stops.map(({ seconds }, index) => Number((time += index === 0 ? 0 : seconds).toFixed(3)));
}

/** The way that the camera flies. @param {readonly Stop[]} stops two or more */
export function wayOf(stops) {
  const times = timesOf(stops);
  return new CameraPath(stops.map(({ view }, index) => ({ time: times[index] ?? 0, view })));
}

/** @param {readonly Stop[]} stops @param {SceneInfo} scene @returns {PathFile} */
export function pathOf(stops, { frame }) {
  const times = timesOf(stops);
  return {
    keyframes: stops.map(({ name, view: { at, look, yfov, near } }, index) => {
      const [yaw, pitch] = look;
      const ahead = /** @type {const} */ ([-Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch)]);
      const target = toFile(frame, add(toWorld(frame, at), [...ahead]));
      const camera = { position: at, target, yfov_degrees: yfov / DEGREE, ...(near && { near }) };
      return { time: times[index] ?? 0, camera, name };
    }),
  };
}

/** The stops of a path's file. @param {string} text JSON @param {SceneInfo} scene @returns {Stop[]} rejects others with PathError */
export function stopsOf(text, scene) {
  let keyframes;
  try {
    keyframes = JSON.parse(text).keyframes;
  } catch {
    throw new PathError("This file is no camera path: it is not JSON.");
  }
  if (!Array.isArray(keyframes) || keyframes.length < 2 || keyframes.length > MOST_STOPS) {
    throw new PathError(`This file is no camera path: it needs "keyframes", 2 to ${MOST_STOPS} of them.`);
  }
  let before = NaN;
  return keyframes.map((keyframe, index) => {
    const { time, camera, name } = keyframe ?? {};
    const seconds = index === 0 ? SECONDS.usual : time - before;
    if (!Number.isFinite(time) || !(seconds > 0)) throw new PathError(`keyframes[${index}].time: must be a number${index ? ` after ${before}` : ""}.`);
    if (seconds > SECONDS.most) throw new PathError(`keyframes[${index}].time: must be at most ${SECONDS.most} s after ${before}.`);
    before = time;
    const view = viewOf(camera, scene);
    if (!view) throw new PathError(`keyframes[${index}].camera: is no camera of this scene, and none that the page can show.`);
    return { name: String(name || `View ${index + 1}`).slice(0, LONGEST_NAME), view, seconds };
  });
}

/** The view of a camera: one of the scene's, by name or number, or one from a point towards another. @param {any} camera @param {SceneInfo} scene @returns {View | null} */
function viewOf(camera, { cameras, frame }) {
  const known = typeof camera === "number" ? cameras[camera] : cameras.find(({ name }) => name === camera);
  const shown = new Camera();
  if (known) {
    shown.setMatrix(known.matrix);
    return { at: toFile(frame, shown.position), look: shown.place.look, yfov: known.yfov, ...(known.near > 0 && { near: known.near }) };
  }
  const { position, target, up, yfov_degrees: degrees = 60, near = 0 } = camera ?? {};
  if (![position, target].every((point) => Array.isArray(point) && point.length === 3) || up) return null;
  const back = toWorld({ ...frame, origin: target }, position);
  shown.setMatrix([1, 0, 0, 0, 0, 1, 0, 0, ...back, 0, 0, 0, 0, 1]);
  const view = { at: position, look: shown.place.look, yfov: degrees * DEGREE, ...(near && { near }) };
  return isView(view) ? view : null;
}

/** @param {unknown} value @returns {value is Stop} */
function isStop(value) {
  const { name, view, seconds } = /** @type {Partial<Stop>} */ (value ?? {});
  return typeof name === "string" && typeof seconds === "number" && seconds > 0 && seconds <= SECONDS.most && isView(view);
}
