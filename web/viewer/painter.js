/** Decodes frames and draws them on a canvas, never an older one over a newer one. Runs in a worker or on the page. */

import { isVideo } from "../protocol.js";
import { VideoPictures } from "./video.js";

/** @typedef {import("../protocol.js").Codec} Codec */

/**
 * @typedef {object} Image  of a frame
 * @property {number} frame  id, increasing on one connection
 * @property {Codec} codec
 * @property {number} width  of the frame; a video's picture may be a pixel larger
 * @property {number} height
 * @property {Uint8Array<ArrayBuffer>} bytes
 */

export class Painter {
  #canvas;
  #context;
  /** Newest frame on the canvas: its id, of this connection. */
  #newest = 0;
  /** Counts connections: a frame of an earlier one has nothing to say any more. */
  #epoch = 0;
  #video = new VideoPictures();

  /** @param {HTMLCanvasElement | OffscreenCanvas} canvas */
  constructor(canvas) {
    this.#canvas = canvas;
    const context = /** @type {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D | null} */ (
      canvas.getContext("2d", { alpha: false })
    );
    if (!context) throw new Error("this browser gives no 2D canvas");
    this.#context = context;
  }

  /** Frame ids start anew: call it for each new connection. */
  restart() {
    this.#epoch += 1;
    this.#newest = 0;
    this.#video.restart();
  }

  /**
   * Decodes and draws. The canvas takes the frame's size, in the same step as its pixels; its style stretches it to the
   * window, so that frames of different sizes cover each other.
   * @param {Image} image
   * @returns {Promise<number | null>} time of decoding [ms]; null when a newer frame came first; rejects on a broken image
   */
  async show({ frame, codec, width, height, bytes }) {
    const epoch = this.#epoch;
    const start = performance.now();
    const picture = await (isVideo(codec)
      ? this.#video.decode(frame, codec === "h264_key", bytes)
      : createImageBitmap(new Blob([bytes], { type: `image/${codec}` })));
    try {
      if (epoch !== this.#epoch || frame < this.#newest) return null;
      this.#newest = frame;
      // Setting a size clears the canvas even if it is the same one.
      if (this.#canvas.width !== width) this.#canvas.width = width;
      if (this.#canvas.height !== height) this.#canvas.height = height;
      this.#context.drawImage(picture, 0, 0);
      return performance.now() - start;
    } finally {
      picture.close();
    }
  }

  /** What is on the canvas, as PNG. @returns {Promise<Blob>} */
  async picture() {
    if ("convertToBlob" in this.#canvas) return this.#canvas.convertToBlob();
    const canvas = this.#canvas;
    return new Promise((resolve, reject) => {
      canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the canvas cannot be read"))));
    });
  }
}
