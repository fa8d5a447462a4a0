// SPDX-License-Identifier: GPL-3.0-or-later
// Creates elements, saves files, and formats numbers.

/** Creates an element with properties, attributes and children. */
export function make(tag, { attributes = {}, ...properties } = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

let saved = null;

/** Saves a file. Revokes its URL only at the next call, because some browsers save after this function has returned. */
export function save(blob, name) {
  if (saved) URL.revokeObjectURL(saved);
  saved = URL.createObjectURL(blob);
  make("a", { href: saved, download: name }).click();
}

/** Passes the first file of each drop on an element to `take`. */
export function acceptDrops(element, take) {
  const mark = (over) => (event) => {
    event.preventDefault();
    element.classList.toggle("over", over);
  };
  element.addEventListener("dragover", mark(true));
  element.addEventListener("dragleave", mark(false));
  element.addEventListener("drop", (event) => {
    mark(false)(event);
    if (event.dataTransfer.files.length > 0) take(event.dataTransfer.files[0]);
  });
}

export const count = (number) => number.toLocaleString("en");
export const metres = (length) => (length < 1000 ? `${Number(length.toPrecision(2))} m` : `${Number((length / 1000).toPrecision(2))} km`);
export const seconds = (start) => `${((performance.now() - start) / 1000).toFixed(2)} s`;
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
