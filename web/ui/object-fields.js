/** The fields of one object: whether it is there, by how much it is moved and turned, and how large it is. */

import { byId } from "./page.js";
import { NumberFields } from "./number-fields.js";

/** @typedef {import("../messages.js").ObjectEdit} ObjectEdit */

/** Of an arrow key. */
const SCALE_STEP = 0.05;

export class ObjectFields {
  #fields = byId("object-fields", HTMLFieldSetElement);
  #visible = byId("object-visible", HTMLInputElement);
  #place;
  #turn;
  #scale;
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
    this.#scale = new NumberFields([byId("object-scale", HTMLInputElement)], ([scale = 1]) => edit(this.#shown, { scale }, "scale"), () => SCALE_STEP);
  }

  /** @param {string} id @param {ObjectEdit | undefined} edit  what differs of it */
  show(id, edit) {
    this.#shown = id;
    this.#fields.hidden = !id;
    this.#visible.checked = edit?.visible ?? true;
    this.#place.show(edit?.offset ?? [0, 0, 0]);
    this.#turn.show(edit?.rotation ?? [0, 0, 0]);
    this.#scale.show([edit?.scale ?? 1]);
  }
}
