/** One-key shortcuts, by key code so that a keyboard's layout does not matter. */

import { belongsToControl } from "../viewer/keys.js";

/** @param {Readonly<Record<string, () => void>>} actions by `event.code` */
export function listenForShortcuts(actions) {
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || belongsToControl(event)) return;
    const action = actions[event.code];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
