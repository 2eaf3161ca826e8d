/** Sends the camera's pose when it has changed: asked once an animation frame, so that only the newest goes out. */

export class PoseSender {
  #session;
  #last = "";

  /** @param {import("../session.js").Session} session */
  constructor(session) {
    this.#session = session;
  }

  /** Sends the next pose even if it is the same: the server knows none yet. */
  forget() {
    this.#last = "";
  }

  /**
   * @param {number[]} matrix column-major, camera to world
   * @param {number} yfov vertical field of view [rad]
   * @param {number} near what is less far in front of the camera is cut away [m]
   * @returns {boolean} whether a changed pose waits for the network
   */
  update(matrix, yfov, near) {
    const pose = [...matrix, yfov, near].join();
    if (pose === this.#last) return false;
    if (!this.#session.takesPoses) return this.#session.scene !== null;
    this.#session.sendPose(matrix, yfov, near);
    this.#last = pose;
    return false;
  }
}
