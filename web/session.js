/** The conversation with the server: what this viewer wants to see, numbered, and what the server answers. */

import { Changes } from "./changes.js";
import { Connection } from "./connection.js";
import { IMAGE_CODECS, parseFrame, PROTOCOL } from "./protocol.js";

/** @typedef {import("./protocol.js").Change} Change */
/** @typedef {import("./protocol.js").Frame} Frame */
/** @typedef {import("./protocol.js").SceneInfo} SceneInfo */
/** @typedef {{ageMs: number | null, decodeMs: number}} Seen  ageMs: from sending the pose; null if that was seen before */
/** @typedef {"broken"} Broken  a picture of a video that could not be decoded */

/**
 * @typedef {object} SessionEvents
 * @property {(state: import("./connection.js").ConnectionState) => void} connection
 * @property {(welcome: import("./protocol.js").Welcome) => void} welcome
 * @property {(scene: SceneInfo, changed: boolean) => void} scene  before its first pose; changed: nobody asked for it, its
 *   file has become another one
 * @property {(edits: import("./protocol.js").Edits) => void} edits  all that differs of the scene
 * @property {(status: import("./protocol.js").Status) => void} status
 * @property {(error: import("./protocol.js").ServerError) => void} error
 * @property {(frame: Frame) => Promise<Seen | Broken | null>} frame  resolves once it is shown, or to null if it is thrown away
 */

export class Session {
  /** The scene that poses are meant for; null while the server reads another one. @type {SceneInfo | null} */
  scene = null;

  /** @type {import("./protocol.js").Wanted} */
  #wanted;
  /** What every server takes, whatever the one before took: the page says its size when it is welcome. */
  #firstSize;
  /** What was wanted and came: the next hello must hold nothing that was refused. @type {import("./protocol.js").Wanted} */
  #granted;
  /** What was wanted before a change of scene, to go back to if that fails. @type {SceneInfo | null} */
  #previous = null;
  /** Edits of that scene which were made since, for when it fails. @type {import("./messages.js").ViewerMessage[]} */
  #held = [];
  #poseId = 0;
  /** Newest frame acknowledged on this connection. */
  #acknowledged = 0;
  /** Counts connections: frames of an earlier one are not acknowledged on this one. */
  #epoch = 0;
  /** Time of sending by pose id [ms], until a frame shows it. @type {Map<number, number>} */
  #sentAt = new Map();
  #changes;
  #connection;
  #events;
  #codecs;

  /**
   * @param {URL} api folder of the server's interface @param {import("./protocol.js").Wanted} wanted
   * @param {SessionEvents} events @param {boolean} video whether this browser decodes it
   */
  constructor(api, wanted, events, video) {
    this.#codecs = video ? [...IMAGE_CODECS, "h264"] : IMAGE_CODECS;
    this.#wanted = wanted;
    this.#firstSize = wanted.size;
    this.#granted = { ...wanted };
    this.#events = events;
    this.#changes = new Changes((id, change) => this.#connection.send({ type: "settings", id, ...change }));
    const stream = new URL("stream", api.href.replace(/^http/, "ws"));
    this.#connection = new Connection(stream, new URL("scenes", api), {
      state: (state) => this.#connectionState(state),
      text: (text) => this.#message(/** @type {import("./protocol.js").ServerMessage} */ (JSON.parse(text))),
      binary: (bytes) => this.#frame(parseFrame(bytes)),
    });
  }

  connect() {
    this.#connection.connect();
  }

  /** What the viewer wants; the scene is undefined if it wants the one that the server serves. */
  get wanted() {
    return this.#wanted;
  }

  /** Whether a frame is of what was last asked for, and others follow it. @param {Frame} frame */
  isCurrent(frame) {
    return this.#connection.open && this.#changes.isCurrent(frame.settings);
  }

  /** Whether a pose sent now would be of use. */
  get takesPoses() {
    return this.scene !== null && this.#connection.open && !this.#connection.congested;
  }

  /** Whether a pose was sent that no frame has shown yet. */
  get owesPicture() {
    return this.#sentAt.size > 0;
  }

  /** Asks for another scene, way to read it, size, settings or stream; what is left out stays. @param {Change} wanted */
  change(wanted) {
    // Another scene is read as the server does, unless it is said.
    const change = wanted.scene === undefined ? wanted : { scene_options: null, ...wanted };
    Object.assign(this.#wanted, change);
    if (change.scene !== undefined) {
      this.#previous = this.scene ?? this.#previous;
      this.scene = null;
    }
    if (this.#connection.open) this.#changes.ask(change);
  }

  /**
   * @param {number[]} matrix column-major, camera to world
   * @param {number} yfov vertical field of view [rad]
   * @param {number} near what is less far in front of the camera is cut away [m]
   */
  sendPose(matrix, yfov, near) {
    this.#sentAt.set(++this.#poseId, performance.now());
    this.#connection.send({ type: "pose", id: this.#poseId, matrix, yfov, near });
  }

  /** Changes the scene, for all who look at it or for this viewer; while another one is read, if that fails. @param {number} id @param {import("./protocol.js").ScenePatch} patch */
  edit(id, patch) {
    this.#change({ type: "edit", id, patch });
  }

  /** Has edits be this viewer's own, or those of all. @param {number} id @param {boolean} own @param {boolean} share  those of all become what its own were */
  own(id, own, share) {
    this.#change({ type: "own", id, own, share });
  }

  /** @param {import("./messages.js").Edit | import("./messages.js").Own} message */
  #change(message) {
    if (this.scene === null) this.#held.push(message);
    else this.#connection.send(message);
  }

  /** Milliseconds since the pose of this frame was sent; null if an earlier frame showed it. @param {Frame} frame */
  takeAge(frame) {
    const sent = this.#sentAt.get(frame.pose);
    for (const id of this.#sentAt.keys()) if (id <= frame.pose) this.#sentAt.delete(id);
    return sent === undefined ? null : performance.now() - sent;
  }

  /** @param {import("./connection.js").ConnectionState} state */
  #connectionState(state) {
    this.scene = this.#previous = null;
    this.#held = [];
    this.#sentAt.clear();
    if (state.state === "open") {
      this.#epoch += 1;
      this.#acknowledged = 0;
      this.#changes.restart();
      this.#connection.send({ type: "hello", protocol: PROTOCOL, codecs: this.#codecs, ...this.#wanted, size: this.#firstSize });
    }
    this.#events.connection(state);
  }

  /** @param {Frame} frame */
  async #frame(frame) {
    const epoch = this.#epoch;
    this.#changes.rendered(frame.settings);
    if (this.isCurrent(frame)) this.#granted = { ...this.#wanted };
    const seen = await this.#events.frame(frame);
    if (epoch !== this.#epoch || frame.frame <= this.#acknowledged) return;
    this.#acknowledged = frame.frame;
    this.#connection.send({ type: "ack", frame: frame.frame, ...(seen && figures(seen)) });
  }

  /** @param {import("./protocol.js").ServerMessage} message */
  #message(message) {
    switch (message.type) {
      case "welcome":
        this.#connection.settled();
        return this.#events.welcome(message);
      case "scene": {
        const changed = this.scene !== null && this.scene !== this.#previous;
        this.scene = message;
        this.#previous = null;
        this.#held = [];
        this.#wanted.scene = message.id;
        this.#wanted.scene_options = message.options;
        return this.#events.scene(message, changed);
      }
      case "edits":
        return this.#events.edits(message);
      case "status":
        return this.#events.status(message);
      case "error":
        if (message.code === "edit-refused") return this.#events.error(message);
        this.#refused(message.code, this.#changes.refused());
        return this.#events.error(message);
    }
  }

  /** @param {import("./protocol.js").ServerError["code"]} code @param {Change} change  of which nothing was taken, if the code says so */
  #refused(code, change) {
    const whole = code === "limit" || code === "bad-message";
    if (whole) this.#wanted = { ...this.#granted };
    if (code === "unknown-scene" || code === "scene-failed" || (whole && change.scene !== undefined)) this.#giveUpScene();
  }

  /** A change of scene failed: the server goes on with the one before. */
  #giveUpScene() {
    if (this.scene !== null || this.#previous === null) return;
    this.scene = this.#previous;
    this.#wanted.scene = this.#previous.id;
    this.#wanted.scene_options = this.#previous.options;
    for (const message of this.#held.splice(0)) this.#connection.send(message);
  }
}

/** @param {Seen | Broken} seen @returns {Partial<import("./messages.js").Ack>} */
const figures = (seen) => {
  if (seen === "broken") return { broken: true };
  const { ageMs, decodeMs } = seen;
  return ageMs === null ? { decode_ms: decodeMs } : { age_ms: ageMs, decode_ms: decodeMs };
};
