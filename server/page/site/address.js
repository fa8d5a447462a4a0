// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the visible panel and its settings in the fragment of the page's URL, so that links and reloads restore them.

let shown;  // the fragment that was read or written last

/**
 * Reads the panel and its settings from the address.
 * @returns  {panel, settings}: name of the panel, or ""; settings as texts by name
 */
export function readAddress() {
  shown = location.hash;
  const [, panel, query] = location.hash.match(/^#?([^?]*)\??(.*)$/s);
  return { panel, settings: Object.fromEntries(new URLSearchParams(query)) };
}

/**
 * Writes a panel and its settings to the address. Adds an entry to the history only if `isStep`. Does not replace an
 * address that was not read yet, because the user has just followed a link.
 */
export function writeAddress(panel, settings, isStep) {
  const query = new URLSearchParams(settings).toString();
  const hash = `#${panel}${query && `?${query}`}`;
  if (hash === location.hash || location.hash !== shown) return;
  if (isStep) history.pushState(null, "", hash);  // an assignment to location.hash would move the focus
  else history.replaceState(null, "", hash);
  shown = location.hash;
}
