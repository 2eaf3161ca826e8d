/** The conversation with the server: what this viewer wants to see, numbered, and what the server answers. */

import { Connection } from "./connection.js";
import { parseFrame, PROTOCOL } from "./protocol.js";

/** @typedef {import("./protocol.js").Change} Change */
/** @typedef {import("./protocol.js").Frame} Frame */
/** @typedef {import("./protocol.js").SceneInfo} SceneInfo */

/**
 * @typedef {object} SessionEvents
 * @property {(state: import("./connection.js").ConnectionState) => void} connection
 * @property {(welcome: import("./protocol.js").Welcome) => void} welcome
 * @property {(scene: SceneInfo) => void} scene  before its first pose
 * @property {(status: import("./protocol.js").Status) => void} status
 * @property {(error: import("./protocol.js").ServerError) => void} error
 * @property {(frame: Frame, done: () => void) => void} frame  `done` is to be called once it is shown or thrown away
 */

export class Session {
  /** The scene that poses are meant for; null while the server reads another one. @type {SceneInfo | null} */
  scene = null;

  /** What the viewer wants. @type {Change & {size: import("./protocol.js").Size}} */
  #wanted;
  /** What was wanted before a change of scene, to go back to if that fails. @type {SceneInfo | null} */
  #previous = null;
  #poseId = 0;
  #settingsId = 0;
  /** Frames with a lower settings id are from before the newest change that the server took. */
  #expected = 0;
  /** Newest frame acknowledged on this connection. */
  #acknowledged = 0;
  /** Counts connections: frames of an earlier one are not acknowledged on this one. */
  #epoch = 0;
  /** Time of sending by pose id [ms], until a frame shows it. @type {Map<number, number>} */
  #sentAt = new Map();
  #connection;
  #events;

  /** @param {URL} url @param {import("./protocol.js").Size} size @param {SessionEvents} events */
  constructor(url, size, events) {
    this.#wanted = { size };
    this.#events = events;
    this.#connection = new Connection(url, {
      state: (state) => this.#connectionState(state),
      text: (text) => this.#message(/** @type {import("./protocol.js").ServerMessage} */ (JSON.parse(text))),
      binary: (bytes) => this.#frame(parseFrame(bytes)),
    });
  }

  connect() {
    this.#connection.connect();
  }

  /** Of the frames that are wanted. */
  get size() {
    return this.#wanted.size;
  }

  /** Id of the scene that is wanted; undefined: the one that the server serves. */
  get wantedScene() {
    return this.#wanted.scene;
  }

  /** Whether a frame is of what was last asked for. @param {Frame} frame */
  isCurrent(frame) {
    return frame.settings >= this.#expected;
  }

  /** Whether a pose sent now would be of use. */
  get takesPoses() {
    return this.scene !== null && this.#connection.open && !this.#connection.congested;
  }

  /** Asks for another scene, size or settings; what is left out stays. @param {Change} change */
  change(change) {
    Object.assign(this.#wanted, change);
    if (change.scene !== undefined) {
      this.#previous = this.scene ?? this.#previous;
      this.scene = null;
    }
    if (!this.#connection.open) return;
    this.#connection.send({ type: "settings", id: ++this.#settingsId, ...change });
    this.#expected = this.#settingsId;
  }

  /** @param {number[]} matrix column-major, camera to world @param {number} yfov vertical field of view [rad] */
  sendPose(matrix, yfov) {
    this.#sentAt.set(++this.#poseId, performance.now());
    this.#connection.send({ type: "pose", id: this.#poseId, matrix, yfov });
  }

  /** Milliseconds since the pose of this frame was sent; null if an earlier frame showed it. @param {Frame} frame */
  takeLatency(frame) {
    const sent = this.#sentAt.get(frame.pose);
    for (const id of this.#sentAt.keys()) if (id <= frame.pose) this.#sentAt.delete(id);
    return sent === undefined ? null : performance.now() - sent;
  }

  /** @param {import("./connection.js").ConnectionState} state */
  #connectionState(state) {
    this.scene = null;
    this.#sentAt.clear();
    if (state.state === "open") {
      this.#epoch += 1;
      this.#acknowledged = 0;
      this.#settingsId = 0;
      this.#expected = 0;
      this.#connection.send({ type: "hello", protocol: PROTOCOL, ...this.#wanted });
    }
    this.#events.connection(state);
  }

  /** @param {Frame} frame */
  #frame(frame) {
    const epoch = this.#epoch;
    this.#events.frame(frame, () => {
      if (epoch !== this.#epoch || frame.frame <= this.#acknowledged) return;
      this.#acknowledged = frame.frame;
      this.#connection.send({ type: "ack", frame: frame.frame });
    });
  }

  /** @param {import("./protocol.js").ServerMessage} message */
  #message(message) {
    switch (message.type) {
      case "welcome":
        this.#connection.settled();
        return this.#events.welcome(message);
      case "scene":
        this.scene = message;
        this.#wanted.scene = message.id;
        return this.#events.scene(message);
      case "status":
        return this.#events.status(message);
      case "error":
        this.#expected = 0; // what was refused changes nothing: no frame will name it
        if (message.code === "unknown-scene" || message.code === "scene-failed") this.#giveUpScene();
        return this.#events.error(message);
    }
  }

  /** A change of scene failed: the server goes on with the one before. */
  #giveUpScene() {
    if (this.scene !== null || this.#previous === null) return;
    this.scene = this.#previous;
    this.#wanted.scene = this.#previous.id;
  }
}
