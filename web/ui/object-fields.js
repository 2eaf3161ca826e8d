/** The fields of one object: whether it is there, and by how much it is moved. */

import { byId } from "./page.js";

/** @typedef {import("../messages.js").ObjectEdit} ObjectEdit */

export class ObjectFields {
  #fields = byId("object-fields", HTMLFieldSetElement);
  #visible = byId("object-visible", HTMLInputElement);
  #offsets = ["x", "y", "z"].map((axis) => byId(`object-${axis}`, HTMLInputElement));
  #shown = "";

  /** @param {(id: string, edit: ObjectEdit, what: string) => void} edit */
  constructor(edit) {
    this.#visible.addEventListener("change", () => edit(this.#shown, { visible: this.#visible.checked }, "visible"));
    for (const input of this.#offsets) {
      input.addEventListener("input", () => {
        if (input.checkValidity()) edit(this.#shown, { offset: this.#offset() }, input.id);
      });
    }
  }

  /** @param {string} id @param {ObjectEdit | undefined} edit  what differs of it */
  show(id, edit) {
    this.#shown = id;
    this.#fields.disabled = !id;
    this.#visible.checked = edit?.visible ?? true;
    this.#offsets.forEach((input, axis) => {
      if (document.activeElement !== input) input.value = String(edit?.offset?.[axis] ?? 0);
    });
  }

  /** @returns {[number, number, number]} */
  #offset() {
    const [x = 0, y = 0, z = 0] = this.#offsets.map((input) => input.valueAsNumber || 0);
    return [x, y, z];
  }
}
