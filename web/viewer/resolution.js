/** How many pixels a frame may have so that walking feels smooth, judged by how long frames take to render. */

/** Where to start: any device renders this many in bearable time. */
const MODEST_PIXELS = 512 * 288;
/** Fewer would not be worth looking at, and gain little: part of a frame's time does not depend on its pixels. */
const FEWEST_PIXELS = MODEST_PIXELS / 2;
/** More pixels than modest only within this time a frame [ms]; fewer only where a frame takes longer than that. */
const SMOOTH = 40;
const BEARABLE = 200;
/** Change only for a gain or relief of this much: a new size costs the server new buffers. */
const GROW = 1.5;
const SHRINK = 0.6;
/** To have all pixels of use, a smaller gain will do. */
const ALL = 1.05;
/** A first frame may pay for what is made once: shrink only when this many agree. */
const FRAMES_TO_SHRINK = 4;

export class Resolution {
  pixels = MODEST_PIXELS;
  /** Quickest frame since the last change [ms]. */
  #quickest = Infinity;
  #frames = 0;

  /** Other settings take other times: what was measured does not count any more. */
  restart() {
    this.#quickest = Infinity;
    this.#frames = 0;
  }

  /**
   * @param {number} pixels of the frame @param {number} renderMs
   * @param {number} most pixels of use: the window's, or the server's limit
   * @returns {boolean} whether `pixels` changed
   */
  observe(pixels, renderMs, most) {
    this.#frames += 1;
    this.#quickest = Math.min(this.#quickest, Math.max(renderMs, 0.1));
    const target = Math.min(most, affordable(pixels, this.#quickest));
    const grows = target > GROW * pixels || (target === most && target > ALL * pixels);
    const shrinks = target < SHRINK * pixels && this.#frames >= FRAMES_TO_SHRINK;
    if (!grows && !shrinks) return false;
    this.pixels = target;
    this.restart();
    return true;
  }
}

/** @param {number} pixels rendered @param {number} ms in this time */
function affordable(pixels, ms) {
  const smooth = (pixels * SMOOTH) / ms;
  if (smooth >= MODEST_PIXELS) return smooth;
  return Math.max(FEWEST_PIXELS, Math.min(MODEST_PIXELS, (pixels * BEARABLE) / ms));
}
