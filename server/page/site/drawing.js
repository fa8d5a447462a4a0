// SPDX-License-Identifier: GPL-3.0-or-later
// Lets the user draw rings of a polygon. A press adds a corner, or closes the ring at its first corner. Existing
// corners can be dragged.

const reach = 12;  // CSS pixels; maximum distance at which a press hits a corner

export class Drawing {
  #ring = null;

  /**
   * @param toScreen  returns the position of a corner on the screen, in CSS pixels
   * @param toShape   returns the corner at a position on the screen, rounded
   * @param grasped   called before an existing corner is moved
   * @param changed   called when rings change; the argument tells whether the user is still moving a corner
   */
  constructor({ toScreen, toShape, grasped, changed }) {
    Object.assign(this, { toScreen, toShape, grasped, changed });
  }

  /** Ring being drawn; null if there is none. */
  get ring() {
    return this.#ring;
  }

  /** Starts a new ring. `done` is called with the ring when it is closed. */
  start(done) {
    this.#ring = [];
    this.done = done;
  }

  cancel() {
    this.#ring = null;
  }

  undo() {
    this.#ring.pop();
  }

  clear() {
    this.#ring.length = 0;
  }

  close() {
    if (!this.#ring || this.#ring.length < 3) return;
    const ring = this.#ring;
    this.#ring = null;
    this.done(ring);
  }

  #near(corner, at) {
    const place = this.toScreen(corner);
    return Math.hypot(place.x - at.x, place.y - at.y) < reach;
  }

  /**
   * Handles a press at a position.
   * @returns  a function for the following positions of the pointer, and finally null; null if the press hits no corner
   */
  press(at, rings) {
    if (this.#ring) return this.#add(at);
    for (const ring of rings) {
      const index = ring.findIndex((corner) => this.#near(corner, at));
      if (index >= 0) return this.#drag(ring, index);
    }
    return null;
  }

  #add(at) {
    if (this.#ring.length >= 3 && this.#near(this.#ring[0], at)) {
      this.close();
      return () => {};
    }
    this.#ring.push(this.toShape(at));
    this.changed(true);
    return this.#drag(this.#ring, this.#ring.length - 1, true);
  }

  #drag(ring, index, drawing = false) {
    let moved = false;
    return (at) => {
      if (at === null) {
        if (moved && !drawing) this.changed(false);
        return;
      }
      if (!moved && !drawing) this.grasped();
      moved = true;
      ring[index] = this.toShape(at);
      this.changed(true);
    };
  }
}
