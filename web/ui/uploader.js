/** Opens scene files: by the button or dropped on the page, with progress and what went wrong in words. */

import { upload, UploadError } from "../upload.js";
import { button, byId, text } from "./page.js";

export class Uploader {
  #scenes;
  #opened;
  #complain;
  #box = text("upload");
  #words = text("upload-text");
  #progress = byId("upload-progress", HTMLProgressElement);
  #input = byId("file", HTMLInputElement);
  #drop = text("drop");
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
    button("upload-cancel").addEventListener("click", () => this.#current?.abort());
    this.#input.addEventListener("change", () => {
      this.#send([...(this.#input.files ?? [])]);
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
      const folder = [...(event.dataTransfer?.items ?? [])].some((item) => item.webkitGetAsEntry()?.isDirectory);
      this.#send([...(event.dataTransfer?.files ?? [])], folder);
    });
  }

  /** @param {readonly File[]} files @param {boolean} [folder]  one of them is none, but a folder, which cannot be read */
  async #send(files, folder = false) {
    const [file] = files;
    if (!file) return;
    if (this.#current) return this.#complain("Another file is being sent; wait for it or cancel it.");
    if (files.length > 1 || folder) return this.#complain("One file at a time, please: put a scene of several files into a ZIP archive.");
    this.#current = new AbortController();
    this.#show(file.name, 0);
    try {
      const id = await upload(this.#scenes, file, (fraction) => this.#show(file.name, fraction), this.#current.signal);
      await this.#opened(id);
    } catch (error) {
      if (error instanceof UploadError) this.#complain(error.message);
      else if (!(error instanceof DOMException && error.name === "AbortError")) throw error;
    } finally {
      this.#current = null;
      this.#box.hidden = true;
    }
  }

  /** @param {string} name @param {number} fraction */
  #show(name, fraction) {
    this.#words.textContent = fraction < 1 ? `Sending ${name}` : `The server reads ${name}`;
    if (fraction < 1) this.#progress.value = fraction;
    else this.#progress.removeAttribute("value");
    this.#box.hidden = false;
  }
}
