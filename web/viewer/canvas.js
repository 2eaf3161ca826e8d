/** Shows frames on a canvas: decodes each beside the page's own work, never draws an older one over a newer one. */

/** @typedef {import("../protocol.js").Frame} Frame */

export class FrameCanvas {
  #canvas;
  #context;
  /** Newest frame on the canvas: its id, of this connection. */
  #newest = 0;
  /** Counts connections: a frame of an earlier one has nothing to say any more. */
  #epoch = 0;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas;
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("this browser gives no 2D canvas");
    this.#context = context;
  }

  /** Frame ids start anew: call it for each new connection. */
  restart() {
    this.#epoch += 1;
    this.#newest = 0;
  }

  /**
   * Decodes and draws; the canvas takes the frame's size, and its style stretches it to the window.
   * @param {Frame} frame
   * @returns {Promise<{decodeMs: number} | null>} null when a newer frame came first; rejects on a broken image
   */
  async show(frame) {
    const epoch = this.#epoch;
    const start = performance.now();
    const bitmap = await createImageBitmap(new Blob([frame.image], { type: frame.codec }));
    try {
      if (epoch !== this.#epoch || frame.frame < this.#newest) return null;
      this.#newest = frame.frame;
      // Setting a size clears the canvas even if it is the same one.
      if (this.#canvas.width !== bitmap.width) this.#canvas.width = bitmap.width;
      if (this.#canvas.height !== bitmap.height) this.#canvas.height = bitmap.height;
      this.#context.drawImage(bitmap, 0, 0);
      return { decodeMs: performance.now() - start };
    } finally {
      bitmap.close();
    }
  }
}
