// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the files of the user in the browser, so that they are still there after the page is loaded again.

let database = null;

const resultOf = (request) => new Promise((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

async function open() {
  const request = indexedDB.open("ccdt");
  request.onupgradeneeded = () => request.result.createObjectStore("files");
  return resultOf(request);
}

/** Returns the result of an operation on the stored files; undefined if the browser stores none. */
async function ofStore(mode, operate) {
  try {
    database ??= open();
    return await resultOf(operate((await database).transaction("files", mode).objectStore("files")));
  } catch {
    return undefined;
  }
}

/** Stores a value, which may contain blobs, under a name. */
export const keep = (name, value) => ofStore("readwrite", (store) => store.put(value, name));

/** Returns the value that was stored last under a name; undefined if there is none. */
export const kept = (name) => ofStore("readonly", (store) => store.get(name));
