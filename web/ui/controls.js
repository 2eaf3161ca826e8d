/** The page's buttons and one-key shortcuts, by what they do. */

import { returnFocus } from "./focus.js";
import { button, byId, text } from "./page.js";
import { listenForShortcuts } from "./shortcuts.js";

/** @typedef {import("../viewer/navigation.js").Mode} Mode */

/**
 * @typedef {object} Actions
 * @property {(mode: Mode) => void} move
 * @property {() => void} home  back to the start of the view
 * @property {() => void} lock  the mouse steers
 * @property {() => void} copyLink
 * @property {() => void} savePicture
 * @property {() => void} openFile
 * @property {() => void} settings  opens and closes
 * @property {() => void} mixer  opens and closes
 * @property {() => void} choose  what is in the middle of the picture
 * @property {() => void} bookmarks  opens and closes
 * @property {(number: number) => void} bookmark  goes to it; from 1
 * @property {(id: string) => void} scene
 */

/** Too narrow for statistics beside the picture. */
const NARROW = "(max-width: 720px)";

const modes = byId("mode", HTMLFieldSetElement);

/** Shows which way to move is chosen. @param {Mode} mode */
export function showMode(mode) {
  for (const radio of modes.querySelectorAll("input")) radio.checked = radio.value === mode;
}

/** @param {Actions} actions */
export function wireControls(actions) {
  const canvas = text("view");
  const scene = byId("scene", HTMLSelectElement);
  const camera = byId("camera", HTMLSelectElement);
  const help = byId("help", HTMLDialogElement);

  scene.addEventListener("change", () => actions.scene(scene.value));
  camera.addEventListener("change", actions.home);
  modes.addEventListener("change", ({ target }) => {
    if (target instanceof HTMLInputElement) actions.move(target.value === "orbit" ? "orbit" : "fly");
  });
  for (const control of [scene, camera, modes]) returnFocus(control, canvas);
  button("home").addEventListener("click", actions.home);
  button("lock").addEventListener("click", actions.lock);
  button("open-file").addEventListener("click", actions.openFile);
  button("copy-link").addEventListener("click", actions.copyLink);
  button("save-picture").addEventListener("click", actions.savePicture);
  button("toggle-help").addEventListener("click", () => help.showModal());
  button("toggle-stats").addEventListener("click", toggleStatistics);
  button("toggle-full").addEventListener("click", toggleFullScreen);
  button("toggle-full").hidden = !document.fullscreenEnabled;
  text("no-gamepads").hidden = "getGamepads" in navigator;
  document.addEventListener("fullscreenchange", () => {
    button("toggle-full").setAttribute("aria-pressed", String(document.fullscreenElement !== null));
  });
  showStatistics(!matchMedia(NARROW).matches);

  const bookmarks = Array.from({ length: 9 }, (_, index) => [`Digit${index + 1}`, () => actions.bookmark(index + 1)]);
  listenForShortcuts({
    KeyF: () => actions.move("fly"),
    KeyO: () => actions.move("orbit"),
    KeyR: actions.home,
    KeyL: actions.lock,
    KeyI: toggleStatistics,
    KeyM: toggleFullScreen,
    KeyP: actions.settings,
    KeyG: actions.mixer,
    KeyV: actions.choose,
    KeyB: actions.bookmarks,
    KeyC: actions.copyLink,
    KeyX: actions.savePicture,
    KeyU: actions.openFile,
    KeyH: () => help.showModal(),
    ...Object.fromEntries(bookmarks),
  });
}

/** @param {boolean} open */
function showStatistics(open) {
  text("details").hidden = !open;
  button("toggle-stats").setAttribute("aria-pressed", String(open));
}

function toggleStatistics() {
  showStatistics(text("details").hidden !== false);
}

function toggleFullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else if (document.fullscreenEnabled) document.documentElement.requestFullscreen();
}
