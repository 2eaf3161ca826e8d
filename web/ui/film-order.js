/**
 * The part of the film's section that has it rendered: size and quality, progress, the file. The browser remembers what
 * was ordered, so that a page that is loaded again goes on telling of it.
 */

import { cancelFilm, FilmError, findFilm, orderFilm, resultOf, watchFilm } from "../film-job.js";
import { load, save } from "../storage.js";
import { button, byId, text } from "./page.js";

/** @typedef {import("../film-job.js").JobInfo} JobInfo */
/** @typedef {{name: string, wanted: Readonly<Record<string, unknown>>, settings: Readonly<Record<string, unknown>>}} Order  name: of the file */

/** What the browser remembers: {url, name, told: that it is ready}, or null. */
const ORDERED = "film ordered";

export class FilmOrder {
  #api;
  #order;
  #tell;
  #section = byId("film", HTMLDetailsElement);
  #form = byId("film-render", HTMLFormElement);
  #size = byId("film-size", HTMLSelectElement);
  #fps = byId("film-fps", HTMLSelectElement);
  #codec = byId("film-codec", HTMLSelectElement);
  #frames = byId("film-frames", HTMLInputElement);
  #problem = text("film-problem");
  #box = text("film-job");
  #state = text("film-state");
  #progress = byId("film-progress", HTMLProgressElement);
  #cancel = button("film-cancel");
  #result = byId("film-result", HTMLAnchorElement);
  #submit = button("film-start");
  #enough = false;
  /** From the order to its end. */
  #busy = false;
  /** What goes on; told: that it is ready. @type {{job: JobInfo, name: string, told: boolean, ignore: () => void} | null} */
  #current = null;

  /**
   * @param {URL} api @param {() => Order | null} order  what of the scene is to be rendered now, if there is a film
   * @param {(words: string) => void} tell  says what the section cannot while it is closed
   */
  constructor(api, order, tell) {
    this.#api = api;
    this.#tell = tell;
    this.#order = order;
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#start();
    });
    this.#cancel.addEventListener("click", () => this.#stop());
    this.#resume();
  }

  /** Whether there are views enough for a film. @param {boolean} enough */
  set enough(enough) {
    this.#enough = enough;
    this.#offer();
  }

  /** Says that something is wrong; nothing when all is well. @param {string} words */
  problem(words) {
    this.#problem.hidden = words === "";
    this.#problem.textContent = words;
  }

  async #start() {
    const order = this.#order();
    if (!order || this.#busy) return;
    this.problem("");
    const wanted = {
      ...order.wanted,
      size: this.#size.value.split("x").map(Number),
      film: { fps: Number(this.#fps.value), codec: this.#codec.value },
      settings: { ...order.settings, frames: this.#frames.valueAsNumber },
    };
    this.#work(true);
    try {
      this.#watch(await orderFilm(this.#api, wanted), order.name, false);
    } catch (error) {
      this.#forget(error instanceof FilmError ? error.message : String(error));
    }
  }

  /** Goes on with what was ordered before the page was loaded. */
  async #resume() {
    const { url, name, told } = /** @type {{url?: unknown, name?: unknown, told?: unknown}} */ (load(ORDERED) ?? {});
    if (typeof url !== "string" || typeof name !== "string") return;
    const job = await findFilm(this.#api, url).catch(() => undefined);
    if (this.#busy || job === undefined) return; // it may say more when the page is loaded again
    if (!job) return void save(ORDERED, null);
    this.#section.open = told !== true; // where its sheet is opened
    this.#work(true);
    this.#watch(job, name, told === true);
    if (this.#current) this.#tellClosed("Your film is being rendered");
  }

  /** @param {string} words what anyone is told who does not see the section */
  #tellClosed(words) {
    if (!this.#box.checkVisibility()) this.#tell(`${words}; see Bookmarks (B)`);
  }

  /** @param {JobInfo} job @param {string} name @param {boolean} told  that it is ready */
  #watch(job, name, told) {
    save(ORDERED, { url: job.url, name, told });
    const lost = (/** @type {string} */ words) => this.#end(words);
    this.#current = { job, name, told, ignore: watchFilm(job, (now) => this.#told(now), lost) };
    this.#box.hidden = this.#progress.hidden = this.#cancel.hidden = false;
    this.#result.hidden = true;
    this.#told(job);
  }

  /** @param {JobInfo} job */
  #told(job) {
    const { state, progress, pictures, error } = job;
    if (!this.#current) return;
    this.#progress.value = progress;
    const picture = Math.min(Math.floor(progress * pictures) + 1, pictures);
    this.#state.textContent = state === "queued" ? "Waits for its turn" : `Picture ${picture} of ${pictures}`;
    if (state === "failed") {
      this.#tellClosed("Your film could not be rendered");
      return this.#forget(error);
    }
    if (state === "cancelled") return this.#forget("");
    if (state !== "done") return;
    const { name, told } = this.#current;
    Object.assign(this.#result, { href: resultOf(job), download: `${name}.mp4`, hidden: false });
    this.#current = null;
    this.#state.textContent = "The film is ready";
    this.#progress.hidden = this.#cancel.hidden = true;
    if (!told) this.#tellClosed("The film is ready");
    save(ORDERED, { url: job.url, name, told: true });
    this.#work(false);
  }

  #stop() {
    if (!this.#current) return;
    this.#current.ignore();
    cancelFilm(this.#current.job);
    this.#forget("");
    this.#submit.focus();
  }

  /** There is no film. @param {string} words why */
  #forget(words) {
    save(ORDERED, null);
    this.#end(words);
  }

  /** Nothing more is told; a page that is loaded again asks for it. @param {string} words why */
  #end(words) {
    this.#current = null;
    this.#box.hidden = true;
    this.#work(false);
    this.problem(words);
  }

  /** @param {boolean} goesOn */
  #work(goesOn) {
    this.#busy = goesOn;
    this.#offer();
  }

  #offer() {
    this.#submit.disabled = this.#busy || !this.#enough;
  }
}
