/** The fields of one object: whether it is there, and by how much it is moved. */

import { byId } from "./page.js";
import { PlaceFields } from "./place-fields.js";

/** @typedef {import("../messages.js").ObjectEdit} ObjectEdit */

export class ObjectFields {
  #fields = byId("object-fields", HTMLFieldSetElement);
  #visible = byId("object-visible", HTMLInputElement);
  #place;
  #shown = "";

  /** @param {(id: string, edit: ObjectEdit, what: string) => void} edit @param {() => number} step  of an arrow key [m] */
  constructor(edit, step) {
    this.#visible.addEventListener("change", () => edit(this.#shown, { visible: this.#visible.checked }, "visible"));
    const inputs = ["x", "y", "z"].map((axis) => byId(`object-${axis}`, HTMLInputElement));
    this.#place = new PlaceFields(inputs, (offset) => edit(this.#shown, { offset }, "offset"), step);
  }

  /** @param {string} id @param {ObjectEdit | undefined} edit  what differs of it */
  show(id, edit) {
    this.#shown = id;
    this.#fields.hidden = !id;
    this.#visible.checked = edit?.visible ?? true;
    this.#place.show(edit?.offset ?? [0, 0, 0]);
  }
}
