/** The settings panel: how frames are sent, the settings of the server's schema, light or dark, how a scene is read. */

import { Costs } from "../costs.js";
import { SettingsForm } from "./form.js";
import { button, byId, element, text } from "./page.js";
import { ReadingForm } from "./reading-form.js";
import { accepted, fieldsOf } from "./schema.js";
import { Sheet } from "./sheet.js";
import { chooseTheme, theme } from "./theme.js";

/** @typedef {import("../protocol.js").SceneInfo} SceneInfo */
/** @typedef {import("../protocol.js").Stream} Stream */
/** @typedef {import("./form.js").Values} Values */

/**
 * @typedef {object} PanelEvents
 * @property {(settings: Values) => void} settings  what differs from the defaults
 * @property {(stream: Stream) => void} stream
 * @property {(options: import("../protocol.js").ImportOptions) => void} reading  how the scene's file is to be read
 */

/** The quality that is not said. */
const USUAL = "balanced";

export class Panel {
  sheet = new Sheet("panel");
  #automatic = byId("motion-automatic", HTMLInputElement);
  #scale = byId("motion-scale", HTMLInputElement);
  #scaleText = text("motion-text");
  #lossless = byId("lossless", HTMLInputElement);
  #video = byId("video", HTMLSelectElement);
  #problem = text("settings-problem");
  #costs = new Costs();
  #qualities = /** @type {NodeListOf<HTMLInputElement>} */ (text("quality").querySelectorAll("input"));
  #form;
  #reading;
  #schema = "";
  /** What differs from the defaults. @type {Values} */
  values = {};
  /** @type {import("./schema.js").Field[]} */
  #fields = [];

  /** @param {PanelEvents} events */
  constructor(events) {
    const change = () => {
      this.values = { ...this.#form.values, ...(this.#quality !== USUAL && { quality: this.#quality }) };
      this.problem("");
      events.settings(this.values);
    };
    this.#form = new SettingsForm(text("fields"), text("advanced-fields"), change);
    text("quality").addEventListener("change", change);
    this.#reading = new ReadingForm(events.reading);
    this.#scale.addEventListener("input", () => {
      this.#automatic.checked = false;
      this.#showScale();
      events.stream(this.stream);
    });
    for (const control of [this.#automatic, this.#lossless, this.#video]) {
      control.addEventListener("change", () => {
        this.#showScale();
        events.stream(this.stream);
      });
    }
    byId("settings", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
    button("defaults").addEventListener("click", () => {
      this.#set({});
      this.#automatic.checked = true;
      this.#lossless.checked = false;
      this.#video.value = "auto";
      this.#showScale();
      events.settings(this.values);
      events.stream(this.stream);
    });
    const radios = /** @type {NodeListOf<HTMLInputElement>} */ (text("theme").querySelectorAll("input"));
    for (const radio of radios) {
      radio.checked = radio.value === theme();
      radio.addEventListener("change", () => chooseTheme(radio.value));
    }
    this.#showScale();
  }

  /** @returns {Stream} */
  get stream() {
    return {
      motion_scale: this.#automatic.checked ? null : this.#scale.valueAsNumber,
      lossless: this.#lossless.checked,
      video: this.#video.value === "auto" ? null : this.#video.value === "always",
    };
  }

  /** @param {boolean} there both this browser and the server take it */
  offerVideo(there) {
    this.#video.disabled = !there;
    text("video-hint").textContent = there
      ? "H.264: a tenth of the bytes, softer; JPEG when still"
      : "needs a secure page (https), and a server and browser with H.264";
  }

  /** @param {import("./schema.js").JsonSchema} schema of the render settings */
  describe(schema) {
    const words = JSON.stringify(schema);
    if (words === this.#schema) return; // after a reconnection: leave the controls, one may have the focus
    this.#schema = words;
    this.#fields = fieldsOf(schema);
    this.#form.show(this.#fields.filter(({ name }) => name !== "quality"), this.values);
  }

  /** The value in force of a setting. @param {string} name */
  value(name) {
    return this.values[name] ?? this.#fields.find((field) => field.name === name)?.initial;
  }

  /** Takes from these words what is a setting with a value that it can have. @param {Readonly<Record<string, string>>} words @returns {Values} */
  take(words) {
    this.#set(accepted(this.#fields, words));
    return this.values;
  }

  /** How many frames a still view's picture is of, by quality. @param {Readonly<Record<string, number>>} frames */
  set stillFrames(frames) {
    this.#costs.frames = frames;
    this.#showCosts();
  }

  /** A frame of what is set now is there: it tells what that costs. @param {import("../protocol.js").Frame} frame @param {string} scene  its id */
  measured(frame, scene) {
    if (frame.phase === "moving") return;
    this.#costs.learn(this.#quality, frame, `${scene} ${this.value("method")}`);
    this.#showCosts();
  }

  /** @param {Values} values */
  #set(values) {
    this.values = values;
    this.#form.set(values);
    for (const radio of this.#qualities) radio.checked = radio.value === (values["quality"] ?? USUAL);
    this.problem("");
  }

  get #quality() {
    return [...this.#qualities].find(({ checked }) => checked)?.value ?? USUAL;
  }

  #showCosts() {
    for (const { value } of this.#qualities) text(`cost-${value}`).textContent = this.#costs.words(value);
  }

  /** @param {SceneInfo} scene @param {boolean} builtin */
  scene(scene, builtin) {
    const { min, max } = scene.bounds;
    const size = max.map((high, axis) => Number((high - (min[axis] ?? 0)).toPrecision(3)).toLocaleString("en"));
    text("scene-facts").textContent = `${scene.name}: ${scene.triangles.toLocaleString("en")} triangles, ${size.join(" × ")} m`;
    this.#reading.show(scene, builtin);
    text("scene-notes").replaceChildren(...scene.notes.map((note) => element("li", { textContent: note })));
  }

  /** Says why the settings were refused; an empty text takes it back. @param {string} words */
  problem(words) {
    this.#problem.textContent = words;
    this.#problem.hidden = words === "";
  }

  #showScale() {
    this.#scaleText.textContent = this.#automatic.checked ? "by speed" : `${100 * this.#scale.valueAsNumber} %`;
  }
}
