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

/**
 * Passes the files of each drop, anywhere on the page, to `take`. Calls `mark` with true while a file is over the
 * page, and then with false.
 */
export function acceptDrops(take, mark) {
  const on = (kind, act) => addEventListener(kind, (event) => {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    act(event);
  });
  on("dragover", () => mark(true));
  on("dragleave", ({ relatedTarget }) => mark(relatedTarget !== null));
  on("drop", ({ dataTransfer: { files } }) => {
    mark(false);
    if (files.length > 0) take([...files]);
  });
}

/** Copies a file to memory, because browsers do not send a file that has changed on disk. */
export async function inMemory(file) {
  try {
    return new File([await file.arrayBuffer()], file.name, { type: file.type });
  } catch (cause) {
    throw new Error(`${file.name} cannot be read. If it has changed, choose it again`, { cause });
  }
}

export const count = (number) => number.toLocaleString("en");
export const metres = (length) => (length < 1000 ? `${Number(length.toPrecision(2))} m` : `${Number((length / 1000).toPrecision(2))} km`);
export const seconds = (start) => `${((performance.now() - start) / 1000).toFixed(2)} s`;
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
