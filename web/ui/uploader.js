/** Opens scenes: by the button or dropped on the page, with progress and what went wrong in words. */

import { archiveName, MOST_FILES, partsOf, walk } from "../dropped.js";
import { upload, UploadError } from "../upload.js";
import { pack } from "../zip.js";
import { button, byId, text } from "./page.js";

/** @typedef {import("../zip.js").Part} Part */

/** What scenes have beside them. */
const BESIDE = [".bin", ".mtl", ".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga", ".ktx2"];

export class Uploader {
  #scenes;
  #opened;
  #complain;
  #box = text("upload");
  #words = text("upload-text");
  #progress = byId("upload-progress", HTMLProgressElement);
  #input = byId("file", HTMLInputElement);
  #drop = text("drop");
  /** Of scenes. */
  #suffixes = this.#input.accept.split(",");
  /** Of the upload that goes on. @type {AbortController | null} */
  #current = null;

  /**
   * @param {URL} scenes where the server takes scenes
   * @param {(id: string) => Promise<void>} opened a new scene is there
   * @param {(words: string) => void} complain
   */
  constructor(scenes, opened, complain) {
    this.#scenes = scenes;
    this.#opened = opened;
    this.#complain = complain;
    this.#input.accept = [...this.#suffixes, ...BESIDE].join();
    button("upload-cancel").addEventListener("click", () => this.#current?.abort());
    this.#input.addEventListener("change", () => {
      this.#send(partsOf([...(this.#input.files ?? [])]));
      this.#input.value = ""; // the same file can be chosen again
    });
    this.#takeDrops();
  }

  /** Lets the user choose a file. */
  choose() {
    this.#input.click();
  }

  #takeDrops() {
    const carriesFiles = (/** @type {DragEvent} */ { dataTransfer }) => dataTransfer?.types.includes("Files") ?? false;
    window.addEventListener("dragover", (event) => {
      if (!carriesFiles(event)) return;
      event.preventDefault();
      this.#drop.hidden = false;
    });
    window.addEventListener("dragleave", ({ relatedTarget }) => {
      if (relatedTarget === null) this.#drop.hidden = true; // it has left the window
    });
    window.addEventListener("drop", (event) => {
      if (!carriesFiles(event)) return;
      event.preventDefault();
      this.#drop.hidden = true;
      const { items, files } = /** @type {DataTransfer} */ (event.dataTransfer);
      const entries = [...items].map((item) => item.webkitGetAsEntry()); // now: later there are none
      const folder = entries.some((entry) => entry?.isDirectory);
      this.#send(folder ? walk(entries.filter((entry) => entry !== null)) : partsOf([...files]));
    });
  }

  /** Sends a file, or several, or those of a folder, as an archive. @param {readonly Part[] | Promise<Part[]>} coming */
  async #send(coming) {
    if (this.#current) return this.#complain("Another file is being sent; wait for it or cancel it.");
    const { signal } = (this.#current = new AbortController());
    try {
      const parts = await coming;
      if (parts.length === 0) return;
      const file = parts.length === 1 ? /** @type {Part} */ (parts[0]).file : await this.#packed(parts);
      signal.throwIfAborted();
      this.#show(file.name, 0);
      const id = await upload(this.#scenes, file, (fraction) => this.#show(file.name, fraction), signal);
      await this.#opened(id);
    } catch (error) {
      if (error instanceof UploadError) this.#complain(error.message);
      else if (!(error instanceof DOMException)) throw error;
      else if (error.name !== "AbortError") this.#complain(`The files cannot be read: ${error.message}`);
    } finally {
      this.#current = null;
      this.#box.hidden = true;
    }
  }

  /** @param {readonly Part[]} parts */
  async #packed(parts) {
    if (parts.length > MOST_FILES) throw new UploadError(`More than ${MOST_FILES} files; choose those of one scene.`);
    this.#words.textContent = `Packing ${parts.length} files`;
    this.#progress.removeAttribute("value");
    this.#box.hidden = false;
    const archive = await pack(parts);
    if (archive === null) throw new UploadError("The files are too large for one archive.");
    return new File([archive], archiveName(parts, this.#suffixes));
  }

  /** @param {string} name @param {number} fraction */
  #show(name, fraction) {
    this.#words.textContent = fraction < 1 ? `Sending ${name}` : `The server reads ${name}`;
    if (fraction < 1) this.#progress.value = fraction;
    else this.#progress.removeAttribute("value");
    this.#box.hidden = false;
  }
}
