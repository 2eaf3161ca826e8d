/** The fields of a directional light that is the sun of a date, or of a sky that is of one: day and hour as sliders, its place, and where north is. */

import { dateOf, momentOf, wordsOf } from "../sun.js";
import { NumberFields } from "./number-fields.js";
import { element } from "./page.js";

/** @typedef {import("../messages.js").LightEdit} LightEdit */

/** @type {[number, number]} */
const PLACE = [50, Math.max(-180, Math.min(-new Date().getTimezoneOffset() / 4, 180))]; // the viewer's zone
const MIDSUMMER = 172;

export class SunFields {
  list = element("div", { className: "sun" });
  #edit;
  #on;
  #more = element("div", {});
  #day;
  #hour;
  #place;
  /** What the sliders show. */
  #now = { year: new Date().getFullYear(), day: MIDSUMMER, hour: 12 };
  #at = PLACE;
  #north = 0;

  /** @param {string} id of the light @param {(edit: LightEdit, what: string | null) => void} edit  what: the gesture that it is of */
  constructor(id, edit) {
    this.#edit = edit;
    this.#on = element("input", { type: "checkbox", ariaLabel: `Sun by date: ${id}` });
    const label = element("label", { className: "switch field", textContent: "sun by date" });
    label.append(this.#on);
    this.#on.addEventListener("change", () => (this.#on.checked ? this.#tell(null) : edit({ date: null, place: null, north: null }, null)));
    this.#day = this.#slider(`Day of ${id}`, 1, 365, 1, (day) => (this.#now.day = day));
    this.#hour = this.#slider(`Hour of ${id}`, 0, 23.75, 0.25, (hour) => (this.#now.hour = hour));
    const names = /** @type {const} */ ([["latitude [°]", 90], ["longitude [°]", 180], ["north [°]", 360]]);
    const row = element("div", { className: "place" });
    const inputs = names.map(([name, most]) => {
      const input = element("input", { type: "number", step: "any", min: String(-most), max: String(most), ariaLabel: `${name} of ${id}` });
      const label = element("label", { textContent: name });
      label.append(input);
      row.append(label);
      return input;
    });
    const changed = (/** @type {number[]} */ [latitude = 0, longitude = 0, north = 0]) => {
      [this.#at, this.#north] = [[latitude, longitude], north];
      this.#tell("place");
    };
    this.#place = new NumberFields(inputs, changed, () => 1);
    this.#more.append(row);
    this.list.append(label, this.#more);
  }

  /** @param {LightEdit | undefined} edit  what differs of the light */
  show(edit) {
    const { date, place, north } = edit ?? {};
    this.#on.checked = Boolean(date);
    this.#more.hidden = !date;
    if (place) this.#at = place;
    this.#north = north ?? this.#north;
    if (date) this.#now = momentOf(date, this.#at[1]);
    this.#place.show([...this.#at, this.#north]);
    const words = wordsOf(this.#now);
    for (const [slider, value, word] of /** @type {const} */ ([[this.#day, this.#now.day, words[0]], [this.#hour, this.#now.hour, words[1]]])) {
      slider.input.valueAsNumber = value;
      slider.input.ariaValueText = slider.text.textContent = word;
    }
  }

  /** @param {string} name @param {number} min @param {number} max @param {number} step @param {(value: number) => void} changed */
  #slider(name, min, max, step, changed) {
    const input = element("input", { type: "range", min: String(min), max: String(max), step: String(step), ariaLabel: name });
    const text = element("span", {});
    input.addEventListener("input", () => {
      changed(input.valueAsNumber);
      this.#tell("date");
    });
    const row = element("div", { className: "slider" });
    row.append(input, text);
    this.#more.append(row);
    return { input, text };
  }

  /** @param {string | null} what */
  #tell(what) {
    const date = dateOf(this.#now, this.#at[1]);
    this.#edit({ date, place: this.#at, north: this.#north, direction: null }, what);
  }
}
