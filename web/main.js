/** Wires the page: what the user does becomes poses and settings; what the server sends becomes pictures and words. */

import { Address } from "./address.js";
import { exportAddress, ExportError, withEdits } from "./export.js";
import { decimalsOf, toFile, toWorld } from "./frame.js";
import { writeLink } from "./link.js";
import { isVideo } from "./protocol.js";
import { wordsOf } from "./reading.js";
import { pick, PickError, wordsOf as partWords } from "./picking.js";
import { Session } from "./session.js";
import { offer } from "./ui/choice.js";
import { ConnectionStatus } from "./ui/connection-status.js";
import { showMode, wireControls } from "./ui/controls.js";
import { FilmSection } from "./ui/film.js";
import { Mixer } from "./ui/mixer.js";
import { Notice } from "./ui/notice.js";
import { Overlay } from "./ui/overlay.js";
import { byId } from "./ui/page.js";
import { Panel } from "./ui/panel.js";
import { Player } from "./ui/player.js";
import { copyAddress, download } from "./ui/share.js";
import { SceneList } from "./ui/scene-list.js";
import { Uploader } from "./ui/uploader.js";
import { Views } from "./ui/views.js";
import { Camera } from "./viewer/camera.js";
import { Flight } from "./viewer/flight.js";
import { Navigation } from "./viewer/navigation.js";
import { PoseSender } from "./viewer/poses.js";
import { Projection } from "./viewer/projection.js";
import { openScreen } from "./viewer/screen.js";
import { decodesVideo } from "./viewer/video.js";
import { Viewport } from "./viewer/viewport.js";

/** @typedef {import("./link.js").View} View */
/** @typedef {import("./protocol.js").Frame} Frame */
/** @typedef {import("./protocol.js").SceneInfo} SceneInfo */

/** Rest of a resized window before frames of the new size are asked for [ms]. */
const RESIZE_REST = 150;
/** A picture that takes longer is worth a sign [ms]. */
const LATE = 600;

const api = new URL("api/v1/", document.baseURI);
const scenes = new URL("scenes", api);
const canvas = byId("view", HTMLCanvasElement);
const cameraSelect = byId("camera", HTMLSelectElement);

/** The scene that the camera stands in. @type {SceneInfo | null} */
let scene = null;
/** Whether the server gives scenes out. */
let exports = false;
/** The newest frame on the screen. @type {Frame | null} */
let shown = null;

const screen = await openScreen(canvas);
const viewport = new Viewport(canvas);
const camera = new Camera();
const sceneList = new SceneList(scenes);
const overlay = new Overlay();
const notice = new Notice(() => session.connect());
const connectionStatus = new ConnectionStatus(overlay, notice);
const navigation = new Navigation(canvas, camera, wake);
const address = new Address(linkWords, follow);
const panel = new Panel({
  settings: (settings) => change({ settings }),
  stream: (stream) => change({ stream }),
  reading: (options) => change({ ...(scene && { scene: scene.id }), scene_options: options }),
});
const mixer = new Mixer({
  send: (id, patch) => session.edit(id, patch),
  own: (id, own, share) => session.own(id, own, share),
  camera: () => camera.matrix(),
  redraw: wake,
  say: (words) => notice.say(words),
  lost: () => notice.tell("The service has started anew: what was changed before cannot be undone"),
  save: saveScene,
});
const player = new Player((patch) => mixer.set(patch));
const wanted = {
  size: viewport.size,
  stream: panel.stream,
  scene_options: address.reading,
  ...(address.scene !== undefined && { scene: address.scene }),
};
const session = new Session(api, wanted, {
  connection(state) {
    if (state.state === "connecting") screen.restart();
    connectionStatus.connection(state);
  },
  welcome(welcome) {
    viewport.limits = welcome.limits;
    panel.describe(welcome.settings_schema);
    panel.stillFrames = welcome.still_frames;
    panel.offerVideo(welcome.codecs.includes("h264"));
    mixer.run = welcome.run;
    mixer.allowed = player.allowed = welcome.takes_edits;
    exports = welcome.gives_exports;
    sceneList.show(welcome.scenes);
    sceneList.choose(session.wanted.scene ?? welcome.scenes.find(({ served }) => served)?.id ?? "");
    // One change of both: a second one would wait for the first frame.
    const words = address.takeSettings();
    change({ size: viewport.size, ...(Object.keys(words).length > 0 && { settings: panel.take(words) }) });
    navigation.halfHeight = Math.tan(viewport.fov / 2);
    overlay.limit(viewport.size, viewport.window);
  },
  scene: enter,
  edits(edits) {
    mixer.told(edits);
    player.told(mixer.edits);
  },
  status: (status) => connectionStatus.status(status),
  error: refused,
  frame: show,
}, await decodesVideo());
const poses = new PoseSender(session);
const views = new Views({ view: here, go: visit, complain: (words) => notice.complain(words) });
const flight = new Flight({
  show(view, seconds) {
    place(view);
    film.preview(seconds);
  },
  ended() {
    film.preview(null);
    if (scene) navigation.start(scene.bounds);
  },
  wake,
});
const film = new FilmSection(api, {
  view: here,
  go: visit,
  tell: (words) => notice.tell(words),
  fly: (way) => (way ? flight.start(way) : flight.stop()),
  wanted: () => ({ ...session.wanted, edits: mixer.ownEdits }),
});
const uploader = new Uploader(scenes, openUploaded, (words) => notice.complain(words));

// --- the picture asked for -------------------------------------------------------------------------------------------

let scheduled = false;

/** Something may have moved: look at it in the next animation frame. */
function wake() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame((now) => {
    scheduled = false;
    const walks = navigation.advance(now);
    if (walks) flight.stop();
    const moving = flight.advance(now) || walks;
    const waiting = poses.update(camera.matrix(), viewport.fov, viewport.near);
    mixer.draw(projection());
    if (moving || waiting) wake();
    if (session.owesPicture) late ??= setTimeout(() => busy(true), LATE);
    address.tellSoon();
  });
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let late;

/** Shows that something asked for takes its time. @param {boolean} waits */
function busy(waits) {
  clearTimeout(late);
  late = undefined;
  document.body.toggleAttribute("data-busy", waits);
}

/** @param {import("./protocol.js").Change} wanted */
function change(wanted) {
  session.change(wanted);
  if (wanted.scene !== undefined) player.stop();
  connectionStatus.asked(wanted.scene !== undefined || wanted.scene_options !== undefined);
  busy(true);
  address.tellSoon();
}

function askForSize() {
  navigation.halfHeight = Math.tan(viewport.fov / 2);
  overlay.limit(viewport.size, viewport.window);
  if (viewport.size.join() !== session.wanted.size.join()) change({ size: viewport.size });
  wake();
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let resizeTimer;
function askForSizeSoon() {
  clearTimeout(resizeTimer);
  resizeTimer = setTimeout(askForSize, RESIZE_REST);
}

// --- what is in the picture ------------------------------------------------------------------------------------------

function projection() {
  const { width, height } = canvas.getBoundingClientRect();
  return new Projection(camera, { yfov: viewport.fov, near: viewport.near, width, height });
}

/** Counts what was asked for: of two clicks the later one counts, whichever is answered first. */
let picks = 0;

/** Chooses what is at a place of the picture, its middle unless told. @param {number} [x] [CSS px] @param {number} [y] */
async function choose(x, y) {
  if (!scene) return;
  const number = ++picks;
  const { width, height } = canvas.getBoundingClientRect();
  const [columns, rows] = viewport.size;
  const size = /** @type {[number, number]} */ ([columns, rows]);
  const pixel = /** @type {[number, number]} */ ([((x ?? width / 2) / width) * columns, ((y ?? height / 2) / height) * rows]);
  const view = { scene, edits: mixer.ownEdits, matrix: camera.matrix(), yfov: viewport.fov, near: viewport.near, size };
  try {
    const part = await pick(api, view, pixel);
    if (scene !== view.scene || number !== picks) return;
    if (mixer.allowed) mixer.pick(part);
    notice.say(partWords(part));
  } catch (error) {
    if (!(error instanceof PickError)) throw error;
    if (number === picks) notice.complain(error.message);
  }
}

// --- views and links -------------------------------------------------------------------------------------------------

/** Takes a view of the scene, or that of the chosen camera. @param {View} [view] */
function stand(view) {
  const chosen = scene?.cameras[Number(cameraSelect.value)];
  if (!scene || !chosen) return;
  flight.stop();
  if (view) {
    place(view);
  } else {
    see(chosen);
    camera.setMatrix(chosen.matrix);
  }
  navigation.start(scene.bounds);
}

/** Shows a view, on the way to others. @param {View} view */
function place(view) {
  if (!scene) return;
  see(view);
  camera.place = { at: toWorld(scene.frame, view.at), look: view.look };
}

/** @param {{yfov: number, near?: number}} lens */
function see({ yfov, near = 0 }) {
  viewport.yfov = yfov;
  viewport.near = near;
  navigation.halfHeight = Math.tan(viewport.fov / 2);
}

const home = () => stand();

/** Takes a view that was kept. @param {View} view @param {string} name */
function visit(view, name) {
  stand(view);
  notice.say(name);
}

/** @returns {View} */
function here() {
  const { at, look } = camera.place;
  const cut = viewport.near > 0 ? { near: viewport.near } : {};
  return { at: scene ? toFile(scene.frame, at) : at, look, yfov: viewport.yfov, ...cut };
}

function linkWords() {
  if (!scene) return null;
  const decimals = decimalsOf(scene.frame, navigation.size);
  return writeLink(scene.id, here(), decimals, { ...wordsOf(scene.options), ...panel.values });
}

/** The user gave the page another link. */
function follow() {
  const reading = address.reading;
  const settings = panel.take(address.takeSettings());
  const wanted = address.scene;
  const reads = scene !== null && JSON.stringify(wordsOf(reading ?? {})) === JSON.stringify(wordsOf(scene.options));
  if (wanted !== undefined && (wanted !== session.wanted.scene || !reads)) {
    change({ scene: wanted, scene_options: reading, settings });
  } else if (scene) {
    change({ settings });
    stand(address.takeView(scene.id));
  }
}

async function copyLink() {
  address.tell();
  notice.say((await copyAddress()) ? "The link is copied" : "The link is in the address bar");
}

async function savePicture() {
  if (!shown || !scene) return;
  const { width, height, phase, samples, targetSamples } = shown;
  download(await screen.picture(), `${scene.name}-${width}x${height}.png`);
  if (phase === "final") notice.say("The picture is saved");
  else if (phase === "still") notice.say(`The picture is saved as it is: ${samples} of ${targetSamples}`);
  else notice.tell(`The picture is saved as it was in motion, ${width} × ${height}; it gets sharp at rest`);
}

/** @param {string} address @param {import("./messages.js").SceneEdits} edits */
async function saveScene(address, edits) {
  const name = `${scene?.name}.glb`;
  notice.say("The file is being made");
  try {
    download(await withEdits(address, edits), name);
    notice.say("The scene is saved");
  } catch (error) {
    if (!(error instanceof ExportError)) throw error;
    notice.complain(error.message);
  }
}

// --- what the server says --------------------------------------------------------------------------------------------

/**
 * A scene is there: the view that a link asks for, else its first camera, unless the viewer stands in it already: after a
 * reconnection, or in the same file read otherwise, where it stays at the same place of the file.
 * @param {SceneInfo} entered @param {boolean} changed  its file has become another one
 */
function enter(entered, changed) {
  if (changed) notice.say("The scene's file has changed");
  const stays = scene?.id === entered.id && scene.frame.up === entered.frame.up;
  const asked = address.takeView(entered.id);
  const view = asked ?? (stays ? here() : undefined);
  const moved = JSON.stringify(scene?.frame) !== JSON.stringify(entered.frame);
  if (!stays || moved) flight.stop();
  scene = entered;
  if (!sceneList.choose(entered.id)) sceneList.load().catch(() => null); // somebody has sent it since the list came
  document.title = `${entered.name} – lumenwalk`;
  panel.scene(entered, sceneList.isBuiltin(entered.id));
  views.scene(entered.id);
  mixer.scene(entered);
  mixer.download = exports ? exportAddress(api, entered) : null;
  player.scene(entered);
  film.scene(entered);
  if (!stays) {
    offer(cameraSelect, entered.cameras.map(({ name }, index) => ({ value: String(index), label: name || `Camera ${index + 1}` })));
    cameraSelect.value = "0";
  }
  if (asked || !stays || moved) stand(view);
  poses.forget();
  wake();
}

/** @param {Frame} frame @returns {Promise<import("./session.js").Seen | import("./session.js").Broken | null>} */
async function show(frame) {
  try {
    const { frame: id, codec, width, height, image } = frame;
    const decodeMs = await screen.show({ frame: id, codec, width, height, bytes: image });
    if (decodeMs === null) return null;
    const seen = { ageMs: session.takeAge(frame), decodeMs };
    shown = frame;
    overlay.frame(frame, String(panel.value("method") ?? ""), seen);
    document.body.toggleAttribute("data-picture", true);
    if (session.isCurrent(frame)) {
      if (scene) panel.measured(frame, scene.id);
      busy(false);
      connectionStatus.picture();
      if (session.owesPicture) wake(); // the camera has gone on meanwhile
    }
    return seen;
  } catch (error) {
    if (isVideo(frame.codec)) return "broken"; // the server is told, and sends a whole one
    notice.complain(`A picture could not be shown: ${error}`);
    return null;
  }
}

/** @param {import("./protocol.js").ServerError} error */
function refused({ code, message, edit }) {
  if (code === "edit-refused") {
    mixer.refused(edit);
    return notice.complain(message);
  }
  busy(false);
  if (code === "limit" || code === "bad-message") panel.problem(message);
  if (code === "render-failed") return connectionStatus.failed("No picture", message);
  // A link to a scene that is not there leads to the one that is served.
  if (session.scene === null && code !== "unknown-scene") return connectionStatus.failed("No scene", message);
  notice.complain(code === "unknown-scene" ? `${message}; choose one in the list above, or open a file (U)` : message);
  if (session.scene === null) return;
  connectionStatus.picture();
  sceneList.choose(session.scene.id);
  wake(); // the camera may have gone on meanwhile
}

// --- what the user does ----------------------------------------------------------------------------------------------

/** @param {import("./viewer/navigation.js").Mode} mode */
function move(mode) {
  navigation.setMode(mode);
  showMode(mode);
}

async function lockPointer() {
  move("fly");
  try {
    await navigation.lockPointer();
    notice.say("The mouse steers; Escape frees it");
  } catch {
    notice.say("The browser did not give the mouse away; try again");
  }
}

/** @param {string} id */
async function openUploaded(id) {
  await sceneList.load();
  sceneList.choose(id);
  change({ scene: id });
}

/** Another tab has kept views of this scene, or removed some. */
function keptElsewhere() {
  if (!scene) return;
  views.scene(scene.id);
  film.scene(scene);
}

canvas.addEventListener("pointerdown", () => flight.stop());
canvas.addEventListener("wheel", () => flight.stop(), { passive: true });
navigation.onSpeed = (speed) => notice.say(`Speed ${Number(speed.toPrecision(2))} m/s`);
navigation.onHome = home;
navigation.onClick = choose;
navigation.onMode = () => move(navigation.mode === "fly" ? "orbit" : "fly");
wireControls({
  move,
  home,
  lock: lockPointer,
  copyLink,
  savePicture,
  openFile: () => uploader.choose(),
  settings: () => panel.sheet.toggle(),
  mixer: () => mixer.allowed && mixer.sheet.toggle(),
  choose: () => choose(),
  bookmarks: () => views.sheet.toggle(),
  bookmark: (number) => views.go(number),
  scene: (id) => change({ scene: id }),
});
window.addEventListener("storage", keptElsewhere);
viewport.observe(askForSizeSoon);
session.connect();
