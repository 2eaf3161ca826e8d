/**
 * Version 2 of the walkthrough's wire protocol: JSON messages both ways, binary frames from the server.
 * `server/wire/browser.py` says what each message means and who sends what when, `server/wire/frame_header.py` how a
 * frame is laid out; a test holds this file against them.
 */

export const PROTOCOL = 2;
const HEADER_VERSION = 3;
/** Of the header's fixed part; the stages' times follow. */
const FIXED_BYTES = 38;
/** By number in the header; "jpeg" and "png" are for browsers `image/NAME`. */
const CODECS = new Map(/** @type {[number, Codec][]} */ ([[1, "jpeg"], [2, "png"], [3, "h264_key"], [4, "h264"]]));
const PHASES = new Map(/** @type {[number, Phase][]} */ ([[0, "moving"], [1, "still"], [2, "final"]]));

/** That every browser decodes. */
export const IMAGE_CODECS = ["jpeg", "png"];
/** Quality of an image without loss. */
export const LOSSLESS = 100;

/** @typedef {"jpeg" | "png" | "h264_key" | "h264"} Codec */
/** @typedef {"moving" | "still" | "final"} Phase  on the move; at rest and getting sharper; as sharp as it gets */
/** @typedef {[number, number]} Size  width and height [px] */

/** @typedef {import("./messages.js").CameraInfo} CameraInfo */
/** @typedef {import("./messages.js").Edits} Edits */
/** @typedef {import("./messages.js").ImportOptions} ImportOptions */
/** @typedef {import("./messages.js").Limits} Limits */
/** @typedef {import("./messages.js").SceneFrame} SceneFrame */
/** @typedef {import("./messages.js").SceneInfo} SceneInfo */
/** @typedef {import("./messages.js").SceneName} SceneName */
/** @typedef {import("./messages.js").ScenePatch} ScenePatch */
/** @typedef {import("./messages.js").ServerError} ServerError */
/** @typedef {import("./messages.js").ServerMessage} ServerMessage */
/** @typedef {import("./messages.js").Status} Status */
/** @typedef {import("./messages.js").Stream} Stream */
/** @typedef {import("./messages.js").ViewerMessage} ViewerMessage */
/** @typedef {import("./messages.js").Welcome} Welcome */

/** @typedef {{size?: Size, scene?: string, scene_options?: ImportOptions | null, settings?: import("./messages.js").RenderSettings, stream?: Stream}} Change */
/** @typedef {Change & {size: Size}} Wanted */

/**
 * @typedef {object} Frame
 * @property {Codec} codec
 * @property {Phase} phase
 * @property {number} quality  1 to 100 = lossless
 * @property {number} samples  frames averaged in the image
 * @property {number} targetSamples  that the final image will average
 * @property {number} width
 * @property {number} height
 * @property {number} pose  id
 * @property {number} frame  id
 * @property {number} settings  id
 * @property {number} queueMs
 * @property {number} renderMs
 * @property {number} encodeMs
 * @property {Readonly<Record<string, number>>} stagesMs  by name, in the order they ran
 * @property {Uint8Array<ArrayBuffer>} image
 */

/**
 * A binary message as a frame; throws when it is not one of this version.
 * @param {ArrayBuffer} message
 * @returns {Frame}
 */
export function parseFrame(message) {
  const view = new DataView(message);
  if (message.byteLength < FIXED_BYTES || view.getUint8(0) !== HEADER_VERSION) {
    throw new Error(`not a frame of protocol ${PROTOCOL}: ${message.byteLength} bytes`);
  }
  const codec = CODECS.get(view.getUint8(1));
  if (!codec) throw new Error(`a frame has an unknown codec: ${view.getUint8(1)}`);
  const phase = PHASES.get(view.getUint8(32));
  if (!phase) throw new Error(`a frame has an unknown phase: ${view.getUint8(32)}`);
  const start = view.getUint16(2, true);
  return {
    codec,
    phase,
    quality: view.getUint8(33),
    samples: view.getUint16(34, true),
    targetSamples: view.getUint16(36, true),
    width: view.getUint16(4, true),
    height: view.getUint16(6, true),
    pose: view.getUint32(8, true),
    frame: view.getUint32(12, true),
    settings: view.getUint32(16, true),
    queueMs: view.getFloat32(20, true),
    renderMs: view.getFloat32(24, true),
    encodeMs: view.getFloat32(28, true),
    stagesMs: JSON.parse(new TextDecoder().decode(new Uint8Array(message, FIXED_BYTES, start - FIXED_BYTES))),
    image: new Uint8Array(message, start),
  };
}

/** Whether pictures of a codec follow on one another. @param {Codec} codec */
export const isVideo = (codec) => codec === "h264_key" || codec === "h264";

/** Whether trying again is pointless after a close with this code: our own fault, or refused by policy. @param {number} code */
export const isFinalClose = (code) => code === 1002 || code === 1008 || code === 1009;
