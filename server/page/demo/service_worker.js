// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the files of the page, so that it works offline: also its workers, which begin anew after an aborted computation.

const stored = caches.open("ccdt");

addEventListener("install", (event) => {
  event.waitUntil(stored.then(async (cache) => cache.addAll(["./", ...await (await fetch("files.json")).json()])));
});
addEventListener("activate", (event) => event.waitUntil(globalThis.clients.claim()));
addEventListener("fetch", (event) => {
  if (event.request.method !== "GET" || !event.request.url.startsWith(registration.scope)) return;
  event.respondWith(fetch(event.request).catch(async () => (await (await stored).match(event.request)) ?? Response.error()));
});
