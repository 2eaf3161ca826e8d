/** Choices of how a scene's file is read, with what is taken where nothing is chosen: up, unit, origin, variant, storey. */

import { UNITS, UPS, originOf } from "../reading.js";
import { byId, text } from "./page.js";

/** @typedef {import("../protocol.js").ImportOptions} ImportOptions */
/** @typedef {import("../protocol.js").SceneInfo} SceneInfo */

/** By the length of a unit [m]. */
const UNIT_NAMES = new Map([[1, "m"], [0.01, "cm"], [0.001, "mm"], [0.3048, "ft"], [0.0254, "in"]]);

export class ReadingForm {
  #form = byId("reading", HTMLFormElement);
  #up = byId("reading-up", HTMLSelectElement);
  #unit = byId("reading-unit", HTMLSelectElement);
  #variant = byId("reading-variant", HTMLSelectElement);
  #storeys = byId("reading-storeys", HTMLSelectElement);
  #origin = byId("reading-origin", HTMLInputElement);
  #frame = text("reading-frame");
  /** In force. @type {ImportOptions} */
  #options = {};

  /** @param {(options: ImportOptions) => void} chosen */
  constructor(chosen) {
    this.#form.addEventListener("submit", (event) => event.preventDefault());
    this.#form.addEventListener("change", () => {
      const { value } = this.#origin;
      const sound = value.trim() === "" || originOf(value) !== null;
      this.#origin.setCustomValidity(sound ? "" : "Give a point as x, y, z, or “auto” for the middle of the scene.");
      if (this.#form.reportValidity()) chosen({ ...this.#options, ...this.#chosen });
    });
  }

  /** Shows how a scene was read. @param {SceneInfo} scene @param {boolean} builtin whether it has no file */
  show({ frame, options, choices }, builtin) {
    this.#options = options;
    this.#form.hidden = builtin;
    const unit = UNIT_NAMES.get(frame.metres_per_unit) ?? `${Number(frame.metres_per_unit.toPrecision(3))} m`;
    fill(this.#up, options.up ? "automatic" : `automatic: ${frame.up}`, UPS, [options.up ?? ""]);
    fill(this.#unit, options.unit ? "automatic" : `automatic: ${unit}`, UNITS, [options.unit ?? ""]);
    fill(this.#variant, "as in the file", choices.variant ?? [], [options.variant ?? ""]);
    fill(this.#storeys, "all", choices.storey ?? [], options.storeys?.length ? options.storeys : [""]);
    this.#origin.value = Array.isArray(options.origin) ? options.origin.join(", ") : (options.origin ?? "");
    this.#origin.placeholder = frame.origin.join(", ");
    this.#origin.setCustomValidity("");
    this.#frame.textContent = `Metres count from ${frame.origin.join(", ")} in the file: x, y, z, or “auto”, its middle.`;
  }

  /** @returns {ImportOptions} */
  get #chosen() {
    return {
      up: UPS.find((axis) => axis === this.#up.value) ?? null,
      unit: UNITS.find((name) => name === this.#unit.value) ?? null,
      origin: originOf(this.#origin.value),
      variant: this.#variant.value || null,
      storeys: [...this.#storeys.selectedOptions].map(({ value }) => value).filter((value) => value !== ""),
    };
  }
}

/**
 * Offers the names after what is taken when none is chosen; the field is hidden when there are none.
 * @param {HTMLSelectElement} select @param {string} automatic @param {readonly string[]} names @param {readonly string[]} chosen
 */
function fill(select, automatic, names, chosen) {
  select.replaceChildren(new Option(automatic, ""), ...names.map((name) => new Option(name)));
  for (const option of select.options) option.selected = chosen.includes(option.value);
  select.closest(".field")?.toggleAttribute("hidden", names.length === 0);
}
