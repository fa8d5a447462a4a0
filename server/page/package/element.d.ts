// SPDX-License-Identifier: GPL-3.0-or-later
// Types of element.js, which defines the element <ccdt-halftone>.

/** Shows a picture as dots. Has the events `load`, `error`, `progress` and `abort`. */
export class HalftoneElement extends HTMLElement {
  /** Requests new dots, because the canvas or video that `src` names has changed. */
  refresh(): void;
  /** Cancels the running request and its job on the server. Keeps the shown picture. */
  abort(): void;
}

declare global {
  interface HTMLElementTagNameMap {
    "ccdt-halftone": HalftoneElement;
  }
}
