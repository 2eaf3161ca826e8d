/** Where the page stands with the server, in words: for the overlay's light and the notice. */

/** @typedef {import("../connection.js").ConnectionState} ConnectionState */
/** @typedef {import("../protocol.js").Status} Status */

export class ConnectionStatus {
  #overlay;
  #notice;
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #countdown;
  /** Whether there is a picture of the scene, which needs no notice any more. */
  #pictured = false;
  /** Whether what was asked for last has not come yet; else what the server does is no matter for a notice. */
  #waits = true;
  /** Whether something failed, which stays said until the user chooses otherwise or a picture comes all the same. */
  #failed = false;

  /** @param {import("./overlay.js").Overlay} overlay @param {import("./notice.js").Notice} notice */
  constructor(overlay, notice) {
    this.#overlay = overlay;
    this.#notice = notice;
  }

  /** @param {ConnectionState} state */
  connection(state) {
    clearInterval(this.#countdown);
    this.#pictured = false;
    this.#waits = true;
    this.#failed = false;
    switch (state.state) {
      case "connecting":
        this.#overlay.connection("busy", "Connecting");
        return this.#notice.show({ title: "Connecting", fraction: null });
      case "open":
        this.#overlay.connection("good", "Connected");
        return this.#notice.show({ title: "Connected", detail: "Waiting for the scene", fraction: null });
      case "hidden":
        return this.#overlay.connection("busy", "Paused");
      case "refused":
        this.#overlay.connection("bad", "Refused");
        return this.#notice.show({ title: "Not connected", detail: state.reason, retry: true });
      case "waiting":
        return this.#count(state.reason, state.seconds);
    }
  }

  /** @param {Status} status */
  status({ state, text, fraction }) {
    const known = fraction > 0 ? fraction : null;
    switch (state) {
      case "loading":
        if (!this.#waits) return;
        this.#overlay.connection("busy", "Loading");
        return this.#notice.show({ title: this.#pictured ? "Working" : "Loading", detail: text || "the scene", fraction: known });
      case "recovering":
        this.#overlay.connection("busy", "Recovering");
        return this.#notice.show({ title: "The renderer starts again", detail: text, fraction: known });
      case "stopping":
        this.#overlay.connection("bad", "Stopping");
        return this.#notice.show({ title: "The server is stopping", detail: text || "The page comes back when it does." });
      case "ready":
        if (this.#failed) return;
        this.#overlay.connection("good", "Connected");
        if (this.#pictured) this.#notice.hide();
        else this.#notice.show({ title: "Rendering the first picture", fraction: null });
    }
  }

  /** Something else was asked for. @param {boolean} scene another scene: there is no picture of it yet */
  asked(scene) {
    this.#failed = false;
    this.#waits = true;
    if (scene) this.#pictured = false;
  }

  /** A picture of what was asked for is there. */
  picture() {
    this.#pictured = true;
    this.#waits = false;
    this.#failed = false;
    this.#overlay.connection("good", "Connected");
    this.#notice.hide();
  }

  /** What was asked for will not come. @param {string} title @param {string} detail */
  failed(title, detail) {
    this.#failed = true;
    this.#overlay.connection("bad", title);
    this.#notice.show({ title, detail });
  }

  /** @param {string} reason @param {number} seconds */
  #count(reason, seconds) {
    const end = performance.now() + 1000 * seconds;
    const tell = () => {
      const left = Math.max(1, Math.ceil((end - performance.now()) / 1000));
      this.#overlay.connection("bad", "Reconnecting");
      this.#notice.show({ title: "Reconnecting", detail: `${reason} Trying again in ${left} s`, retry: true });
    };
    tell();
    this.#countdown = setInterval(tell, 1000);
  }
}
