/** The latency of the last frames as columns, the newest at the right, each stacked of its parts. */

import { PARTS } from "./statistics.js";

/** @typedef {import("./statistics.js").Parts} Parts */

/** Pixels of a column and of the gap after it. */
const COLUMN = 3;
const GAP = 1;
/** The least that the whole height stands for [ms], so that good times look good. */
const LEAST = 40;

/** @param {Parts} parts */
const sum = (parts) => PARTS.reduce((total, name) => total + parts[name], 0);

/**
 * @param {HTMLCanvasElement} canvas
 * @param {readonly Parts[]} history the oldest first
 * @param {Readonly<Record<string, string>>} colours by part
 */
export function drawTimeline(canvas, history, colours) {
  const context = canvas.getContext("2d");
  if (!context) return;
  const ratio = Math.max(1, devicePixelRatio);
  const { clientWidth: width, clientHeight: height } = canvas;
  canvas.width = Math.round(width * ratio); // clears, too
  canvas.height = Math.round(height * ratio);
  context.scale(ratio, ratio);
  const most = Math.max(LEAST, ...history.map(sum));
  history.toReversed().forEach((parts, age) => {
    const x = width - (age + 1) * (COLUMN + GAP) + GAP;
    let y = height;
    for (const name of PARTS) {
      const share = (parts[name] / most) * height;
      context.fillStyle = colours[name] ?? "";
      context.fillRect(x, y - share, COLUMN, share);
      y -= share;
    }
  });
}
