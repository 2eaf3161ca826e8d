/** Small marks over the picture for lights that have a place but no surface: who clicks one chooses it. */

import { put, shape } from "./svg.js";

/** @typedef {import("../viewer/camera.js").Vec3} Vec3 */
/** @typedef {{id: string, at: Vec3, color: string, on: boolean, chosen: boolean}} Mark */

export class Marks {
  #group;
  #choose;
  /** @type {{mark: Mark, group: SVGGElement}[]} */
  #marks = [];

  /** @param {SVGElement} parent @param {(id: string) => void} choose */
  constructor(parent, choose) {
    this.#choose = choose;
    // The sheet lists the same lights, for keyboards and screen readers.
    this.#group = shape(parent, "g", { class: "light-marks", "aria-hidden": "true" });
  }

  /** @param {readonly Mark[]} marks */
  show(marks) {
    const same = marks.length === this.#marks.length && marks.every(({ id }, index) => this.#marks[index]?.mark.id === id);
    if (!same) this.#make(marks);
    this.#marks.forEach((one, index) => {
      one.mark = marks[index] ?? one.mark;
      const { color, on, chosen } = one.mark;
      one.group.style.setProperty("--light", on ? color : "transparent");
      one.group.classList.toggle("chosen", chosen);
    });
  }

  /** @param {import("../viewer/projection.js").Projection} projection */
  draw(projection) {
    for (const { mark, group } of this.#marks) put(group, projection.point(mark.at));
  }

  /** @param {readonly Mark[]} marks */
  #make(marks) {
    this.#group.replaceChildren();
    this.#marks = marks.map((mark) => {
      const group = shape(this.#group, "g", { class: "light-mark" });
      shape(group, "title").textContent = mark.id;
      shape(group, "circle", { class: "reach", r: 16 });
      shape(group, "path", { d: "M0-12v-3M0 12v3M12 0h3M-12 0h-3M8.5-8.5l2-2M-8.5 8.5l-2 2M8.5 8.5l2 2M-8.5-8.5l-2-2" });
      shape(group, "circle", { class: "bulb", r: 7 });
      group.addEventListener("click", () => this.#choose(mark.id));
      return { mark, group };
    });
  }
}
