/** The page's address tells what is seen, so that a link or a reload brings it back. */

import { readLink } from "./link.js";
import { optionsOf } from "./reading.js";

/** @typedef {import("./link.js").Link} Link */
/** @typedef {import("./link.js").View} View */

/** Rest of the camera before the address tells where it is [ms]: browsers allow few changes of it. */
const REST = 700;

export class Address {
  /** What the address asked for and is not yet shown. @type {Link} */
  #asked = readLink(location.hash);
  #words;
  /** What the address said when it was last read or told. */
  #known = location.hash;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {() => string | null} words of what is seen now; null while there is nothing
   * @param {() => void} follow called when the user gave the page another link
   */
  constructor(words, follow) {
    this.#words = words;
    window.addEventListener("hashchange", () => {
      this.#known = location.hash;
      this.#asked = readLink(this.#known);
      follow();
    });
  }

  /** The scene that is asked for. */
  get scene() {
    return this.#asked.scene;
  }

  /** How its file is asked to be read; null where nothing is said. */
  get reading() {
    return optionsOf(this.#asked.settings);
  }

  /** The settings that are asked for, as words: once. */
  takeSettings() {
    const { settings } = this.#asked;
    this.#asked = { ...this.#asked, settings: {} };
    return settings;
  }

  /** The view of this scene that is asked for: once. @param {string} scene id @returns {View | undefined} */
  takeView(scene) {
    const { scene: wanted, view, settings } = this.#asked;
    this.#asked = { settings };
    return wanted === undefined || wanted === scene ? view : undefined;
  }

  /** Tells what is seen, now; a link that the user has just given is kept until its event comes. */
  tell() {
    const words = this.#words();
    if (words === null || location.hash !== this.#known) return;
    history.replaceState(null, "", `#${words}`);
    this.#known = location.hash;
  }

  /** Tells it when nothing has changed for a moment. */
  tellSoon() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.tell(), REST);
  }
}
