/** The sheet of bookmarks, with what shares a view: its link and its picture. */

import { addBookmark, bookmarksOf, removeBookmark } from "../bookmarks.js";
import { icon } from "./icon.js";
import { button, byId, element, text } from "./page.js";
import { Sheet } from "./sheet.js";

/** @typedef {import("../link.js").View} View */

/**
 * @typedef {object} ViewsEvents
 * @property {() => View} view  of now
 * @property {(view: View, name: string) => void} go
 * @property {(words: string) => void} complain
 */

export class Views {
  sheet = new Sheet("views");
  #list = text("bookmarks");
  #none = text("no-bookmarks");
  #name = byId("bookmark-name", HTMLInputElement);
  #scene = "";
  #events;

  /** @param {ViewsEvents} events */
  constructor(events) {
    this.#events = events;
    byId("bookmark", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      if (!addBookmark(this.#scene, this.#name.value, events.view())) events.complain("The browser keeps no more bookmarks.");
      this.#name.value = "";
      this.#show();
    });
  }

  /** Shows the bookmarks of this scene. @param {string} id */
  scene(id) {
    this.#scene = id;
    this.#show();
  }

  /** Goes to a bookmark, if there is one of this number. @param {number} number from 1 */
  go(number) {
    const chosen = bookmarksOf(this.#scene)[number - 1];
    if (chosen) this.#events.go(chosen.view, chosen.name);
  }

  #show() {
    const bookmarks = bookmarksOf(this.#scene);
    this.#none.hidden = bookmarks.length > 0;
    this.#list.hidden = bookmarks.length === 0;
    this.#list.replaceChildren(
      ...bookmarks.map(({ name }, index) => {
        const row = element("li", {});
        const go = element("button", { type: "button", className: "go", textContent: name });
        const number = element("kbd", { textContent: index < 9 ? String(index + 1) : "" });
        number.ariaHidden = "true";
        go.prepend(number);
        go.addEventListener("click", () => this.go(index + 1));
        const remove = element("button", { type: "button", className: "icon", ariaLabel: `Remove ${name}` });
        remove.append(icon("icon-remove"));
        remove.addEventListener("click", () => {
          removeBookmark(this.#scene, index);
          this.#show();
          button("close-views").focus();
        });
        row.append(go, remove);
        return row;
      }),
    );
  }
}
