/** The sheet of the scene's lights, materials and objects: a row for each light, fields of the others that are chosen. */

import { fromHex, toHex } from "../colors.js";
import { EditHistory } from "../edits.js";
import { offer } from "./choice.js";
import { MaterialFields } from "./material-fields.js";
import { ObjectFields } from "./object-fields.js";
import { button, byId, element, text } from "./page.js";
import { Sheet } from "./sheet.js";

/** @typedef {import("../messages.js").LightEdit} LightEdit */
/** @typedef {import("../messages.js").LightInfo} LightInfo */
/** @typedef {import("../messages.js").ScenePatch} ScenePatch */
/** @typedef {import("../messages.js").SceneEdits} SceneEdits */
/** @typedef {{light: LightInfo, on: HTMLInputElement, intensity: HTMLInputElement, color: HTMLInputElement}} Row */

/** Where a slider leaves a light as its file has it, of 100: its square is the factor, so that there is room for the dark. */
const MIDDLE = 50;

export class Mixer {
  sheet = new Sheet("mixer");
  #lights = text("lights");
  #material = byId("material", HTMLSelectElement);
  #materials;
  #object = byId("object", HTMLSelectElement);
  #objects;
  #undo = button("undo");
  #redo = button("redo");
  #reset = button("edits-reset");
  /** @type {Row[]} */
  #rows = [];
  #history;
  #place;

  /**
   * @param {(id: number, patch: ScenePatch) => void} send
   * @param {() => number[]} place  the camera's, column-major, camera to world
   */
  constructor(send, place) {
    this.#place = place;
    this.#history = new EditHistory(send, () => this.#show());
    this.#materials = new MaterialFields((id, edit, what) => {
      this.#history.edit({ materials: { [id]: edit } }, `${id}/${what}`);
    });
    this.#objects = new ObjectFields((id, edit, what) => {
      this.#history.edit({ objects: { [id]: edit } }, `${id}/${what}`);
    });
    this.#object.addEventListener("change", () => this.#show());
    this.#material.addEventListener("change", () => this.#show());
    this.#undo.addEventListener("click", () => this.#history.undo());
    this.#redo.addEventListener("click", () => this.#history.redo());
    this.#reset.addEventListener("click", () => this.#history.reset());
    const controls = text("mixer");
    controls.addEventListener("change", () => this.#history.end());
    controls.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Whether the server lets its viewers edit. @param {boolean} takes */
  set allowed(takes) {
    button("toggle-mixer").hidden = !takes;
  }

  get allowed() {
    return !button("toggle-mixer").hidden;
  }

  /** A scene is there. @param {import("../protocol.js").SceneInfo} scene */
  scene(scene) {
    this.#lights.replaceChildren();
    this.#rows = scene.lights.map((light, number) => this.#row(light, number));
    text("no-lights").hidden = this.#rows.length > 0;
    for (const [select, parts] of /** @type {const} */ ([[this.#material, scene.materials], [this.#object, scene.objects]])) {
      offer(select, parts.map(({ id }) => ({ value: id, label: id })));
      if (!select.value) select.selectedIndex = 0;
    }
    this.#materials.materials = scene.materials;
    this.#history.restart();
  }

  /** The server says what differs. @param {import("../messages.js").Edits} message */
  told({ edits, edit }) {
    this.#history.told(edits, edit);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    if (key === "y" || event.shiftKey) this.#history.redo();
    else this.#history.undo();
  }

  /** @param {LightInfo} light @param {number} number @returns {Row} */
  #row(light, number) {
    const id = `light-${number}`;
    const label = element("label", { htmlFor: id, textContent: light.id, title: light.form });
    const on = element("input", { type: "checkbox", id });
    const intensity = element("input", { type: "range", min: "0", max: "100", ariaLabel: `Intensity of ${light.id}` });
    const color = element("input", { type: "color", ariaLabel: `Colour of ${light.id}` });
    const edit = (/** @type {LightEdit} */ change, /** @type {string} */ what) =>
      this.#history.edit({ lights: { [light.id]: change } }, `${light.id}/${what}`);
    on.addEventListener("change", () => edit({ on: on.checked }, "on"));
    intensity.addEventListener("input", () => edit({ intensity: (intensity.valueAsNumber / MIDDLE) ** 2 }, "intensity"));
    color.addEventListener("input", () => edit({ color: fromHex(color.value) }, "color"));
    const row = element("li", { className: "light" });
    row.append(label, on, intensity, color);
    if (light.position || light.direction) {
      const words = light.position ? "Bring here" : "Shine along the view";
      const here = element("button", { type: "button", className: "button", textContent: words, ariaLabel: `${words}: ${light.id}` });
      here.addEventListener("click", () => this.#history.edit({ lights: { [light.id]: this.#here(light) } }));
      row.append(here);
    }
    this.#lights.append(row);
    return { light, on, intensity, color };
  }

  /** A light where the camera is, as far as it can be moved and turned. @param {LightInfo} light @returns {LightEdit} */
  #here(light) {
    const place = this.#place();
    const column = (/** @type {number} */ first, /** @type {number} */ sign) =>
      /** @type {[number, number, number]} */ (place.slice(first, first + 3).map((value) => sign * value));
    // It looks along −Z.
    return { ...(light.position && { position: column(12, 1) }), ...(light.direction && { direction: column(8, -1) }) };
  }

  #show() {
    const { lights, materials, objects } = this.#history.edits;
    for (const { light, on, intensity, color } of this.#rows) {
      const edit = lights[light.id];
      const factor = edit?.intensity ?? 1;
      on.checked = edit?.on ?? true;
      intensity.valueAsNumber = MIDDLE * Math.sqrt(factor);
      intensity.ariaValueText = `${factor.toFixed(2)} times`;
      color.value = toHex(edit?.color ?? light.color);
    }
    this.#materials.show(this.#material.value, materials[this.#material.value]);
    this.#objects.show(this.#object.value, objects[this.#object.value]);
    this.#undo.disabled = !this.#history.canUndo;
    this.#redo.disabled = !this.#history.canRedo;
    this.#reset.disabled = [lights, materials, objects].every((parts) => Object.keys(parts).length === 0);
  }
}
