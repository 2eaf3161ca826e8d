/**
 * A WebSocket that comes back: it reconnects with growing, jittered pauses and says at all times where it stands.
 * While the page is hidden there is none, so that the server does nothing for it.
 */

import { isFinalClose } from "./protocol.js";

/**
 * @typedef {{state: "connecting"} | {state: "open"} | {state: "hidden"} | {state: "refused", reason: string}
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
const PROBE_TIMEOUT = 3000;
/** Bytes waiting in the browser above which newer messages would only queue behind older ones. */
const CONGESTED = 4096;

/** The server understood nothing of what the page says: what to do about it is said, not what it did not understand. */
const BAD_PROTOCOL = 1002;
const REASONS = new Map([
  [1001, "The server is going away."],
  [BAD_PROTOCOL, "This page and the server do not speak the same protocol version. Reload the page."],
  [1008, "The server refused the connection."],
  [1009, "The server refused a message that was too large."],
  [1011, "The server met a fault of its own."],
  [1012, "The server is restarting."],
  [1013, "The server cannot take this viewer just now."],
]);

/** Why a handshake failed, by the status of a plain request; a browser does not tell that of a WebSocket's. */
const REFUSALS = new Map([
  [401, "This server wants its token: open the link with ?token=… that it prints when it starts."],
  [403, "This server does not let this page in: it does not know the address that the page came from."],
]);

/** Seconds before the n-th attempt in a row (from 0), before jitter. @param {number} attempt */
export const pause = (attempt) => Math.min(LONGEST_PAUSE, FIRST_PAUSE * GROWTH ** attempt);

export class Connection {
  #url;
  #probe;
  #events;
  /** @type {WebSocket | null} */
  #socket = null;
  /** @type {ConnectionState["state"]} */
  #state = "hidden";
  #attempt = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {URL} url @param {URL} probe what can be read by whoever may connect
   * @param {ConnectionEvents} events
   */
  constructor(url, probe, events) {
    this.#url = url;
    this.#probe = probe;
    this.#events = events;
    // A socket of before the network was gone may be dead without knowing: its other end knows another address.
    window.addEventListener("online", () => (this.#state === "waiting" || this.open) && this.connect());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.#hide();
      else if (this.#state === "hidden" || this.#state === "waiting") this.connect();
    });
  }

  get open() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Whether the network does not keep up with what is sent. */
  get congested() {
    return (this.#socket?.bufferedAmount ?? 0) > CONGESTED;
  }

  /** Connects anew, without waiting for the pause to end; a hidden page when it is shown. */
  connect() {
    clearTimeout(this.#timer);
    if (document.hidden) return;
    this.#socket?.close();
    this.#tell({ state: "connecting" });
    const socket = new WebSocket(this.#url);
    socket.binaryType = "arraybuffer";
    let opened = false;
    socket.addEventListener("open", () => {
      if (socket !== this.#socket) return;
      opened = true;
      this.#tell({ state: "open" });
    });
    socket.addEventListener("message", ({ data }) => {
      if (socket !== this.#socket) return;
      if (typeof data === "string") this.#events.text(data);
      else this.#events.binary(data);
    });
    socket.addEventListener("close", async (event) => {
      const refusal = opened ? undefined : await this.#refusal();
      if (socket === this.#socket) this.#closed(event, refusal);
    });
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

  #hide() {
    if (this.#state === "refused") return;
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#socket = null;
    socket?.close(1000, "the page is hidden");
    this.#tell({ state: "hidden" });
  }

  /** @param {CloseEvent} event @param {string | undefined} refusal of the handshake */
  #closed(event, refusal) {
    const said = event.code === BAD_PROTOCOL ? "" : event.reason;
    const reason = refusal || said || REASONS.get(event.code) || "The connection was lost.";
    if (refusal || isFinalClose(event.code)) {
      this.#tell({ state: "refused", reason });
      return;
    }
    const seconds = pause(this.#attempt++) * (0.75 + 0.5 * Math.random());
    this.#timer = setTimeout(() => this.connect(), 1000 * seconds);
    this.#tell({ state: "waiting", reason, seconds });
  }

  /** Why the server lets nobody in from here; undefined when it is only out of reach. */
  async #refusal() {
    const answer = await fetch(this.#probe, { signal: AbortSignal.timeout(PROBE_TIMEOUT) }).catch(() => null);
    return REFUSALS.get(answer?.status ?? 0);
  }

  /** @param {ConnectionState} state */
  #tell(state) {
    this.#state = state.state;
    this.#events.state(state);
  }
}
