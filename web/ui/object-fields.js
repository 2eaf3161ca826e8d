/** The fields of one object: whether it is there, and by how much it is moved and turned. */

import { byId } from "./page.js";
import { NumberFields } from "./number-fields.js";

/** @typedef {import("../messages.js").ObjectEdit} ObjectEdit */

export class ObjectFields {
  #fields = byId("object-fields", HTMLFieldSetElement);
  #visible = byId("object-visible", HTMLInputElement);
  #place;
  #turn;
  #shown = "";

  /**
   * @param {(id: string, edit: ObjectEdit, what: string) => void} edit
   * @param {() => number} step  of an arrow key [m] @param {() => number} turnStep  and [°]
   */
  constructor(edit, step, turnStep) {
    this.#visible.addEventListener("change", () => edit(this.#shown, { visible: this.#visible.checked }, "visible"));
    const inputs = (/** @type {string} */ of) => ["x", "y", "z"].map((axis) => byId(`object-${of}${axis}`, HTMLInputElement));
    this.#place = new NumberFields(inputs(""), ([x = 0, y = 0, z = 0]) => edit(this.#shown, { offset: [x, y, z] }, "offset"), step);
    this.#turn = new NumberFields(inputs("turn-"), ([x = 0, y = 0, z = 0]) => edit(this.#shown, { rotation: [x, y, z] }, "rotation"), turnStep);
  }

  /** @param {string} id @param {ObjectEdit | undefined} edit  what differs of it */
  show(id, edit) {
    this.#shown = id;
    this.#fields.hidden = !id;
    this.#visible.checked = edit?.visible ?? true;
    this.#place.show(edit?.offset ?? [0, 0, 0]);
    this.#turn.show(edit?.rotation ?? [0, 0, 0]);
  }
}
