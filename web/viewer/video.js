/** Decodes the pictures of a stream's H.264, by WebCodecs, which browsers have on pages of secure origins. */

/** Annex B, Constrained Baseline up to 4K. @type {VideoDecoderConfig} */
const CONFIG = { codec: "avc1.42E034", optimizeForLatency: true };

/** Whether this browser decodes it here. @returns {Promise<boolean>} */
export async function decodesVideo() {
  if (!("VideoDecoder" in globalThis)) return false;
  try {
    return (await VideoDecoder.isConfigSupported(CONFIG)).supported === true;
  } catch {
    return false;
  }
}

export class VideoPictures {
  /** @type {VideoDecoder | null} */
  #decoder = null;
  /** By frame id. @type {Map<number, {resolve: (picture: VideoFrame) => void, reject: (error: Error) => void}>} */
  #waiting = new Map();

  /**
   * The picture of a frame; each must come here once, in turn. Rejects on broken bytes, and then on all that come before
   * the next key frame.
   * @param {number} frame id @param {boolean} isKey needs no picture before it @param {Uint8Array<ArrayBuffer>} bytes
   * @returns {Promise<VideoFrame>} to be closed by whoever gets it
   */
  decode(frame, isKey, bytes) {
    if (!this.#decoder && !isKey) return Promise.reject(new Error("a picture before it is missing"));
    const decoder = (this.#decoder ??= this.#open());
    return new Promise((resolve, reject) => {
      this.#waiting.set(frame, { resolve, reject });
      decoder.decode(new EncodedVideoChunk({ type: isKey ? "key" : "delta", timestamp: frame, data: bytes }));
    });
  }

  /** Another stream begins: what is being decoded rejects. */
  restart() {
    if (this.#decoder?.state === "configured") this.#decoder.close();
    this.#fail(new Error("the stream has ended"));
  }

  #open() {
    const decoder = new VideoDecoder({
      output: (picture) => {
        const waiting = this.#waiting.get(picture.timestamp);
        this.#waiting.delete(picture.timestamp);
        if (waiting) waiting.resolve(picture);
        else picture.close();
      },
      error: (error) => this.#fail(error),
    });
    decoder.configure(CONFIG);
    return decoder;
  }

  /** @param {Error} error */
  #fail(error) {
    this.#decoder = null;
    for (const { reject } of this.#waiting.values()) reject(error);
    this.#waiting.clear();
  }
}
