/** The picture: a painter in a worker of its own where the browser has that, else one on the page. */

import { Painter } from "./painter.js";

/** @typedef {import("./painter.js").Image} Image */
/** @typedef {Pick<Painter, "restart" | "show" | "picture">} Screen */

/** @param {HTMLCanvasElement} canvas @returns {Promise<Screen>} */
export async function openScreen(canvas) {
  const worker = "transferControlToOffscreen" in canvas ? await startWorker() : null;
  return worker ? new WorkerScreen(worker, canvas) : new Painter(canvas);
}

/** @returns {Promise<Worker | null>} null where workers cannot be modules */
function startWorker() {
  const worker = new Worker(new URL("paint-worker.js", import.meta.url), { type: "module" });
  return new Promise((resolve) => {
    worker.addEventListener("message", () => resolve(worker), { once: true });
    worker.addEventListener("error", () => resolve(null), { once: true });
  });
}

/** Passes a painter's work on to the worker. */
class WorkerScreen {
  #worker;
  #call = 0;
  /** @type {Map<number, {resolve: (value: any) => void, reject: (error: Error) => void}>} */
  #waiting = new Map();

  /** @param {Worker} worker @param {HTMLCanvasElement} canvas is the worker's from now on */
  constructor(worker, canvas) {
    this.#worker = worker;
    const offscreen = canvas.transferControlToOffscreen();
    this.#order({ do: "take", canvas: offscreen }, [offscreen]);
    worker.addEventListener("message", ({ data }) => {
      const { call, value, error } = /** @type {import("./paint-worker.js").Answer} */ (data);
      const waiting = this.#waiting.get(call);
      this.#waiting.delete(call);
      if (error === undefined) waiting?.resolve(value);
      else waiting?.reject(new Error(error));
    });
  }

  restart() {
    this.#order({ do: "restart" });
  }

  /** @param {Image} image its bytes are gone afterwards @returns {Promise<number | null>} */
  show(image) {
    return this.#ask((call) => this.#order({ do: "show", call, image }, [image.bytes.buffer]));
  }

  /** @returns {Promise<Blob>} */
  picture() {
    return this.#ask((call) => this.#order({ do: "picture", call }));
  }

  /** @param {(call: number) => void} order @returns {Promise<any>} */
  #ask(order) {
    const call = ++this.#call;
    return new Promise((resolve, reject) => {
      this.#waiting.set(call, { resolve, reject });
      order(call);
    });
  }

  /** @param {import("./paint-worker.js").Order} order @param {Transferable[]} [transfer] */
  #order(order, transfer = []) {
    this.#worker.postMessage(order, transfer);
  }
}
