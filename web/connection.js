/** A WebSocket that comes back: it reconnects with growing, jittered pauses and says at all times where it stands. */

import { isFinalClose } from "./protocol.js";

/**
 * @typedef {{state: "connecting"} | {state: "open"} | {state: "refused", reason: string}
 *   | {state: "waiting", reason: string, seconds: number}} ConnectionState
 *
 * @typedef {object} ConnectionEvents
 * @property {(state: ConnectionState) => void} state
 * @property {(text: string) => void} text
 * @property {(bytes: ArrayBuffer) => void} binary
 */

const FIRST_PAUSE = 0.5;
const LONGEST_PAUSE = 10;
const GROWTH = 1.7;
/** Bytes waiting in the browser above which newer messages would only queue behind older ones. */
const CONGESTED = 4096;

const REASONS = new Map([
  [1001, "The server is going away."],
  [1002, "This page and the server do not speak the same protocol version. Reload the page."],
  [1008, "The server refused the connection."],
  [1009, "The server refused a message that was too large."],
  [1012, "The server is restarting."],
  [1013, "The server has as many viewers as it takes."],
]);

/** Seconds before the n-th attempt in a row (from 0), before jitter. @param {number} attempt */
export const pause = (attempt) => Math.min(LONGEST_PAUSE, FIRST_PAUSE * GROWTH ** attempt);

export class Connection {
  #url;
  #events;
  /** @type {WebSocket | null} */
  #socket = null;
  #attempt = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;
  #waiting = false;

  /** @param {URL} url @param {ConnectionEvents} events */
  constructor(url, events) {
    this.#url = url;
    this.#events = events;
    window.addEventListener("online", () => this.#waiting && this.connect());
    document.addEventListener("visibilitychange", () => !document.hidden && this.#waiting && this.connect());
  }

  get open() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Whether the network does not keep up with what is sent. */
  get congested() {
    return (this.#socket?.bufferedAmount ?? 0) > CONGESTED;
  }

  /** Connects now, without waiting for the pause to end. */
  connect() {
    clearTimeout(this.#timer);
    this.#waiting = false;
    this.#events.state({ state: "connecting" });
    const socket = new WebSocket(this.#url);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => this.#events.state({ state: "open" }));
    socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") this.#events.text(data);
      else this.#events.binary(data);
    });
    socket.addEventListener("close", (event) => this.#closed(event));
    this.#socket = socket;
  }

  /** The other side answers as it should: the next pause is short again. */
  settled() {
    this.#attempt = 0;
  }

  /** Sends if open; what is sent while closed is lost. @param {import("./protocol.js").ViewerMessage} message */
  send(message) {
    if (this.open) this.#socket?.send(JSON.stringify(message));
  }

  /** @param {CloseEvent} event */
  #closed(event) {
    const reason = event.reason || REASONS.get(event.code) || "The connection was lost.";
    if (isFinalClose(event.code)) {
      this.#events.state({ state: "refused", reason });
      return;
    }
    const seconds = pause(this.#attempt++) * (0.75 + 0.5 * Math.random());
    this.#waiting = true;
    this.#timer = setTimeout(() => this.connect(), 1000 * seconds);
    this.#events.state({ state: "waiting", reason, seconds });
  }
}
