// SPDX-License-Identifier: GPL-3.0-or-later
// The address: which panel is shown, and its settings, to be shared and to survive a reload.

/** @returns  {panel, settings}: its name, empty if the address has none, and texts by name */
export function readAddress() {
  const [, panel, query] = location.hash.match(/^#?([^?]*)\??(.*)$/s);
  return { panel, settings: Object.fromEntries(new URLSearchParams(query)) };
}

/** Notes what is shown: as a step that one may go back from, or in the place of what was noted last. */
export function writeAddress(panel, settings, isStep) {
  const query = new URLSearchParams(settings).toString();
  const hash = `#${panel}${query && `?${query}`}`;
  if (hash === location.hash) return;
  if (isStep) history.pushState(null, "", hash);  // following an anchor would take the focus away
  else history.replaceState(null, "", hash);
}
