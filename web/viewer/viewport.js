/** Which picture to ask for: how many pixels, and how wide a view. */

/** @typedef {import("../protocol.js").Size} Size */

/**
 * The size of a frame for a window, in its proportions: each of its pixels, as far as the server makes so many. A picture
 * of just that size is shown pixel by pixel; any other is stretched by the browser.
 * @param {{width: number, height: number}} window in device pixels
 * @param {{max_pixels: number, max_side: number}} limits
 * @returns {Size}
 */
export function frameSize(window, limits) {
  const width = Math.max(window.width, 1);
  const height = Math.max(window.height, 1);
  const fit = Math.min(1, Math.sqrt(limits.max_pixels / (width * height)), limits.max_side / Math.max(width, height));
  // Rounding down keeps within the limits.
  return [Math.max(1, Math.floor(width * fit)), Math.max(1, Math.floor(height * fit))];
}

/** 0 keeps the vertical field of view of an upright picture, 1 keeps the horizontal one that a square would have. */
const UPRIGHT = 0.75;
/** The widest that the server renders [rad]. */
const WIDEST = 3.09;

/**
 * The vertical field of view for a picture's proportions: a camera's own for wide ones, more for upright ones, so that
 * a phone sees more than a slit.
 * @param {number} yfov the camera's [rad] @param {number} aspect width / height of the picture
 */
export function fitFov(yfov, aspect) {
  const half = Math.tan(yfov / 2) / Math.min(aspect, 1) ** UPRIGHT;
  return Math.min(2 * Math.atan(half), WIDEST);
}

/** What the picture on a canvas should be. */
export class Viewport {
  /** Vertical field of view of the chosen camera [rad]. */
  yfov = Math.PI / 3;
  /** What is less far in front of the chosen camera is cut away, until another is chosen [m]. */
  near = 0;
  /** What the server takes; next to nothing until it has said so. */
  limits = { max_pixels: 64 * 36, max_side: 4096 };
  #canvas;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas;
  }

  /** Calls `changed` when the canvas gets other device pixels: by its size, by zoom, on another screen. @param {() => void} changed */
  observe(changed) {
    new ResizeObserver(changed).observe(this.#canvas);
    watchRatio(changed);
  }

  /** The canvas in device pixels. */
  get window() {
    const { width, height } = this.#canvas.getBoundingClientRect(); // unlike clientWidth, not whole CSS pixels only
    return { width: Math.round(width * devicePixelRatio), height: Math.round(height * devicePixelRatio) };
  }

  /** Of the frames to ask for. */
  get size() {
    return frameSize(this.window, this.limits);
  }

  /** Vertical field of view to ask for [rad]. */
  get fov() {
    const { width, height } = this.window;
    return fitFov(this.yfov, Math.max(width, 1) / Math.max(height, 1));
  }
}

/** Calls `changed` whenever a CSS pixel becomes another number of device pixels. @param {() => void} changed */
function watchRatio(changed) {
  const query = matchMedia(`(resolution: ${devicePixelRatio}dppx)`);
  const again = () => {
    changed();
    watchRatio(changed);
  };
  query.addEventListener("change", again, { once: true });
}
