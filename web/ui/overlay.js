/** The overlay of figures: frame rate, latency, stage times, size, method, connection. */

import { byId, element, text } from "./page.js";
import { Statistics } from "./statistics.js";

/** @typedef {import("../protocol.js").Frame} Frame */

const REFRESH = 250;
/** Parts that never took longer are not listed [ms]. */
const NEGLIGIBLE = 0.05;

export class Overlay {
  /** Names of the frames' stages, from the server's welcome. @type {readonly string[]} */
  stages = [];

  #statistics = new Statistics();
  #fps = byId("fps", HTMLOutputElement);
  #latency = byId("latency", HTMLOutputElement);
  #size = byId("size", HTMLOutputElement);
  #method = byId("method", HTMLOutputElement);
  #list = text("stages");
  #connection = text("connection");
  #connectionText = text("connection-text");
  /** @type {Map<string, {row: HTMLElement, bar: HTMLElement, value: HTMLElement}>} */
  #rows = new Map();

  constructor() {
    setInterval(() => this.#refresh(), REFRESH);
  }

  /** @param {Frame} frame @param {string} method @param {{decodeMs: number, latencyMs: number | null}} seen */
  frame(frame, method, seen) {
    this.#statistics.add(frame, this.stages, { ...seen, now: performance.now() });
    this.#size.textContent = `${frame.width} × ${frame.height}`;
    this.#method.textContent = method;
  }

  /** @param {"good" | "busy" | "bad"} state @param {string} words */
  connection(state, words) {
    this.#connection.dataset["state"] = state;
    if (this.#connectionText.textContent !== words) this.#connectionText.textContent = words;
  }

  #refresh() {
    if (document.hidden) return;
    const rate = this.#statistics.rate(performance.now());
    const { latency, parts } = this.#statistics;
    this.#fps.textContent = rate === null ? (latency === null ? "–" : "still") : rate.toFixed(rate < 10 ? 1 : 0);
    this.#fps.dataset["still"] = String(rate === null);
    this.#latency.textContent = latency === null ? "–" : milliseconds(latency);
    const longest = Math.max(...parts.map((part) => part.ms), 1e-3);
    for (const part of parts) {
      if (part.ms < NEGLIGIBLE && !this.#rows.has(part.name)) continue;
      const { row, bar, value } = this.#row(part);
      row.dataset["share"] = part.transport ? "transport" : "render";
      bar.style.setProperty("--share", String(part.ms / longest));
      value.textContent = milliseconds(part.ms);
    }
    // A part that turns up late still takes its place in the order of time.
    const order = parts.flatMap((part) => this.#rows.get(part.name)?.row ?? []);
    if (order.some((row, index) => this.#list.children[index] !== row)) this.#list.replaceChildren(...order);
  }

  /** @param {import("./statistics.js").Part} part */
  #row({ name }) {
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
