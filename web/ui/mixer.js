/**
 * The sheet of the scene's objects, materials and lights: fields of what is chosen here or picked in the picture, a row
 * for each light. What can be moved, turned or made larger has handles over the picture.
 */

import { movedTo, sizedTo, targetOf, turnedFrom } from "../chosen.js";
import { toHex } from "../colors.js";
import { EditHistory } from "../edits.js";
import { stepIn } from "../moving.js";
import { load, save } from "../storage.js";
import { atOneTime } from "../sun.js";
import { offer } from "./choice.js";
import { Gizmo } from "./gizmo.js";
import { LightRow } from "./light-row.js";
import { Marks } from "./marks.js";
import { MaterialFields } from "./material-fields.js";
import { ObjectFields } from "./object-fields.js";
import { button, byId, text } from "./page.js";
import { Sheet } from "./sheet.js";

/** @typedef {import("../messages.js").PickedPart} PickedPart */
/** @typedef {import("../messages.js").ScenePatch} ScenePatch */
/** @typedef {import("../protocol.js").SceneInfo} SceneInfo */
/** @typedef {import("../chosen.js").Chosen} Chosen  what handles move, and whose row is marked */

/**
 * @typedef {object} MixerEvents
 * @property {(id: number, patch: ScenePatch) => void} send
 * @property {(id: number, own: boolean, share: boolean) => void} own  edits are this viewer's own, or those of all
 * @property {() => number[]} camera  its place, column-major, camera to world
 * @property {() => void} redraw  asks for `draw`
 * @property {(words: string) => void} say
 * @property {() => void} lost  what was done here went with the service
 * @property {(address: string, edits: import("../messages.js").SceneEdits) => void} save  the scene with its own edits
 */

/** What the browser remembers of a tab that is left with own edits: {of, edits}. */
const KEPT = "own edits";
/** A scene, as it is read. @param {SceneInfo} scene */
const nameOf = ({ id, options }) => JSON.stringify([id, options]);

export class Mixer {
  sheet = new Sheet("mixer");
  /** Of the service, as it says before its first scene. */
  run = "";
  #overlay = byId("handles", SVGSVGElement);
  #lights = text("lights");
  #material = byId("material", HTMLSelectElement);
  #object = byId("object", HTMLSelectElement);
  #step = byId("move-step", HTMLInputElement);
  #turnStep = byId("turn-step", HTMLInputElement);
  #turns = byId("handles-turn", HTMLInputElement);
  #sizes = byId("handles-size", HTMLInputElement);
  #undo = button("undo");
  #redo = button("redo");
  #reset = button("edits-reset");
  #own = byId("edits-own", HTMLInputElement);
  #share = button("edits-share");
  #export = byId("export", HTMLAnchorElement);
  /** @type {string | null} */
  #address = null;
  #events;
  #history;
  #materials;
  #objects;
  #marks;
  #gizmo;
  /** @type {LightRow[]} */
  #rows = [];
  /** @type {SceneInfo | null} */
  #scene = null;
  /** @type {Chosen | null} */
  #chosen = null;
  /** The light of what was picked, whose row is marked, too. @type {string | null} */
  #shining = null;

  /** @param {MixerEvents} events */
  constructor(events) {
    this.#events = events;
    this.#history = new EditHistory(events.send, events.own, () => this.#show());
    this.#materials = new MaterialFields((id, edit, what) => {
      this.#history.edit({ materials: { [id]: edit } }, `${id}/${what}`);
    });
    this.#objects = new ObjectFields((id, edit, what) => {
      this.#history.edit({ objects: { [id]: edit } }, `${id}/${what}`);
    }, this.#moveStep, this.#angleStep);
    this.#marks = new Marks(this.#overlay, (id) => this.#choose({ kind: "light", id }));
    this.#gizmo = new Gizmo(this.#overlay, {
      move: (to) => this.#handle("move", (chosen, scene) => movedTo(chosen, scene, this.#differences, to)),
      turn: (from, axis, angle) => this.#handle("turn", (chosen) => turnedFrom(chosen, from, axis, angle)),
      size: (size) => this.#handle("scale", (chosen, scene) => sizedTo(chosen, scene, this.#differences, size)),
      end: () => this.#history.end(),
      step: this.#moveStep,
      turnStep: () => (this.#angleStep() * Math.PI) / 180,
    });
    for (const id of ["handles-move", "handles-turn", "handles-size"]) byId(id, HTMLInputElement).addEventListener("change", () => this.#show());
    this.#object.addEventListener("change", () => {
      this.#choose(this.#object.value ? { kind: "object", id: this.#object.value } : null);
    });
    this.#material.addEventListener("change", () => this.#show());
    this.#undo.addEventListener("click", () => this.#history.undo());
    this.#redo.addEventListener("click", () => this.#history.redo());
    this.#own.addEventListener("change", () => this.#history.setOwn(this.#own.checked));
    this.#share.addEventListener("click", () => this.#history.setOwn(false, true));
    this.#reset.addEventListener("click", () => this.#history.reset());
    this.#export.addEventListener("click", (event) => {
      if (this.#address === null || !this.#history.own) return;
      event.preventDefault();
      events.save(this.#address, this.#history.edits);
    });
    this.sheet.onShow = (open) => {
      this.#overlay.toggleAttribute("hidden", !open);
      events.redraw();
    };
    text("mixer").addEventListener("change", () => this.#history.end());
    document.addEventListener("keydown", (event) => this.#key(event));
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) save(KEPT, this.#scene && this.ownEdits && { of: nameOf(this.#scene), edits: this.ownEdits }, "sessionStorage");
    });
    this.#overlay.addEventListener("keydown", (event) => event.key === "Escape" && this.sheet.toggle());
  }

  /** Whether the server lets its viewers edit. @param {boolean} takes */
  set allowed(takes) {
    button("toggle-mixer").hidden = !takes;
  }

  get allowed() {
    return !button("toggle-mixer").hidden;
  }

  /** Where the scene can be downloaded, as all see it, if not with its own edits; null where it cannot. @param {string | null} address */
  set download(address) {
    this.#address = address;
    this.#show();
  }

  /** All that differs, with what is on its way. */
  get edits() {
    return this.#history.edits;
  }

  /** The same, if it is this viewer's own; null where it sees what all see. */
  get ownEdits() {
    return this.#history.own ? this.edits : null;
  }

  /** A scene is there; of the same on another connection what was chosen stays so. @param {SceneInfo} scene */
  scene(scene) {
    const stays = this.#scene?.id === scene.id && JSON.stringify(this.#scene.options) === JSON.stringify(scene.options);
    const [object, material] = stays ? [this.#object.value, this.#material.value] : ["", ""];
    this.#scene = scene;
    if (!stays) this.#chosen = null;
    this.#rows = scene.lights.map((light, number) => this.#row(light, number));
    this.#lights.replaceChildren(...this.#rows.map(({ row }) => row));
    text("no-lights").hidden = scene.lights.some(({ added }) => !added);
    for (const [select, parts, chosen] of /** @type {const} */ ([[this.#material, scene.materials, material], [this.#object, scene.objects, object]])) {
      offer(select, [{ value: "", label: "None chosen" }, ...parts.map(({ id }) => ({ value: id, label: id }))]);
      select.value = parts.some(({ id }) => id === chosen) ? chosen : "";
    }
    this.#materials.materials = scene.materials;
    const { min, max } = scene.bounds;
    if (!stays) this.#step.value = String(stepIn(Math.hypot(max[0] - min[0], max[1] - min[1], max[2] - min[2])));
    this.#history.restart(stays, this.run, this.#kept(scene));
  }

  /** Own edits of a scene that the tab had when it was left; once. @param {SceneInfo} scene @returns {import("../messages.js").SceneEdits | null} */
  #kept(scene) {
    const { of, edits } = /** @type {{of?: unknown, edits?: any}} */ (load(KEPT, "sessionStorage") ?? {});
    save(KEPT, null, "sessionStorage");
    return of === nameOf(scene) ? edits : null;
  }

  /** The server says what differs. @param {import("../messages.js").Edits} message */
  told(message) {
    if (this.#history.told(message)) this.#events.lost();
  }

  /** The server refused an edit, and will say what differs. @param {number} id */
  refused(id) {
    this.#history.refused(id);
  }

  /** What was pointed at is chosen. @param {PickedPart} part */
  pick({ object, material, light }) {
    this.#material.value = material ?? "";
    this.#choose(object ? { kind: "object", id: object } : light ? { kind: "light", id: light } : null, light);
    if (object || material || light) this.sheet.open();
  }

  /** What lies over the picture is drawn for a view of the scene. @param {import("../viewer/projection.js").Projection} projection */
  draw(projection) {
    if (this.#overlay.hasAttribute("hidden")) return;
    this.#marks.draw(projection);
    this.#gizmo.draw(projection);
  }

  /** Changes what is not to be undone, such as the time of an animation that plays. @param {ScenePatch} patch */
  set(patch) {
    this.#history.set(patch);
  }

  /** Undo and redo, wherever the keyboard is while the sheet is open. @param {KeyboardEvent} event */
  #key(event) {
    if (this.#overlay.hasAttribute("hidden")) return;
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    // Keyboards of other alphabets have these letters where Latin ones do.
    const key = /^[a-z]$/i.test(event.key) ? event.key.toLowerCase() : event.code.slice(-1).toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    if (key === "y" || event.shiftKey) this.#history.redo();
    else this.#history.undo();
  }

  /** @param {Chosen | null} chosen @param {string | null} [shining] */
  #choose(chosen, shining = null) {
    this.#chosen = chosen;
    this.#shining = shining;
    this.#object.value = chosen?.kind === "object" ? chosen.id : "";
    this.#show();
    if (chosen?.kind === "light") this.#rows.find(({ light }) => light.id === chosen.id)?.row.scrollIntoView({ block: "nearest" });
    this.#events.redraw();
  }

  /** @param {import("../messages.js").LightInfo} light @param {number} number */
  #row(light, number) {
    return new LightRow(light, number, {
      edit: (edit, what) => this.#history.edit({ lights: atOneTime(light.id, edit, this.#history.edits.lights) }, what && `${light.id}/${what}`),
      camera: this.#events.camera,
      step: this.#moveStep,
      turnStep: this.#angleStep,
      choose: () => this.#choose(this.#chosen?.kind === "light" && this.#chosen.id === light.id ? null : { kind: "light", id: light.id }),
    });
  }

  /** Where things and lights are. */
  get #differences() {
    return { ...this.#history.edits, suns: this.#history.suns };
  }

  /** Of an arrow key [m]. */
  #moveStep = () => this.#step.valueAsNumber || 1;
  /** And [°]. */
  #angleStep = () => this.#turnStep.valueAsNumber || 1;

  /** Handles move or turn what is chosen. @param {string} what @param {(chosen: Chosen, scene: SceneInfo) => ScenePatch | null} change  null: it is at its end */
  #handle(what, change) {
    if (!this.#chosen || !this.#scene) return;
    const patch = change(this.#chosen, this.#scene);
    if (patch) this.#history.edit(patch, `${this.#chosen.id}/${what}`);
    else this.#events.say(`${this.#chosen.id} stays within the box of the scene`);
  }

  #show() {
    const { time, lights, materials, objects } = this.#history.edits;
    const light = this.#chosen?.kind === "light" ? this.#chosen.id : null;
    for (const row of this.#rows) row.show(lights[row.light.id], this.#history.suns[row.light.id], row.light.id === light || row.light.id === this.#shining);
    this.#materials.show(this.#material.value, materials[this.#material.value]);
    this.#objects.show(this.#object.value, objects[this.#object.value]);
    this.#undo.disabled = !this.#history.canUndo;
    this.#redo.disabled = !this.#history.canRedo;
    const { own } = this.#history;
    this.#own.checked = own;
    this.#share.hidden = !own;
    text("own-hint").textContent = own ? "Only you see these changes, and none of others." : "All who look at this scene see these changes.";
    this.#export.hidden = this.#address === null;
    if (this.#address !== null) this.#export.href = this.#address;
    this.#reset.disabled = time === null && [lights, materials, objects].every((parts) => Object.keys(parts).length === 0);
    this.#marks.show(
      this.#rows.flatMap((row) => {
        const edit = lights[row.light.id];
        const at = row.at(edit);
        const color = toHex(edit?.color ?? row.light.color);
        return at ? [{ id: row.light.id, at, color, on: edit?.on ?? true, chosen: row.light.id === light }] : [];
      }),
    );
    const target = targetOf(this.#chosen, this.#scene, this.#differences);
    text("moving").hidden = !target;
    text("handles-kind").hidden = !target?.at || !target.angles;
    text("pick-hint").hidden = target !== null;
    text("sizes").hidden = target?.size === null;
    const kind = this.#sizes.checked && target?.size !== null ? "size" : "move";
    this.#gizmo.show(target, target?.angles && (this.#turns.checked || !target.at) ? "turn" : kind);
    this.#events.redraw();
  }
}
