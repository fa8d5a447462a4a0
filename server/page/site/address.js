// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the panel and its settings in the address of the page, so that they can be shared and survive a reload.

/**
 * Reads the address.
 * @returns  {panel, settings}: name of the panel, empty if the address has none; settings as texts by name
 */
export function readAddress() {
  const [, panel, query] = location.hash.match(/^#?([^?]*)\??(.*)$/s);
  return { panel, settings: Object.fromEntries(new URLSearchParams(query)) };
}

/**
 * Writes a panel and its settings to the address. If `isStep`, the history gets a new entry; otherwise its current
 * entry is replaced.
 */
export function writeAddress(panel, settings, isStep) {
  const query = new URLSearchParams(settings).toString();
  const hash = `#${panel}${query && `?${query}`}`;
  if (hash === location.hash) return;
  if (isStep) history.pushState(null, "", hash);  // assigning location.hash would move the focus
  else history.replaceState(null, "", hash);
}
