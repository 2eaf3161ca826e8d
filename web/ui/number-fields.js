/** Number fields of one thing, as its place, one for each axis; arrow keys change them by a step that suits it. */

const STEPS = new Map([["ArrowUp", 1], ["ArrowDown", -1]]);

export class NumberFields {
  #inputs;

  /**
   * @param {readonly HTMLInputElement[]} inputs
   * @param {(values: number[]) => void} changed  by the user
   * @param {() => number} step  of an arrow key
   */
  constructor(inputs, changed, step) {
    this.#inputs = inputs;
    const values = () => inputs.map((input) => input.valueAsNumber || 0);
    for (const input of inputs) {
      input.addEventListener("input", () => input.checkValidity() && changed(values()));
      input.addEventListener("keydown", (event) => {
        const steps = STEPS.get(event.key);
        if (steps === undefined) return;
        event.preventDefault();
        input.value = String(Number(((input.valueAsNumber || 0) + steps * step()).toPrecision(12)));
        if (input.checkValidity()) changed(values());
      });
    }
  }

  /** @param {readonly number[]} values */
  show(values) {
    this.#inputs.forEach((input, index) => {
      // Who types "1." or "-" goes on; what an arrow key or a handle has changed is shown.
      const value = values[index] ?? 0;
      if (document.activeElement !== input || (input.value !== "" && input.valueAsNumber !== value)) input.value = String(value);
    });
  }
}
