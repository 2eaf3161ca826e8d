/** The list of scenes in the title bar: what the server has, by name. */

import { listScenes } from "../upload.js";
import { offer } from "./choice.js";
import { byId } from "./page.js";

/** @typedef {import("../protocol.js").SceneName} SceneName */

/** Between two looks at what the server has, when somebody comes to choose [ms]. */
const REST = 5000;

export class SceneList {
  #select = byId("scene", HTMLSelectElement);
  #scenes;
  /** Ids of scenes without a file. @type {Set<string>} */
  #builtin = new Set();
  #chosen = "";
  /** As they are listed. */
  #names = "";
  #looked = -REST;

  /** @param {URL} scenes  where the server lists them */
  constructor(scenes) {
    this.#scenes = scenes;
    // Others bring scenes, too. While it is open it is not touched unless there are any.
    for (const comes of ["pointerenter", "focus"]) this.#select.addEventListener(comes, () => this.#look());
  }

  #look() {
    const now = performance.now();
    if (now - this.#looked < REST) return;
    this.#looked = now;
    this.load().catch(() => null);
  }

  /** Lists these scenes; those that are called alike with their ids. @param {readonly SceneName[]} names */
  show(names) {
    const listed = JSON.stringify(names.map(({ id, name, builtin }) => [id, name, builtin]));
    if (listed === this.#names) return;
    this.#names = listed;
    this.#builtin = new Set(names.filter(({ builtin }) => builtin).map(({ id }) => id));
    const once = new Set();
    const twice = new Set();
    for (const { name } of names) (once.has(name) ? twice : once).add(name);
    const choices = names.map(({ id, name, builtin }) => ({
      value: id,
      label: twice.has(name) ? `${name} – ${id}` : name,
      group: builtin ? "Built in" : "Files",
    }));
    offer(this.#select, choices);
    this.#select.value = this.#chosen;
  }

  /** Lists what the server has now; rejects with UploadError and words for the user. */
  async load() {
    this.show(await listScenes(this.#scenes));
  }

  /** Shows that a scene is the one. @param {string} id @returns {boolean} whether it is listed */
  choose(id) {
    this.#chosen = id;
    this.#select.value = id;
    return this.#select.value === id;
  }

  /** Whether a scene has no file. @param {string} id */
  isBuiltin(id) {
    return this.#builtin.has(id);
  }
}
