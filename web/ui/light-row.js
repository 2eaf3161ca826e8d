/** A light in the list: on or off, how bright, of which colour; and where, if it has a place, and where it shines, if it has a direction. */

import { fromHex, toHex } from "../colors.js";
import { fromAim, toAim } from "../turning.js";
import { element } from "./page.js";
import { SunFields } from "./sun-fields.js";
import { NumberFields } from "./number-fields.js";

/** @typedef {import("../messages.js").LightEdit} LightEdit */
/** @typedef {import("../messages.js").LightInfo} LightInfo */
/** @typedef {[number, number, number]} Vec3 */

/**
 * @typedef {object} LightEvents
 * @property {(edit: LightEdit, what: string | null) => void} edit  what: the gesture that it is of
 * @property {() => number[]} camera  its place, column-major, camera to world
 * @property {() => number} step  of an arrow key [m]
 * @property {() => number} turnStep  and [°]
 * @property {() => void} choose  to be moved or turned, or no more
 */

/** Where a slider leaves a light as its file has it, of 100: its square is the factor, so that there is room for the dark. */
const MIDDLE = 50;
/** What a number can be, as the server has it of places [m]. */
const REACH = { min: "-1e9", max: "1e9" };

export class LightRow {
  row = element("li", { className: "light" });
  light;
  #on;
  #intensity;
  #color;
  #events;
  /** @type {HTMLButtonElement | null} */
  #choose = null;
  /** What is shown while it is chosen. @type {{list: HTMLElement, fields: NumberFields, shown: (edit: LightEdit | undefined, sun: Vec3 | undefined) => readonly number[]}[]} */
  #fields = [];
  /** @type {SunFields | null} */
  #sun = null;

  /** @param {LightInfo} light @param {number} number @param {LightEvents} events */
  constructor(light, number, events) {
    this.light = light;
    this.#events = events;
    const id = `light-${number}`;
    const label = element("label", { htmlFor: id, textContent: light.id, title: light.form });
    if (light.added) label.append(" ", element("small", { textContent: "not in the file" }));
    this.#on = element("input", { type: "checkbox", id });
    this.#intensity = element("input", { type: "range", min: "0", max: "100", ariaLabel: `Intensity of ${light.id}` });
    this.#color = element("input", { type: "color", ariaLabel: `Colour of ${light.id}` });
    this.#on.addEventListener("change", () => events.edit({ on: this.#on.checked }, "on"));
    this.#intensity.addEventListener("input", () => events.edit({ intensity: (this.#intensity.valueAsNumber / MIDDLE) ** 2 }, "intensity"));
    this.#color.addEventListener("input", () => events.edit({ color: fromHex(this.#color.value) }, "color"));
    this.row.append(label, this.#on, this.#intensity, this.#color);
    if (light.position || light.direction) this.#addPlace();
    if (light.form === "directional" || light.form === "sky") this.#addSun();
  }

  /** Where it is, if it has a place. @param {LightEdit | undefined} edit @returns {[number, number, number] | null} */
  at(edit) {
    return this.light.position && (edit?.position ?? this.light.position);
  }

  /** @param {LightEdit | undefined} edit  what differs of it @param {Vec3 | undefined} sun  where it shines if it is that @param {boolean} chosen */
  show(edit, sun, chosen) {
    const factor = edit?.intensity ?? 1;
    this.#on.checked = edit?.on ?? (!this.light.added || Boolean(edit?.date));
    this.#intensity.valueAsNumber = MIDDLE * Math.sqrt(factor);
    this.#intensity.ariaValueText = `${factor.toFixed(2)} times`;
    this.#color.value = toHex(edit?.color ?? this.light.color);
    if (chosen) this.row.setAttribute("aria-current", "true");
    else this.row.removeAttribute("aria-current");
    this.#choose?.setAttribute("aria-expanded", String(chosen));
    for (const { list, fields, shown } of this.#fields) {
      list.hidden = !chosen;
      fields.show(shown(edit, sun));
    }
    if (!this.#sun) return;
    this.#sun.list.hidden = !chosen && this.light.form === "directional" && !this.light.added; // a sky is never chosen
    this.#sun.show(edit);
  }

  #addPlace() {
    const { light } = this;
    const words = light.position ? "Bring here" : "Shine along the view";
    const here = element("button", { type: "button", className: "button", textContent: words, ariaLabel: `${words}: ${light.id}` });
    here.addEventListener("click", () => this.#events.edit(this.#here(), null));
    const buttons = element("div", { className: "buttons" });
    const moves = light.position ? (light.direction ? "Move and turn" : "Move") : "Turn";
    this.#choose = element("button", { type: "button", className: "button", textContent: moves, ariaLabel: `${moves}: ${light.id}` });
    this.#choose.addEventListener("click", () => this.#events.choose());
    buttons.append(this.#choose, here);
    this.row.append(buttons);
    const { position, direction } = light;
    if (position) {
      const changed = (/** @type {number[]} */ [x = 0, y = 0, z = 0]) => this.#events.edit({ position: [x, y, z] }, "position");
      this.#addFields(["X [m]", "Y [m]", "Z [m]"], changed, this.#events.step, (edit) => edit?.position ?? position);
    }
    if (direction) {
      const changed = (/** @type {number[]} */ [azimuth = 0, elevation = 0]) => this.#events.edit({ direction: fromAim(azimuth, elevation) }, "direction");
      this.#addFields(["azimuth [°]", "elevation [°]"], changed, this.#events.turnStep, (edit, sun) => toAim(edit?.direction ?? sun ?? direction));
    }
  }

  #addSun() {
    this.#sun = new SunFields(this.light.id, this.#events.edit);
    this.row.append(this.#sun.list);
  }

  /**
   * @param {string[]} names @param {(values: number[]) => void} changed @param {() => number} step
   * @param {(edit: LightEdit | undefined, sun: Vec3 | undefined) => readonly number[]} shown
   */
  #addFields(names, changed, step, shown) {
    const list = element("div", { className: "place" });
    const inputs = names.map((name) => {
      const input = element("input", { type: "number", step: "any", ...REACH, ariaLabel: `${name} of ${this.light.id}` });
      const label = element("label", { textContent: name });
      label.append(input);
      list.append(label);
      return input;
    });
    this.row.append(list);
    this.#fields.push({ list, fields: new NumberFields(inputs, changed, step), shown });
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
