/** The time line of a scene that has animations: plays, pauses, seeks. Its time is an edit, for all who look at the scene. */

import { Playback } from "../playback.js";
import { offer } from "./choice.js";
import { icon } from "./icon.js";
import { button, byId, text } from "./page.js";

/** @typedef {import("../messages.js").SceneEdits} SceneEdits */
/** @typedef {import("../messages.js").ScenePatch} ScenePatch */
/** @typedef {import("../protocol.js").SceneInfo} SceneInfo */

/** Between two times that are asked for [ms]. */
const REST = 40;

export class Player {
  /** Whether the server takes edits. */
  allowed = true;
  #playback = new Playback();
  #edit;
  /** The scene's id. */
  #scene = "";
  /** @type {SceneInfo["animations"]} */
  #animations = [];
  #asked = 0;
  /** Of the next step. */
  #step = 0;
  #bar = text("player");
  #play = button("player-play");
  #animation = byId("player-animation", HTMLSelectElement);
  #time = byId("player-time", HTMLInputElement);
  #now = text("player-now");
  #speed = byId("player-speed", HTMLSelectElement);
  #loop = button("player-loop");

  /** @param {(patch: ScenePatch) => void} edit */
  constructor(edit) {
    this.#edit = edit;
    this.#play.addEventListener("click", () => this.#toggle());
    this.#animation.addEventListener("change", () => this.#choose());
    this.#time.addEventListener("input", () => {
      this.#playback.pause();
      this.#seek(this.#time.valueAsNumber);
    });
    this.#speed.addEventListener("change", () => (this.#playback.speed = Number(this.#speed.value)));
    this.#loop.addEventListener("click", () => {
      this.#playback.loops = !this.#playback.loops;
      this.#loop.ariaPressed = String(this.#playback.loops);
    });
  }

  /** Stops where it is, without a word to the server: the scene is left, or another one is there. */
  stop() {
    cancelAnimationFrame(this.#step);
    this.#playback.pause();
    this.#show();
  }

  /** A scene is there; the same on another connection goes on, as when a page was hidden. @param {SceneInfo} scene */
  scene(scene) {
    const stays = scene.id === this.#scene && JSON.stringify(scene.animations) === JSON.stringify(this.#animations);
    this.#scene = scene.id;
    this.#bar.hidden = !this.allowed || scene.animations.length === 0;
    if (stays) return;
    this.stop();
    this.#animations = scene.animations;
    this.#playback.time = 0;
    offer(this.#animation, scene.animations.map(({ id }) => ({ value: id, label: id })));
    this.#animation.selectedIndex = 0;
    this.#animation.hidden = scene.animations.length < 2;
    this.#show();
  }

  /** The server says what differs: somebody may have chosen another time. @param {SceneEdits} edits */
  told({ time, animation }) {
    if (this.#playback.playing) return;
    if (animation !== null) this.#animation.value = animation;
    this.#playback.time = time ?? 0;
    this.#show();
  }

  #toggle() {
    if (this.#playback.playing) {
      this.stop();
      this.#seek(this.#playback.time);
      return;
    }
    this.#playback.play();
    this.#step = requestAnimationFrame((now) => this.#run(now));
  }

  /** @param {number} now */
  #run(now) {
    this.#playback.advance(now);
    if (now - this.#asked >= REST || !this.#playback.playing) {
      this.#asked = now;
      this.#seek(this.#playback.time);
    }
    if (this.#playback.playing) this.#step = requestAnimationFrame((next) => this.#run(next));
  }

  #choose() {
    this.#show();
    this.#seek(0);
  }

  /** @param {number} time [s] */
  #seek(time) {
    this.#playback.time = time;
    this.#edit({ time: Number(time.toFixed(3)), animation: this.#animation.value });
    this.#show();
  }

  #show() {
    const { playing, time } = this.#playback;
    const chosen = this.#animations.find(({ id }) => id === this.#animation.value);
    this.#playback.seconds = chosen?.seconds ?? 0;
    this.#time.max = String(this.#playback.seconds);
    this.#time.valueAsNumber = time;
    this.#time.ariaValueText = this.#now.textContent = `${time.toFixed(1)} of ${this.#playback.seconds.toFixed(1)} s`;
    const words = playing ? "Pause" : "Play";
    if (this.#play.ariaLabel === words) return;
    this.#play.ariaLabel = this.#play.title = words;
    this.#play.replaceChildren(icon(playing ? "icon-pause" : "icon-play"));
  }
}
