/** A light in the list: on or off, how bright, of which colour; and where, if it has a place. */

import { fromHex, toHex } from "../colors.js";
import { element } from "./page.js";
import { PlaceFields } from "./place-fields.js";

/** @typedef {import("../messages.js").LightEdit} LightEdit */
/** @typedef {import("../messages.js").LightInfo} LightInfo */

/**
 * @typedef {object} LightEvents
 * @property {(edit: LightEdit, what: string | null) => void} edit  what: the gesture that it is of
 * @property {() => number[]} camera  its place, column-major, camera to world
 * @property {() => number} step  of an arrow key [m]
 * @property {() => void} choose  to be moved, or no more
 */

/** Where a slider leaves a light as its file has it, of 100: its square is the factor, so that there is room for the dark. */
const MIDDLE = 50;

export class LightRow {
  row = element("li", { className: "light" });
  light;
  #on;
  #intensity;
  #color;
  #events;
  /** @type {{choose: HTMLButtonElement, list: HTMLElement, fields: PlaceFields} | null} */
  #place = null;

  /** @param {LightInfo} light @param {number} number @param {LightEvents} events */
  constructor(light, number, events) {
    this.light = light;
    this.#events = events;
    const id = `light-${number}`;
    const label = element("label", { htmlFor: id, textContent: light.id, title: light.form });
    this.#on = element("input", { type: "checkbox", id });
    this.#intensity = element("input", { type: "range", min: "0", max: "100", ariaLabel: `Intensity of ${light.id}` });
    this.#color = element("input", { type: "color", ariaLabel: `Colour of ${light.id}` });
    this.#on.addEventListener("change", () => events.edit({ on: this.#on.checked }, "on"));
    this.#intensity.addEventListener("input", () => events.edit({ intensity: (this.#intensity.valueAsNumber / MIDDLE) ** 2 }, "intensity"));
    this.#color.addEventListener("input", () => events.edit({ color: fromHex(this.#color.value) }, "color"));
    this.row.append(label, this.#on, this.#intensity, this.#color);
    if (light.position || light.direction) this.#addPlace();
  }

  /** Where it is, if it has a place. @param {LightEdit | undefined} edit @returns {[number, number, number] | null} */
  at(edit) {
    return this.light.position && (edit?.position ?? this.light.position);
  }

  /** @param {LightEdit | undefined} edit  what differs of it @param {boolean} chosen */
  show(edit, chosen) {
    const factor = edit?.intensity ?? 1;
    this.#on.checked = edit?.on ?? true;
    this.#intensity.valueAsNumber = MIDDLE * Math.sqrt(factor);
    this.#intensity.ariaValueText = `${factor.toFixed(2)} times`;
    this.#color.value = toHex(edit?.color ?? this.light.color);
    if (chosen) this.row.setAttribute("aria-current", "true");
    else this.row.removeAttribute("aria-current");
    const at = this.at(edit);
    if (!this.#place || !at) return;
    this.#place.choose.setAttribute("aria-expanded", String(chosen));
    this.#place.list.hidden = !chosen;
    this.#place.fields.show(at);
  }

  #addPlace() {
    const { light } = this;
    const words = light.position ? "Bring here" : "Shine along the view";
    const here = element("button", { type: "button", className: "button", textContent: words, ariaLabel: `${words}: ${light.id}` });
    here.addEventListener("click", () => this.#events.edit(this.#here(), null));
    const buttons = element("div", { className: "buttons" });
    buttons.append(here);
    this.row.append(buttons);
    if (!light.position) return;
    const choose = element("button", { type: "button", className: "button", textContent: "Move", ariaLabel: `Move: ${light.id}` });
    choose.addEventListener("click", () => this.#events.choose());
    buttons.prepend(choose);
    const list = element("div", { className: "place" });
    const inputs = ["X", "Y", "Z"].map((axis) => {
      const input = element("input", { type: "number", step: "any", ariaLabel: `${axis} [m] of ${light.id}` });
      const label = element("label", { textContent: `${axis} [m]` });
      label.append(input);
      list.append(label);
      return input;
    });
    this.row.append(list);
    this.#place = { choose, list, fields: new PlaceFields(inputs, (position) => this.#events.edit({ position }, "position"), this.#events.step) };
  }

  /** The light where the camera is, as far as it can be moved and turned. @returns {LightEdit} */
  #here() {
    const { position, direction } = this.light;
    const camera = this.#events.camera();
    const column = (/** @type {number} */ first, /** @type {number} */ sign) =>
      /** @type {[number, number, number]} */ (camera.slice(first, first + 3).map((value) => sign * value));
    // It looks along −Z.
    return { ...(position && { position: column(12, 1) }), ...(direction && { direction: column(8, -1) }) };
  }
}
