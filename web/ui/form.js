/** A form made of a schema's fields; its value holds what differs from the defaults. */

import { element } from "./page.js";

/** @typedef {import("./schema.js").Field} Field */
/** @typedef {Record<string, unknown>} Values */

/** @typedef {{field: Field, input: HTMLInputElement | HTMLSelectElement}} Control */

/** Names of fields that need no knowledge of methods. */
const PLAIN = new Set(["method", "component", "exposure"]);

export class SettingsForm {
  /** @type {Control[]} */
  #controls = [];
  #container;
  #advanced;
  #onChange;

  /**
   * @param {HTMLElement} container @param {HTMLElement} advanced for all but a few
   * @param {(values: Values) => void} onChange called with each valid change by the user
   */
  constructor(container, advanced, onChange) {
    this.#container = container;
    this.#advanced = advanced;
    this.#onChange = onChange;
  }

  /** Shows these fields. @param {readonly Field[]} fields @param {Values} values what differs from the defaults */
  show(fields, values) {
    this.#controls = fields.map((field) => ({ field, input: inputFor(field) }));
    const rows = (/** @type {boolean} */ plain) =>
      this.#controls.filter(({ field }) => PLAIN.has(field.name) === plain).map((control) => this.#row(control));
    this.#container.replaceChildren(...rows(true));
    this.#advanced.replaceChildren(...rows(false));
    this.set(values);
  }

  /** @param {Values} values what differs from the defaults */
  set(values) {
    for (const { field, input } of this.#controls) {
      const value = field.name in values ? values[field.name] : field.initial;
      if (field.kind === "switch") /** @type {HTMLInputElement} */ (input).checked = Boolean(value);
      else input.value = value === null ? "" : String(value);
      markValidity(field, input);
    }
  }

  /** @returns {Values} what differs from the defaults */
  get values() {
    const read = this.#controls.map(({ field, input }) => /** @type {const} */ ([field, valueOf(field, input)]));
    return Object.fromEntries(
      read.filter(([field, value]) => value !== field.initial).map(([field, value]) => [field.name, value]),
    );
  }

  /** @param {Control} control */
  #row({ field, input }) {
    const row = element("div", { className: `field ${field.kind}` });
    const label = element("label", { htmlFor: input.id, textContent: field.label });
    row.append(label, input);
    if (field.hint) {
      const hint = element("p", { className: "hint", id: `${input.id}-hint`, textContent: field.hint });
      input.setAttribute("aria-describedby", hint.id);
      row.append(hint);
    }
    input.addEventListener("change", () => {
      if (markValidity(field, input) && this.#controls.every((control) => control.input.checkValidity())) {
        this.#onChange(this.values);
      } else {
        input.reportValidity();
      }
    });
    return row;
  }
}

/** @param {Field} field @returns {HTMLInputElement | HTMLSelectElement} */
function inputFor(field) {
  const common = { id: `setting-${field.name}`, name: field.name };
  if (field.kind === "choice") {
    const select = element("select", common);
    if (field.optional) select.append(new Option("auto", ""));
    select.append(...field.choices.map((choice) => new Option(choice)));
    return select;
  }
  if (field.kind === "switch") return element("input", { ...common, type: "checkbox" });
  return element("input", {
    ...common,
    type: "number",
    inputMode: field.kind === "integer" ? "numeric" : "decimal",
    step: field.kind === "integer" ? "1" : "any",
    min: field.min === null ? "" : String(field.min),
    max: field.max === null ? "" : String(field.max),
    required: !field.optional,
    placeholder: field.optional ? "auto" : "",
  });
}

/** @param {Field} field @param {HTMLInputElement | HTMLSelectElement} input */
function valueOf(field, input) {
  if (field.kind === "switch") return /** @type {HTMLInputElement} */ (input).checked;
  if (input.value === "") return null;
  return field.kind === "choice" ? input.value : Number(input.value);
}

/** @param {Field} field @param {HTMLInputElement | HTMLSelectElement} input @returns {boolean} whether it is valid */
function markValidity({ min, open }, input) {
  input.setCustomValidity(open && input.value !== "" && Number(input.value) === min ? `Value must be greater than ${min}.` : "");
  const valid = input.checkValidity();
  input.setAttribute("aria-invalid", String(!valid));
  return valid;
}
