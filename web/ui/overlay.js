/** The overlay: connection, the picture's size and phase, frame rate, and where the time goes. */

import { isVideo, LOSSLESS } from "../protocol.js";
import { byId, element, text } from "./page.js";
import { PARTS, Statistics } from "./statistics.js";
import { drawTimeline } from "./timeline.js";

/** @typedef {import("../protocol.js").Frame} Frame */

const REFRESH = 250;
/** Stages that never took longer are not listed [ms]. */
const NEGLIGIBLE = 0.05;
const PHASES = { moving: "moving", still: "sharpening", final: "sharp" };

export class Overlay {
  #statistics = new Statistics();
  /** Whether figures have changed since they were shown. */
  #fresh = false;
  #fps = text("fps");
  #latency = text("latency");
  #size = text("size");
  #limit = text("size-limit");
  #phase = text("phase");
  #codec = text("codec");
  #method = text("method");
  #refinement = byId("refinement", HTMLProgressElement);
  #timeline = byId("timeline", HTMLCanvasElement);
  #list = text("stages");
  #connection = text("connection");
  #connectionText = text("connection-text");
  /** @type {Map<string, HTMLElement>} */
  #parts = new Map();
  /** @type {Map<string, {row: HTMLElement, bar: HTMLElement, value: HTMLElement}>} */
  #rows = new Map();

  constructor() {
    text("parts").append(...PARTS.map((name) => this.#part(name)));
    setInterval(() => this.#refresh(), REFRESH);
  }

  /** @param {Frame} frame @param {string} method @param {import("../session.js").Seen} seen */
  frame(frame, method, seen) {
    this.#statistics.add(frame, seen, performance.now());
    this.#fresh = true;
    const { width, height, phase, samples, targetSamples, codec, quality } = frame;
    this.#size.textContent = `${width} × ${height}`;
    this.#phase.textContent = `${PHASES[phase]} ${samples}/${targetSamples}`;
    this.#phase.dataset["phase"] = phase;
    this.#refinement.value = phase === "final" ? 1 : phase === "still" ? samples / Math.max(targetSamples, 1) : 0;
    this.#codec.textContent = isVideo(codec) ? "H.264 video" : `${codec.toUpperCase()} ${quality === LOSSLESS ? "lossless" : quality}`;
    this.#method.textContent = method;
  }

  /** Says when the sharpest picture has fewer pixels than the window. @param {import("../protocol.js").Size} size @param {{width: number, height: number}} window in device pixels */
  limit([width, height], window) {
    this.#limit.hidden = width >= window.width && height >= window.height;
    this.#limit.textContent = `${width} × ${height} of ${window.width} × ${window.height} device pixels`;
  }

  /** @param {"good" | "busy" | "bad"} state @param {string} words */
  connection(state, words) {
    this.#connection.dataset["state"] = state;
    if (this.#connectionText.textContent !== words) this.#connectionText.textContent = words;
  }

  #refresh() {
    if (document.hidden) return;
    const { latency, parts, history } = this.#statistics;
    const rate = this.#statistics.rate(performance.now());
    this.#fps.textContent = rate === null ? (latency === null ? "–" : "still") : rate.toFixed(rate < 10 ? 1 : 0);
    this.#fps.dataset["still"] = String(rate === null);
    if (!this.#fresh) return;
    this.#fresh = false;
    this.#latency.textContent = latency === null ? "–" : milliseconds(latency);
    for (const [name, value] of this.#parts) value.textContent = parts ? milliseconds(parts[/** @type {keyof typeof parts} */ (name)]) : "–";
    drawTimeline(this.#timeline, history, this.#colours);
    this.#showStages([...this.#statistics.stages]);
  }

  /** Of the parts, in the light or dark of now. */
  get #colours() {
    const boxes = /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-part]"));
    return Object.fromEntries([...boxes].map((box) => [box.dataset["part"], getComputedStyle(box).borderTopColor]));
  }

  /** @param {[string, number][]} stages name and time [ms] */
  #showStages(stages) {
    const longest = Math.max(...stages.map(([, ms]) => ms), 1e-3);
    for (const [name, ms] of stages) {
      if (ms < NEGLIGIBLE && !this.#rows.has(name)) continue;
      const { bar, value } = this.#row(name);
      bar.style.setProperty("--share", String(ms / longest));
      value.textContent = milliseconds(ms);
    }
    // A stage that turns up late still takes its place in the order of time.
    const order = stages.flatMap(([name]) => this.#rows.get(name)?.row ?? []);
    const same = order.length === this.#list.children.length && order.every((row, index) => this.#list.children[index] === row);
    if (!same) this.#list.replaceChildren(...order);
  }

  /** @param {string} name */
  #part(name) {
    const value = element("dd", { textContent: "–" });
    const box = element("div", {});
    box.dataset["part"] = name;
    box.append(element("dt", { textContent: name }), value);
    this.#parts.set(name, value);
    return box;
  }

  /** @param {string} name */
  #row(name) {
    const known = this.#rows.get(name);
    if (known) return known;
    const row = element("div", { className: "stage" });
    const bar = element("span", { className: "share" });
    const value = element("span", { className: "value" });
    const track = element("span", { className: "track" });
    track.append(bar);
    row.append(element("span", { textContent: name }), track, value);
    this.#rows.set(name, { row, bar, value });
    return { row, bar, value };
  }
}

/** Three digits or so: figures that move should not also change their width. @param {number} ms */
const milliseconds = (ms) => ms.toFixed(ms < 10 ? 1 : 0);
