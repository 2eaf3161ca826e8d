/** The settings panel: resolution, the render settings that the server's schema names, and what is known of the scene. */

import { SettingsForm } from "./form.js";
import { button, byId, element, text } from "./page.js";
import { fieldsOf } from "./schema.js";

/** @typedef {import("../protocol.js").SceneInfo} SceneInfo */
/** @typedef {import("./form.js").Values} Values */

/**
 * @typedef {object} PanelEvents
 * @property {(settings: Values) => void} settings  what differs from the defaults
 * @property {(scale: number | null) => void} scale  of the window's pixels; null: chosen by itself
 */

export class Panel {
  #panel = text("panel");
  #toggle = button("toggle-panel");
  #resolution = byId("resolution", HTMLInputElement);
  #automatic = byId("automatic", HTMLInputElement);
  #resolutionText = byId("resolution-text", HTMLOutputElement);
  #problem = text("settings-problem");
  #form;
  #schema = "";
  /** What differs from the defaults. @type {Values} */
  values = {};
  /** @type {import("./schema.js").Field[]} */
  #fields = [];

  /** @param {PanelEvents} events */
  constructor(events) {
    this.#form = new SettingsForm(text("fields"), (values) => {
      this.values = values;
      this.problem("");
      events.settings(values);
    });
    this.#resolution.addEventListener("input", () => events.scale(this.#resolution.valueAsNumber));
    this.#automatic.addEventListener("change", () => {
      events.scale(this.#automatic.checked ? null : this.#resolution.valueAsNumber);
    });
    byId("settings", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
    button("defaults").addEventListener("click", () => {
      this.values = {};
      this.#form.set(this.values);
      this.problem("");
      events.settings(this.values);
      events.scale(null);
    });
    this.#toggle.addEventListener("click", () => this.open(!this.isOpen));
    button("close-panel").addEventListener("click", () => this.open(false));
    this.#panel.addEventListener("keydown", (event) => event.key === "Escape" && this.open(false));
  }

  /** @param {boolean} open the keyboard follows: into the panel, and back to its button */
  open(open) {
    this.#panel.hidden = !open;
    this.#toggle.setAttribute("aria-expanded", String(open));
    (open ? this.#panel : this.#toggle).focus({ preventScroll: true });
  }

  get isOpen() {
    return !this.#panel.hidden;
  }

  /** @param {import("./schema.js").JsonSchema} schema of the render settings */
  describe(schema) {
    const words = JSON.stringify(schema);
    if (words === this.#schema) return; // after a reconnection: leave the controls, one may have the focus
    this.#schema = words;
    this.#fields = fieldsOf(schema);
    this.#form.show(this.#fields, this.values);
  }

  /** The value in force of a setting. @param {string} name */
  value(name) {
    return this.values[name] ?? this.#fields.find((field) => field.name === name)?.initial;
  }

  /** @param {import("../viewer/lens.js").Lens} lens */
  size({ wantedScale, scale, size: [width, height] }) {
    this.#automatic.checked = wantedScale === null;
    this.#resolution.value = String(scale);
    this.#resolutionText.textContent = `${width} × ${height}`;
  }

  /** @param {SceneInfo} scene */
  scene(scene) {
    text("scene-facts").textContent = `${scene.name}: ${scene.triangles.toLocaleString("en")} triangles`;
    text("scene-notes").replaceChildren(...scene.notes.map((note) => element("li", { textContent: note })));
  }

  /** Says why the settings were refused; an empty text takes it back. @param {string} words */
  problem(words) {
    this.#problem.textContent = words;
    this.#problem.hidden = words === "";
  }
}
