/** The fields of one material: colour, roughness, metal, and what it emits. */

import { fromHex, toHex } from "../colors.js";
import { byId, text } from "./page.js";

/** @typedef {import("../messages.js").MaterialEdit} MaterialEdit */
/** @typedef {import("../messages.js").MaterialInfo} MaterialInfo */

const BLACK = "#000000";
const WHITE = "#ffffff";

export class MaterialFields {
  /** Of the scene. @type {readonly MaterialInfo[]} */
  materials = [];
  #fields = byId("material-fields", HTMLFieldSetElement);
  #color = byId("material-color", HTMLInputElement);
  #roughness = byId("material-roughness", HTMLInputElement);
  #metallic = byId("material-metallic", HTMLInputElement);
  #glow = byId("material-glow", HTMLInputElement);
  #radiance = byId("material-radiance", HTMLInputElement);
  #shown = "";
  /** What its radiance is, in words. */
  #radiates = "0";

  /** @param {(id: string, edit: MaterialEdit, what: string) => void} edit */
  constructor(edit) {
    const tell = (/** @type {HTMLInputElement} */ input, /** @type {() => MaterialEdit} */ change) =>
      input.addEventListener("input", () => {
        if (input.checkValidity()) edit(this.#shown, change(), input.id);
      });
    tell(this.#color, () => ({ color: fromHex(this.#color.value) }));
    tell(this.#roughness, () => ({ roughness: this.#roughness.valueAsNumber }));
    tell(this.#metallic, () => ({ metallic: this.#metallic.valueAsNumber }));
    tell(this.#radiance, () => ({ emission: this.#emission() }));
    tell(this.#glow, () => ({ emission: this.#emission() }));
    this.#radiance.addEventListener("change", () => {
      if (!this.#radiance.checkValidity()) this.#radiance.value = this.#radiates; // it would go out with a colour
    });
  }

  /** @param {string} id @param {MaterialEdit | undefined} edit  what differs of it */
  show(id, edit) {
    const material = this.materials.find((one) => one.id === id);
    this.#shown = id;
    this.#fields.hidden = !material;
    if (!material) return;
    const emission = edit?.emission ?? material.emission;
    const radiance = Math.max(...emission);
    this.#color.value = toHex(edit?.color ?? material.color);
    this.#set(this.#roughness, edit?.roughness ?? material.roughness);
    this.#set(this.#metallic, edit?.metallic ?? material.metallic);
    if (radiance > 0) this.#glow.value = toHex([emission[0] / radiance, emission[1] / radiance, emission[2] / radiance]);
    else if (this.#radiance.valueAsNumber > 0 || this.#glow.value === BLACK) this.#glow.value = WHITE;
    this.#radiates = String(Number(radiance.toPrecision(3)));
    if (document.activeElement !== this.#radiance) this.#radiance.value = this.#radiates;
  }

  /** @param {HTMLInputElement} input @param {number} value */
  #set(input, value) {
    input.valueAsNumber = value;
    text(`${input.id}-text`).textContent = value.toFixed(2);
  }

  /** @returns {[number, number, number]} */
  #emission() {
    const [red, green, blue] = fromHex(this.#glow.value);
    const scale = (this.#radiance.valueAsNumber || 0) / (Math.max(red, green, blue) || 1);
    return [scale * red, scale * green, scale * blue];
  }
}
