/** Changes of what a viewer wants as a latest value: one is on its way at a time, and newer ones merge meanwhile. */

/** @typedef {import("./protocol.js").Change} Change */

/** An answer that takes longer is not waited for [ms]: a slow render must not keep its own remedy from the server. */
const PATIENCE = 400;

export class Changes {
  #send;
  /** Id of the last one sent, from 1 on each connection. */
  #id = 0;
  /** Frames that name a lower id are from before the newest change that the server took. */
  #expected = 0;
  #waits = false;
  /** The last one sent. @type {Change} */
  #sent = {};
  /** What came meanwhile. @type {Change | null} */
  #next = null;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /** @param {(id: number, change: Change) => void} send */
  constructor(send) {
    this.#send = send;
  }

  /** Sends a change, or merges it with those that wait. @param {Change} change */
  ask(change) {
    this.#next = { ...this.#next, ...change };
    if (!this.#waits) this.#flush();
  }

  /** Whether something rendered with the settings of this id is what was last asked for. @param {number} id */
  isCurrent(id) {
    return this.#next === null && id >= this.#expected;
  }

  /** A frame came. @param {number} id of its settings */
  rendered(id) {
    if (id >= this.#expected) this.#answered();
  }

  /** The server refused what it was asked for, so that no frame will name it. @returns {Change} that, as far as can be told */
  refused() {
    const refused = this.#sent;
    this.#expected = 0;
    this.#answered();
    return refused;
  }

  /** A new connection, whose hello said all. */
  restart() {
    clearTimeout(this.#timer);
    this.#id = 0;
    this.#expected = 0;
    this.#waits = false;
    this.#sent = {};
    this.#next = null;
  }

  #answered() {
    clearTimeout(this.#timer);
    this.#waits = false;
    if (this.#next) this.#flush();
  }

  #flush() {
    const change = this.#next;
    if (!change) return;
    this.#next = null;
    this.#waits = true;
    this.#expected = ++this.#id;
    this.#sent = change;
    this.#send(this.#id, change);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#answered(), PATIENCE);
  }
}
