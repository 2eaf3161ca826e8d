/** Light or dark: the system's choice, or the user's, which the browser keeps. Runs before the page is first drawn. */

import { keep, kept } from "../kept.js";

const CHOICES = ["system", "light", "dark"];

/** The choice in force: "system", "light" or "dark". */
export function theme() {
  const choice = String(kept("theme"));
  return CHOICES.includes(choice) ? choice : "system";
}

/** @param {string} choice */
export function chooseTheme(choice) {
  keep("theme", choice);
  document.documentElement.dataset["theme"] = choice;
}

document.documentElement.dataset["theme"] = theme();
