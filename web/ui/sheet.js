/** A sheet that comes and goes by its button `toggle-ID`, `close-ID` or Escape; one is open at a time. */

import { button, text } from "./page.js";

/** @type {Sheet | null} */
let shown = null;

export class Sheet {
  /** Called when it comes or goes. @type {(open: boolean) => void} */
  onShow = () => {};
  #sheet;
  #toggle;

  /** @param {string} id */
  constructor(id) {
    this.#sheet = text(id);
    this.#toggle = button(`toggle-${id}`);
    this.#toggle.addEventListener("click", () => this.toggle());
    button(`close-${id}`).addEventListener("click", () => this.#close());
    this.#sheet.addEventListener("keydown", (event) => event.key === "Escape" && this.#close());
  }

  /** The keyboard follows: into the sheet, and back to its button. */
  toggle() {
    if (shown === this) this.#close();
    else this.open();
  }

  open() {
    if (shown === this) return;
    if (shown) shown.#show(false);
    shown = this;
    this.#show(true);
    this.#sheet.focus({ preventScroll: true });
  }

  #close() {
    this.#show(false);
    shown = null;
    this.#toggle.focus({ preventScroll: true });
  }

  /** @param {boolean} open */
  #show(open) {
    this.#sheet.hidden = !open;
    this.#toggle.setAttribute("aria-expanded", String(open));
    this.onShow(open);
  }
}
