/** Focus after a pointer's choice. */

/**
 * Hands the keyboard back to `home` when a control was changed with a pointer, so that the movement keys work at once;
 * whoever changes it by keyboard stays in it.
 * @param {HTMLElement} control @param {HTMLElement} home
 */
export function returnFocus(control, home) {
  let pointed = false;
  control.addEventListener("pointerdown", () => (pointed = true));
  control.addEventListener("keydown", () => (pointed = false));
  control.addEventListener("change", () => {
    if (pointed) home.focus({ preventScroll: true });
  });
}
