/** Three number fields, one for each axis; arrow keys change them by a step that suits the scene. */

/** @typedef {[number, number, number]} Vec3 */

const STEPS = new Map([["ArrowUp", 1], ["ArrowDown", -1]]);

export class PlaceFields {
  #inputs;

  /**
   * @param {readonly HTMLInputElement[]} inputs  of X, Y and Z
   * @param {(place: Vec3) => void} changed  by the user
   * @param {() => number} step  of an arrow key [m]
   */
  constructor(inputs, changed, step) {
    this.#inputs = inputs;
    for (const input of inputs) {
      input.addEventListener("input", () => input.checkValidity() && changed(this.#place()));
      input.addEventListener("keydown", (event) => {
        const steps = STEPS.get(event.key);
        if (steps === undefined) return;
        event.preventDefault();
        input.value = String(Number(((input.valueAsNumber || 0) + steps * step()).toPrecision(12)));
        changed(this.#place());
      });
    }
  }

  /** @param {readonly number[]} place */
  show(place) {
    this.#inputs.forEach((input, axis) => {
      // Who types "1." or "-" goes on; what an arrow key or a handle has changed is shown.
      const value = place[axis] ?? 0;
      if (document.activeElement !== input || (input.value !== "" && input.valueAsNumber !== value)) input.value = String(value);
    });
  }

  /** @returns {Vec3} */
  #place() {
    const [x = 0, y = 0, z = 0] = this.#inputs.map((input) => input.valueAsNumber || 0);
    return [x, y, z];
  }
}
