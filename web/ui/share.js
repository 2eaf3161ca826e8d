/** Gives a view away: its link to the clipboard, its picture as a file. */

import { element } from "./page.js";

/** @returns {Promise<boolean>} whether the page's address is in the clipboard */
export async function copyAddress() {
  try {
    await navigator.clipboard.writeText(location.href);
    return true;
  } catch {
    return copySelected(location.href);
  }
}

/** The way of pages that came over http:// from another machine, which have no clipboard. @param {string} words */
function copySelected(words) {
  const focused = document.activeElement;
  const field = element("textarea", { value: words, className: "visually-hidden" });
  document.body.append(field);
  field.select();
  const copied = document.execCommand("copy");
  field.remove();
  if (focused instanceof HTMLElement) focused.focus({ preventScroll: true });
  return copied;
}

/** Offers a file for download. @param {Blob} content @param {string} name */
export function download(content, name) {
  const address = URL.createObjectURL(content);
  const link = Object.assign(document.createElement("a"), { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
