// SPDX-License-Identifier: GPL-3.0-or-later
// Drawing rings on a viewport: press for a corner, press the first one to close, drag corners of what is there.

const reach = 12;  // CSS pixels to a corner

export class Drawing {
  #ring = null;

  /**
   * @param toScreen  a corner's place in CSS pixels
   * @param toShape   the corner at a place, rounded
   * @param grasped   called before a corner of what is there is moved
   * @param changed   called while rings change, with whether they are still on the move
   */
  constructor({ toScreen, toShape, grasped, changed }) {
    Object.assign(this, { toScreen, toShape, grasped, changed });
  }

  /** The ring that is being drawn; null if none is. */
  get ring() {
    return this.#ring;
  }

  /** `done(ring)` is called with the closed ring. */
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

  /** @returns  what takes the moves that follow; null: the press is not for us */
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
