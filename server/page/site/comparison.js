// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps settings as A, and lists in what the current settings, B, differ from them.

import { make } from "./dom.js";

/**
 * Returns the settings that differ: [{label, texts}]. A setting that only one side has differs if it is not the initial
 * one; the other side then has a dash.
 */
function differencesOf(a, b) {
  const [before, now] = [a, b].map((words) => new Map(words.map((one) => [one.key, one])));
  return [...new Map([...now, ...before]).values()].map(({ key, label, first }) => {
    const sides = [before, now].map((words) => words.get(key)?.text);
    return { label, isDifferent: (sides[0] ?? first) !== (sides[1] ?? first), texts: sides.map((text) => text ?? "\u2013") };
  }).filter(({ isDifferent }) => isDifferent);
}

export class Comparison {
  /**
   * @param place    parent of the buttons and the list
   * @param keep     returns what to keep as A: `words`, its settings in words, and whatever the panel needs to show it
   * @param restore  called with what was kept, to make its settings the current ones
   * @param turned   called after A was set or removed
   */
  constructor(place, { keep, restore, turned }) {
    this.turned = turned;
    this.kept = null;
    const button = (textContent, act) => {
      const one = make("button", { type: "button", textContent });
      one.addEventListener("click", act);
      return one;
    };
    this.keeper = button("Keep as A", () => this.#set(keep()));
    this.hint = make("span", { className: "hint" });
    this.rows = make("tbody");
    const heads = ["Setting", "A", "B"].map((textContent) => make("th", { scope: "col", textContent }));
    this.table = make("table", {}, make("thead", {}, make("tr", {}, ...heads)), this.rows);
    this.others = make("div", { className: "buttons" },
      button("Back to A", () => restore(this.kept)), button("Keep B as A", () => this.#set(keep())), button("End", () => { this.end(); this.keeper.focus(); }));
    place.append(make("p", { className: "choose" }, this.keeper, this.hint), this.table, this.others);
    this.tell([]);
  }

  #set(kept) {
    const isFirst = this.kept === null;
    this.kept = kept;
    this.turned(isFirst);
    if (isFirst) this.others.firstChild.focus();
  }

  /** Removes A. */
  end() {
    if (!this.kept) return;
    this.kept = null;
    this.turned(true);
  }

  /** @param words  settings in words: [{key, label, text, first}] */
  tell(words) {
    const isOn = this.kept !== null;
    const differences = isOn ? differencesOf(this.kept.words, words) : [];
    this.keeper.hidden = isOn;
    this.others.hidden = !isOn;
    this.table.hidden = differences.length === 0;
    this.hint.hidden = !this.table.hidden;
    this.hint.textContent = isOn ? "A is on the left. Change settings for B." : "to compare settings";
    this.rows.replaceChildren(...differences.map(({ label, texts }) =>
      make("tr", {}, make("th", { scope: "row", textContent: label }), ...texts.map((textContent) => make("td", { textContent })))));
  }
}
