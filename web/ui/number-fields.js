/** Number fields of one thing, as its place, one for each axis; arrow keys change them by a step that suits it. */

const STEPS = new Map([["ArrowUp", 1], ["ArrowDown", -1]]);

export class NumberFields {
  #inputs;
  #changed;
  /** What the fields showed last, or would show but for what is being typed. @type {readonly number[]} */
  #shown = [];
  /** What is being typed in. @type {HTMLInputElement | null} */
  #typed = null;

  /**
   * @param {readonly HTMLInputElement[]} inputs
   * @param {(values: number[]) => void} changed  by the user
   * @param {() => number} step  of an arrow key
   */
  constructor(inputs, changed, step) {
    this.#inputs = inputs;
    this.#changed = changed;
    for (const input of inputs) {
      input.addEventListener("input", () => {
        this.#typed = input;
        this.#tell();
        this.#typed = null;
      });
      input.addEventListener("change", () => input.checkValidity() || this.show(this.#shown));
      input.addEventListener("keydown", (event) => {
        const steps = STEPS.get(event.key);
        if (steps === undefined) return;
        event.preventDefault();
        const before = input.value;
        input.value = String(Number(((input.valueAsNumber || 0) + steps * step()).toPrecision(12)));
        if (input.checkValidity()) this.#tell();
        else input.value = before;
      });
    }
  }

  /** Tells nothing while one of them has what it cannot have. */
  #tell() {
    if (this.#inputs.every((input) => input.checkValidity())) this.#changed(this.#inputs.map((input) => input.valueAsNumber || 0));
  }

  /** @param {readonly number[]} values */
  show(values) {
    this.#inputs.forEach((input, index) => {
      // Who types "1." or "-", or 270° that are shown as −90°, goes on; what an arrow key or a handle has changed is shown.
      const value = values[index] ?? 0;
      const typed = document.activeElement === input && (input === this.#typed || value === this.#shown[index]);
      if (!typed) input.value = String(value);
    });
    this.#shown = values;
  }
}
