/** A worker that decodes and draws on a canvas which the page has handed over. */

import { Painter } from "./painter.js";

/**
 * @typedef {{do: "restart"} | {do: "take", canvas: OffscreenCanvas} | {do: "picture", call: number}
 *   | {do: "show", call: number, image: import("./painter.js").Image}} Order
 * @typedef {{call: number, value?: unknown, error?: string}} Answer  to "picture" and "show"
 */

/** @type {Painter | null} */
let painter = null;

self.addEventListener("message", async (/** @type {MessageEvent<Order>} */ { data: order }) => {
  if (order.do === "take") painter = new Painter(order.canvas);
  if (order.do === "restart") painter?.restart();
  if (order.do !== "show" && order.do !== "picture") return;
  /** @type {Answer} */
  let answer;
  try {
    answer = { call: order.call, value: await (order.do === "show" ? painter?.show(order.image) : painter?.picture()) };
  } catch (error) {
    answer = { call: order.call, error: String(error) };
  }
  self.postMessage(answer);
});
self.postMessage("ready");
