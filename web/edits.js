/**
 * What differs of a scene from its file: what the server says, and on top of it what was asked for and is on its way,
 * so that a slider stays where the user has it. What was done here can be undone; what others do shows up, unless edits
 * are this viewer's own.
 */

import { compose, difference, inverse, merge, removal, replaced, without } from "./merge.js";

/** @typedef {import("./messages.js").SceneEdits} SceneEdits */
/** @typedef {import("./messages.js").ScenePatch} ScenePatch */
/** @typedef {{id: number, patch: ScenePatch}} Part  of what was done, by the message that it is in */
/**
 * What was done. asked: the message that undoes it, or does it again, or `REFUSED`; what: the gesture that it is of, if
 * that goes on.
 * @typedef {{undo: ScenePatch, parts: Part[], asked: number, what: string | null}} Step
 */

/** Between two messages [ms]: fewer than the server takes. */
const REST = 40;
/** Instead of a message that the server refused. */
const REFUSED = -1;
/** A scene as its file has it. @type {SceneEdits} */
const NONE = { time: null, animation: null, lights: {}, materials: {}, objects: {} };

export class EditHistory {
  /** Whether edits are this viewer's own, as is known or was asked for. */
  own = false;
  /** Where lights shine that are the sun of a date. @type {import("./messages.js").Edits["suns"]} */
  suns = {};
  /** Own ones of the same scene from before, until edits are its own again. @type {SceneEdits | null} */
  #kept = null;
  /** The message that asks for that. */
  #asked = 0;
  #send;
  #sendOwn;
  #changed;
  /** @type {SceneEdits} */
  #known = NONE;
  /** Sent, and not answered yet. @type {Part[]} */
  #sent = [];
  /** To be sent. @type {ScenePatch | null} */
  #next = null;
  /** Of the newest patch; goes on from scene to scene, as what the server knows of does. */
  #id = 0;
  /** @type {Step[]} */
  #done = [];
  /** @type {Step[]} */
  #undone = [];
  /** Of the service that has these edits. */
  #run = "";
  /** What another run has to know of, so that what was done can be undone. @type {SceneEdits | null} */
  #doubted = null;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {(id: number, patch: ScenePatch) => void} send
   * @param {(id: number, own: boolean, share: boolean) => void} sendOwn
   * @param {() => void} changed  `edits`, whose they are, or what can be undone have changed
   */
  constructor(send, sendOwn, changed) {
    this.#send = send;
    this.#sendOwn = sendOwn;
    this.#changed = changed;
  }

  /** All that differs, with what is on its way. @returns {SceneEdits} */
  get edits() {
    const made = /** @type {Partial<SceneEdits>} */ (this.#unanswered.reduce(merge, /** @type {unknown} */ (this.#kept ?? this.#known)));
    return { ...NONE, ...made };
  }

  /** What the server does not know of, or not yet. @returns {unknown[]} */
  get #unanswered() {
    return [...this.#sent.map(({ patch }) => patch), ...(this.#next ? [this.#next] : [])];
  }

  get canUndo() {
    return this.#done.length > 0;
  }

  get canRedo() {
    return this.#undone.length > 0;
  }

  /**
   * Another scene, or the same on another connection: nothing is on its way.
   * @param {boolean} stays  it is the same: edits of its own are so again, what the server has not answered is sent again,
   *   and what was done can still be undone, unless another run of the service turns out not to know of it
   * @param {string} run  of the service
   * @param {SceneEdits | null} [kept]  own ones of another scene from before
   */
  restart(stays, run, kept = null) {
    const unanswered = stays && !this.own ? this.#unanswered.reduce(compose, {}) : {};
    this.#kept = !stays ? kept : this.own ? this.edits : this.#kept; // which a short connection may not have come to
    this.#asked = 0;
    this.#doubted = stays && run !== this.#run && this.#kept === null ? this.#known : null;
    this.#run = run;
    this.own = false;
    this.suns = {};
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#known = NONE;
    const ids = new Map(this.#sent.map(({ id }) => [id, this.#id + 1]));
    this.#sent = [];
    this.#next = null;
    if (stays) this.end();
    else this.#forget();
    for (const step of this.#steps) {
      step.asked = ids.get(step.asked) ?? step.asked;
      for (const part of step.parts) part.id = ids.get(part.id) ?? part.id;
    }
    if (Object.keys(/** @type {ScenePatch} */ (unanswered)).length > 0) this.#ask(/** @type {ScenePatch} */ (unanswered));
    this.#changed();
  }

  #forget() {
    this.#done = [];
    this.#undone = [];
  }

  /** Edits are this viewer's own, or those of all: of others' nothing can be undone. @param {boolean} own */
  #belong(own) {
    if (own !== this.own) this.#forget();
    this.own = own;
  }

  /**
   * The server says what differs.
   * @param {import("./messages.js").Edits} message  edit: the newest of this viewer's that it knows
   * @returns {boolean} whether what was done here went with another run of it
   */
  told({ edits, edit, own, suns, shared_over: before }) {
    const other = this.#doubted !== null && JSON.stringify(this.#doubted) !== JSON.stringify(edits);
    const lost = other && this.#steps.length > 0;
    if (lost) this.#forget();
    this.#doubted = null;
    this.#known = edits;
    this.suns = suns;
    this.#sent = this.#sent.filter(({ id }) => id > edit);
    if (this.#sent.length === 0) this.#belong(own);
    if (before) this.#shared(before, edits, edit);
    if (this.#kept && own) {
      const { edits: kept } = this;
      this.#kept = null;
      this.set(/** @type {ScenePatch} */ (compose(removal(edits), kept)));
    } else if (this.#kept && this.#asked === 0) {
      this.own = true; // so that what was done can still be undone
      this.setOwn(true);
      this.#asked = this.#id;
    }
    this.#changed();
    return lost;
  }

  /**
   * Its own edits have become those of all, before all that was done since: a step.
   * @param {SceneEdits} before  what all saw @param {SceneEdits} now @param {number} id
   */
  #shared(before, now, id) {
    const [undo, patch] = /** @type {ScenePatch[]} */ ([difference(now, before), difference(before, now)]);
    if (undo && patch && Object.keys(patch).length > 0) this.#done.unshift({ undo, parts: [{ id, patch }], asked: 0, what: null });
  }

  /** In the order in which they are or were done. */
  get #steps() {
    return [...this.#done, ...this.#undone.toReversed()];
  }

  /** The server refused a message, and will say what differs: nothing that was in it has been done. @param {number} id */
  refused(id) {
    this.#sent = this.#sent.filter((it) => it.id !== id);
    if (id === this.#asked) this.#kept = null; // nobody else is to see them
    const steps = this.#steps;
    for (const step of steps) if (step.asked === id) step.asked = REFUSED;
    this.#giveBack();
    for (const [number, step] of steps.entries()) {
      if (step.parts.every((part) => part.id !== id)) continue;
      step.parts = step.parts.filter((part) => part.id !== id);
      let came = compose(step.undo, redoOf(step));
      for (const later of steps.slice(number + 1)) {
        later.undo = /** @type {ScenePatch} */ (replaced(later.undo, came));
        came = without(came, redoOf(later));
      }
    }
    this.#done = this.#done.filter(({ parts }) => parts.length > 0);
    this.#undone = this.#undone.filter(({ parts }) => parts.length > 0);
    this.#changed();
  }

  /** What refused messages were to undo, or do again, is where it was, as soon as nothing that was is on top of it. */
  #giveBack() {
    giveBack(this.#done, this.#undone);
    giveBack(this.#undone, this.#done);
  }

  /**
   * Has edits be this viewer's own, or again those of all.
   * @param {boolean} own @param {boolean} [share]  those of all become what its own were
   */
  setOwn(own, share = false) {
    clearTimeout(this.#timer);
    this.#flush();
    const shared = /** @type {ScenePatch} */ (share ? this.edits : {});
    if (!own) {
      this.#kept = null; // neither this nor what no connection took is for all to see, unless it is shared
      this.#sent = this.#sent.map(({ id }) => ({ id, patch: {} }));
    }
    this.#belong(own);
    this.#sent.push({ id: ++this.#id, patch: shared });
    this.#sendOwn(this.#id, own, share);
    this.#changed();
  }

  /**
   * Changes something.
   * @param {ScenePatch} patch
   * @param {string | null} [what]  a gesture of many changes, which are undone together, until `end`
   */
  edit(patch, what = null) {
    const last = this.#done.at(-1);
    const part = { id: this.#id + 1, patch };
    if (what !== null && last?.what === what) last.parts.push(part);
    else this.#done.push({ undo: /** @type {ScenePatch} */ (inverse(this.edits, patch)), parts: [part], asked: 0, what });
    this.#undone = [];
    this.#ask(patch);
  }

  /** Changes something that is no step to be undone. @param {ScenePatch} patch */
  set(patch) {
    this.#ask(patch);
  }

  /** All is as the file says. */
  reset() {
    this.edit(/** @type {ScenePatch} */ (removal(this.edits)));
  }

  /** A gesture ends. */
  end() {
    const last = this.#done.at(-1);
    if (last) last.what = null;
  }

  undo() {
    this.#step(this.#done, this.#undone, ({ undo }) => undo);
  }

  redo() {
    this.#step(this.#undone, this.#done, redoOf);
  }

  /** @param {Step[]} from @param {Step[]} to @param {(step: Step) => ScenePatch} way */
  #step(from, to, way) {
    const step = from.pop();
    if (!step) return;
    step.what = null;
    const id = this.#id + 1;
    step.asked = step.asked === id ? 0 : id; // there and back in one message is nothing
    to.push(step);
    this.#giveBack();
    this.#ask(way(step));
  }

  /** @param {ScenePatch} patch */
  #ask(patch) {
    if (this.#kept && this.#asked === 0) {
      this.#kept = /** @type {SceneEdits} */ (merge(this.#kept, patch)); // nobody else is to see it
      return this.#changed();
    }
    this.#next = /** @type {ScenePatch} */ (compose(this.#next ?? {}, patch));
    if (this.#timer === undefined) this.#flush();
    this.#changed();
  }

  #flush() {
    this.#timer = undefined;
    if (!this.#next) return;
    const patch = this.#next;
    this.#next = null;
    this.#sent.push({ id: ++this.#id, patch });
    this.#timer = setTimeout(() => this.#flush(), REST);
    this.#send(this.#id, patch);
  }
}

/** @param {Step} step @returns {ScenePatch} */
const redoOf = ({ parts }) => /** @type {ScenePatch} */ (parts.reduce((made, { patch }) => compose(made, patch), /** @type {unknown} */ ({})));

/** @param {Step[]} from @param {Step[]} to */
function giveBack(from, to) {
  while (from.at(-1)?.asked === REFUSED) {
    const step = /** @type {Step} */ (from.pop());
    step.asked = 0;
    to.push(step);
  }
}
