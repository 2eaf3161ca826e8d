/** Light or dark: the system's choice, or the user's, which the browser keeps. Runs before the page is first drawn. */

import { load, save } from "../storage.js";

const CHOICES = ["system", "light", "dark"];

/** The choice in force: "system", "light" or "dark". */
export function theme() {
  const choice = String(load("theme"));
  return CHOICES.includes(choice) ? choice : "system";
}

/** @param {string} choice */
export function chooseTheme(choice) {
  save("theme", choice);
  document.documentElement.dataset["theme"] = choice;
}

document.documentElement.dataset["theme"] = theme();
