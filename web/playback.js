/** The time of an animation that plays, pauses, and begins anew at its end or stays there. */

/** Of the clock, that one step of the animation takes at the most [ms]: a page that was hidden goes on where it was. */
const LONGEST = 250;

export class Playback {
  /** How long the animation lasts [s]. */
  seconds = 0;
  /** Where it is [s]. */
  time = 0;
  /** Times as fast as it is. */
  speed = 1;
  loops = true;
  #playing = false;
  /** When it was last looked at [ms]. @type {number | null} */
  #last = null;

  get playing() {
    return this.#playing;
  }

  /** Plays, from the beginning where it stood at the end. */
  play() {
    if (this.time >= this.seconds) this.time = 0;
    this.#playing = true;
    this.#last = null;
  }

  pause() {
    this.#playing = false;
  }

  /** It is `now` [ms, of any clock]. */
  advance(/** @type {number} */ now) {
    if (!this.#playing) return;
    const passed = Math.min(now - (this.#last ?? now), LONGEST);
    this.#last = now;
    this.time += (passed / 1000) * this.speed;
    if (this.time < this.seconds) return;
    if (this.loops && this.seconds > 0) {
      this.time %= this.seconds;
    } else {
      this.time = this.seconds;
      this.pause();
    }
  }
}
