/** What the page waits for or cannot do, in the middle while there is no picture, above it later; and passing words. */

import { button, byId, text } from "./page.js";

/** @typedef {{title: string, detail?: string, fraction?: number | null, retry?: boolean}} Words  fraction null: unknown */

const TOAST_SECONDS = 2;
const LONG_SECONDS = 8;

export class Notice {
  #box = text("notice");
  #title = text("notice-title");
  #detail = text("notice-detail");
  #progress = byId("notice-progress", HTMLProgressElement);
  #retry = button("notice-retry");
  #toast = text("toast");
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #toastTimer;

  /** @param {() => void} onRetry */
  constructor(onRetry) {
    this.#retry.addEventListener("click", onRetry);
  }

  /** @param {Words} words without `fraction`, no progress bar */
  show({ title, detail = "", fraction, retry = false }) {
    this.#title.textContent = title;
    this.#detail.textContent = detail;
    this.#progress.hidden = fraction === undefined;
    if (typeof fraction === "number") this.#progress.value = fraction;
    else this.#progress.removeAttribute("value");
    this.#retry.hidden = !retry;
    this.#box.hidden = false;
  }

  hide() {
    this.#box.hidden = true;
  }

  /** Says something for a moment. @param {string} words */
  say(words) {
    this.#pop(words, false, TOAST_SECONDS);
  }

  /** Says what nobody has asked for just now, long enough to read. @param {string} words */
  tell(words) {
    this.#pop(words, false, LONG_SECONDS);
  }

  /** Says what went wrong, long enough to read. @param {string} words */
  complain(words) {
    this.#pop(words, true, LONG_SECONDS);
  }

  /** @param {string} words @param {boolean} problem @param {number} seconds */
  #pop(words, problem, seconds) {
    this.#toast.textContent = words;
    this.#toast.classList.toggle("problem", problem);
    this.#toast.hidden = false;
    clearTimeout(this.#toastTimer);
    this.#toastTimer = setTimeout(() => (this.#toast.hidden = true), 1000 * seconds);
  }
}
