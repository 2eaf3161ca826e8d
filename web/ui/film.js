/** The section of the film: views in order, how long the way to each takes, a preview, paths as files. */

import { bookmarksOf } from "../bookmarks.js";
import { filmOf, keepFilm, PathError, pathOf, SECONDS, stopsOf, timesOf, wayOf } from "../film.js";
import { FilmOrder } from "./film-order.js";
import { icon } from "./icon.js";
import { button, byId, element, text } from "./page.js";
import { download } from "./share.js";

/** @typedef {import("../film.js").Stop} Stop */
/** @typedef {import("../link.js").View} View */
/** @typedef {import("../protocol.js").SceneInfo} SceneInfo */

/**
 * @typedef {object} FilmEvents
 * @property {() => View} view  of now
 * @property {(view: View, name: string) => void} go
 * @property {(way: import("../viewer/camera-path.js").CameraPath | null) => void} fly  along it, or no more
 * @property {(words: string) => void} tell  of one that is rendered, while its section is closed
 * @property {() => {scene_options?: unknown, edits?: unknown, settings?: Readonly<Record<string, unknown>>}} wanted  of the session
 */

export class FilmSection {
  /** @type {SceneInfo | null} */
  #scene = null;
  /** @type {Stop[]} */
  #stops = [];
  #events;
  #order;
  #list = text("film-stops");
  #hint = text("film-hint");
  #play = button("film-play");
  #time = text("film-time");
  #file = byId("film-file", HTMLInputElement);
  #flies = false;

  /** @param {URL} api @param {FilmEvents} events */
  constructor(api, events) {
    this.#events = events;
    this.#order = new FilmOrder(api, () => this.#wanted(), events.tell);
    button("film-add").addEventListener("click", () => this.#add([{ name: `View ${this.#stops.length + 1}`, view: events.view() }]));
    button("film-add-bookmarks").addEventListener("click", () => this.#add(bookmarksOf(this.#scene?.id ?? "")));
    this.#play.addEventListener("click", () => events.fly(this.#flies ? null : wayOf(this.#stops)));
    button("film-save").addEventListener("click", () => this.#save());
    button("film-open").addEventListener("click", () => this.#file.click());
    this.#file.addEventListener("change", async () => {
      const [file] = this.#file.files ?? [];
      this.#file.value = ""; // the same file can be chosen again
      if (file) this.#open(await file.text());
    });
  }

  /** Shows the film of this scene. @param {SceneInfo} scene */
  scene(scene) {
    this.#scene = scene;
    this.#stops = filmOf(scene.id);
    this.#show();
  }

  /** Shows how far the preview is [s]; null: there is none. @param {number | null} seconds */
  preview(seconds) {
    this.#flies = seconds !== null;
    this.#play.textContent = this.#flies ? "Stop" : "Preview";
    const whole = timesOf(this.#stops).at(-1) ?? 0;
    this.#time.textContent = seconds === null ? `${whole} s` : `${seconds.toFixed(1)} of ${whole} s`;
  }

  /** @param {readonly {name: string, view: View}[]} views */
  #add(views) {
    this.#change([...this.#stops, ...views.map((it) => ({ ...it, seconds: SECONDS.usual }))]);
  }

  /** @param {Stop[]} stops */
  #change(stops) {
    if (this.#keep(stops)) this.#show();
  }

  /** @param {Stop[]} stops @returns {boolean} whether these are the film now */
  #keep(stops) {
    if (!this.#scene) return false;
    this.#events.fly(null);
    const kept = keepFilm(this.#scene.id, stops);
    if (kept) this.#stops = stops;
    this.#order.problem(kept ? "" : "The browser keeps no more views of this film.");
    return kept;
  }

  #show() {
    const enough = this.#stops.length > 1;
    this.#hint.hidden = enough;
    this.#list.hidden = this.#stops.length === 0;
    this.#play.disabled = button("film-save").disabled = !enough;
    this.#order.enough = enough;
    this.#list.replaceChildren(...this.#stops.map((stop, index) => this.#row(stop, index)));
    this.preview(null);
  }

  /** @param {Stop} stop @param {number} index */
  #row({ name, view, seconds }, index) {
    const row = element("li", {});
    const go = element("button", { type: "button", className: "go", textContent: name });
    go.addEventListener("click", () => this.#events.go(view, name));
    const words = { ariaLabel: `Seconds from the view before to ${name}`, title: "Seconds from the view before" };
    const { least, most } = SECONDS;
    const time = element("input", { type: "number", min: String(least), max: String(most), step: "any", value: String(seconds), ...words });
    time.addEventListener("change", () => {
      const valid = time.checkValidity() && time.value !== "";
      if (valid) this.#keep(this.#stops.with(index, { name, view, seconds: time.valueAsNumber }));
      time.value = String(this.#stops[index]?.seconds); // the row stays: the keyboard is in it
      this.preview(null);
    });
    const earlier = element("button", { type: "button", className: "icon", ariaLabel: `Move ${name} before the view before`, title: "Earlier" });
    earlier.append(icon("icon-earlier"));
    earlier.addEventListener("click", () => {
      this.#change(this.#stops.toSpliced(index - 1, 2, ...this.#stops.slice(index - 1, index + 1).reverse()));
      this.#focus(index - 1);
    });
    const remove = element("button", { type: "button", className: "icon", ariaLabel: `Remove ${name} from the film`, title: "Remove" });
    remove.append(icon("icon-remove"));
    remove.addEventListener("click", () => {
      this.#change(this.#stops.toSpliced(index, 1));
      this.#focus(Math.min(index, this.#stops.length - 1));
    });
    row.append(go, ...(index > 0 ? [time, earlier] : []), remove);
    return row;
  }

  /** The keyboard goes on at this row, or where views are added. @param {number} index */
  #focus(index) {
    const go = this.#list.children[index]?.querySelector("button");
    (go ?? button("film-add")).focus();
  }

  #save() {
    if (!this.#scene) return;
    const content = JSON.stringify(pathOf(this.#stops, this.#scene), null, 1);
    download(new Blob([content], { type: "application/json" }), `${this.#scene.name}-path.json`);
  }

  /** @param {string} content of a file */
  #open(content) {
    if (!this.#scene) return;
    try {
      this.#change(stopsOf(content, this.#scene));
    } catch (error) {
      this.#order.problem(error instanceof PathError ? error.message : String(error));
    }
  }

  #wanted() {
    if (!this.#scene || this.#stops.length < 2) return null;
    const { scene_options, edits, settings = {} } = this.#events.wanted();
    const wanted = { scene: this.#scene.id, scene_options, edits, path: pathOf(this.#stops, this.#scene) };
    return { name: this.#scene.name, wanted, settings };
  }
}
