/** A browser's storage, of which every test has an empty one. */

import { beforeEach } from "node:test";

/** To be called once at the top of a file of tests. @returns {Map<string, string>} what is kept, by name */
export function keepAnew() {
  /** @type {Map<string, string>} */
  const kept = new Map();
  beforeEach(() => {
    kept.clear();
    Object.defineProperty(globalThis, "localStorage", {
      configurable: true,
      value: {
        getItem: (/** @type {string} */ name) => kept.get(name) ?? null,
        setItem: (/** @type {string} */ name, /** @type {string} */ value) => void kept.set(name, value),
      },
    });
  });
  return kept;
}
