import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { Session } from "../../../web/session.js";

/** What sockets of the page say. @type {any[]} */
let said = [];
/** The newest socket. @type {any} */
let socket = null;

class Socket extends EventTarget {
  static OPEN = 1;
  readyState = 1;
  bufferedAmount = 0;

  constructor() {
    super();
    socket = this;
  }

  /** @param {string} text */
  send(text) {
    said.push(JSON.parse(text));
  }

  close() {}
}

/** @param {unknown} message of the server */
const hears = (message) => socket.dispatchEvent(Object.assign(new Event("message"), { data: JSON.stringify(message) }));

/** @type {Session} */
let session;
/** Whether the file of each scene that came had changed. @type {boolean[]} */
let entered = [];

beforeEach(() => {
  Object.assign(globalThis, { WebSocket: Socket, window: new EventTarget(), document: Object.assign(new EventTarget(), { hidden: false }) });
  entered = [];
  const scene = (/** @type {unknown} */ _, /** @type {boolean} */ changed) => entered.push(changed);
  const events = new Proxy({ scene }, { get: (known, name) => (name === "scene" ? known.scene : () => {}) });
  session = new Session(new URL("http://localhost/api/v1/"), /** @type {any} */ ({ size: [64, 36], stream: {} }), /** @type {any} */ (events), false);
  session.connect();
  socket.dispatchEvent(new Event("open"));
  hears({ type: "scene", id: "hall", options: {} });
  said = [];
});

const edit = { type: "edit", id: 1, patch: { lights: { lamp: { on: false } } } };

test("edits that are made while another scene is read are sent if that is not there", () => {
  session.change({ scene: "gone" });
  session.edit(edit.id, edit.patch);
  session.own(2, true, false);
  assert.deepEqual(said.map(({ type }) => type), ["settings"]);
  hears({ type: "error", code: "unknown-scene", message: "there is no such scene" });
  assert.deepEqual(said.slice(1), [edit, { type: "own", id: 2, own: true, share: false }]);
});

test("edits that are made while another scene is read are not of that", () => {
  session.change({ scene: "house" });
  session.edit(edit.id, edit.patch);
  hears({ type: "scene", id: "house", options: {} });
  session.change({ scene: "gone" });
  hears({ type: "error", code: "unknown-scene", message: "there is no such scene" });
  assert.deepEqual(said.map(({ type }) => type), ["settings", "settings"]);
});

test("a scene that nobody asked for is one whose file has changed", () => {
  hears({ type: "scene", id: "hall", options: {} });
  session.change({ scene: "broken" });
  hears({ type: "error", code: "scene-failed", message: "it is cut off" });
  hears({ type: "scene", id: "hall", options: {} });
  session.change({ scene: "house" });
  hears({ type: "scene", id: "house", options: {} });
  hears({ type: "scene", id: "house", options: {} });
  assert.deepEqual(entered, [false, true, false, false, true]);
});
