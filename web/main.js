/** Wires the page: what the user does becomes poses and settings; what the server sends becomes pictures and words. */

import { Session } from "./session.js";
import { offer } from "./ui/choice.js";
import { returnFocus } from "./ui/focus.js";
import { Notice } from "./ui/notice.js";
import { Overlay } from "./ui/overlay.js";
import { button, byId, text } from "./ui/page.js";
import { Panel } from "./ui/panel.js";
import { listenForShortcuts } from "./ui/shortcuts.js";
import { Standing } from "./ui/standing.js";
import { Camera } from "./viewer/camera.js";
import { FrameCanvas } from "./viewer/canvas.js";
import { Lens } from "./viewer/lens.js";
import { Navigation } from "./viewer/navigation.js";
import { PoseSender } from "./viewer/poses.js";

/** @typedef {import("./protocol.js").Frame} Frame */
/** @typedef {import("./protocol.js").SceneInfo} SceneInfo */

/** Rest of a resized window before frames of the new size are asked for [ms]. */
const RESIZE_REST = 150;

const canvas = byId("view", HTMLCanvasElement);
const sceneSelect = byId("scene", HTMLSelectElement);
const cameraSelect = byId("camera", HTMLSelectElement);
const modes = byId("mode", HTMLFieldSetElement);
const help = byId("help", HTMLDialogElement);

/** The scene that the camera stands in. @type {SceneInfo | null} */
let scene = null;

const view = new FrameCanvas(canvas);
const lens = new Lens(canvas);
const camera = new Camera();
const overlay = new Overlay();
const notice = new Notice(() => session.connect());
const standing = new Standing(overlay, notice);
const navigation = new Navigation(canvas, camera, wake);
const session = new Session(new URL("api/v1/stream", location.href.replace(/^http/, "ws")), lens.size, {
  connection(state) {
    if (state.state === "connecting") view.restart();
    standing.connection(state);
  },
  welcome(welcome) {
    overlay.stages = welcome.stages;
    lens.limits = welcome.limits;
    panel.describe(welcome.settings_schema);
    offer(
      sceneSelect,
      welcome.scenes.map(({ id, name, builtin }) => ({ value: id, label: name, group: builtin ? "Built in" : "Files" })),
    );
    sceneSelect.value = session.wantedScene ?? welcome.scenes.find(({ served }) => served)?.id ?? "";
    askForSize();
  },
  scene: enter,
  status: (status) => standing.status(status),
  error: refused,
  frame: show,
});
const poses = new PoseSender(session);
const panel = new Panel({
  settings(settings) {
    lens.resolution.restart();
    change({ settings });
  },
  scale(scale) {
    lens.wantedScale = scale;
    askForSizeSoon();
  },
});

// --- the picture asked for -------------------------------------------------------------------------------------------

let scheduled = false;

/** Something may have moved: look at it in the next animation frame. */
function wake() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame((now) => {
    scheduled = false;
    const moving = navigation.advance(now);
    const waiting = poses.update(camera.matrix(), lens.fov);
    if (moving || waiting) wake();
  });
}

/** @param {import("./protocol.js").Change} wanted */
function change(wanted) {
  session.change(wanted);
  standing.asked(wanted.scene !== undefined);
  document.body.toggleAttribute("data-busy", true);
}

function askForSize() {
  navigation.halfHeight = Math.tan(lens.fov / 2);
  panel.size(lens);
  if (lens.size.join() !== session.size.join()) change({ size: lens.size });
  wake();
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let resizeTimer;
function askForSizeSoon() {
  panel.size(lens);
  clearTimeout(resizeTimer);
  resizeTimer = setTimeout(askForSize, RESIZE_REST);
}

// --- what the server says --------------------------------------------------------------------------------------------

/** A scene is there: its first camera, unless the viewer stands in it already (after a reconnection). @param {SceneInfo} entered */
function enter(entered) {
  const here = scene?.id === entered.id;
  scene = entered;
  sceneSelect.value = entered.id;
  document.title = `${entered.name} – lumenwalk`;
  panel.scene(entered);
  if (!here) {
    lens.resolution.restart();
    offer(cameraSelect, entered.cameras.map(({ name }, index) => ({ value: String(index), label: name || `Camera ${index + 1}` })));
    cameraSelect.value = "0";
    stand();
  }
  poses.forget();
  wake();
}

/** Takes the chosen camera's view. */
function stand() {
  const chosen = scene?.cameras[Number(cameraSelect.value)];
  if (!scene || !chosen) return;
  lens.yfov = chosen.yfov;
  navigation.halfHeight = Math.tan(lens.fov / 2);
  navigation.start(chosen.matrix, scene.bounds);
}

/** @param {Frame} frame @param {() => void} done */
async function show(frame, done) {
  try {
    const shown = await view.show(frame);
    if (!shown) return;
    overlay.frame(frame, String(panel.value("method") ?? ""), { ...shown, latencyMs: session.takeLatency(frame) });
    document.body.toggleAttribute("data-picture", true);
    if (!session.isCurrent(frame)) return;
    document.body.toggleAttribute("data-busy", false);
    standing.picture();
    const automatic = lens.wantedScale === null;
    if (automatic && lens.resolution.observe(frame.width * frame.height, frame.renderMs, lens.most)) askForSize();
  } catch (error) {
    notice.complain(`A picture could not be shown: ${error}`);
  } finally {
    done();
  }
}

/** @param {import("./protocol.js").ServerError} error */
function refused({ code, message }) {
  document.body.toggleAttribute("data-busy", false);
  if (code === "limit" || code === "bad-message") panel.problem(message);
  if (session.scene === null || code === "render-failed") {
    standing.failed(session.scene === null ? "No scene" : "No picture", message);
    return;
  }
  notice.complain(message);
  standing.picture();
  sceneSelect.value = session.scene.id;
  // After a failed change of scene the server waits for a pose again.
  poses.forget();
  wake();
}

// --- what the user does ----------------------------------------------------------------------------------------------

/** @param {import("./viewer/navigation.js").Mode} mode */
function move(mode) {
  navigation.setMode(mode);
  for (const radio of document.querySelectorAll("input[name=mode]")) {
    if (radio instanceof HTMLInputElement) radio.checked = radio.value === mode;
  }
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

function toggleStatistics() {
  const stats = text("stats");
  stats.classList.toggle("folded");
  button("toggle-stats").setAttribute("aria-pressed", String(!stats.classList.contains("folded")));
}

const toggleFullScreen = () =>
  document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen();

navigation.onSpeed = (speed) => notice.say(`Speed × ${speed.toPrecision(2)}`);
sceneSelect.addEventListener("change", () => change({ scene: sceneSelect.value }));
cameraSelect.addEventListener("change", stand);
modes.addEventListener("change", ({ target }) => {
  if (target instanceof HTMLInputElement) move(target.value === "orbit" ? "orbit" : "fly");
});
for (const control of [sceneSelect, cameraSelect, modes]) returnFocus(control, canvas);
button("home").addEventListener("click", stand);
button("lock").addEventListener("click", lockPointer);
button("toggle-stats").addEventListener("click", toggleStatistics);
button("toggle-help").addEventListener("click", () => help.showModal());
button("toggle-full").addEventListener("click", toggleFullScreen);
document.addEventListener("fullscreenchange", () => {
  button("toggle-full").setAttribute("aria-pressed", String(document.fullscreenElement !== null));
});
listenForShortcuts({
  KeyF: () => move("fly"),
  KeyO: () => move("orbit"),
  KeyR: stand,
  KeyL: lockPointer,
  KeyI: toggleStatistics,
  KeyP: () => panel.open(!panel.isOpen),
  KeyH: () => help.showModal(),
});
new ResizeObserver(askForSizeSoon).observe(canvas);
session.connect();
