// SPDX-License-Identifier: GPL-3.0-or-later
// Names of inks for risographs, with their approximate colours on white paper.

/** Pairs of a name and a colour. */
export const namedInks = [
  ["Black", "#000000"], ["Blue", "#0078bf"], ["Fluorescent pink", "#ff48b0"], ["Yellow", "#ffe800"], ["Green", "#00a95c"],
  ["Orange", "#ff6c2f"], ["Red", "#ff665e"], ["Bright red", "#f15060"], ["Crimson", "#e45d50"], ["Scarlet", "#f65058"],
  ["Burgundy", "#914e72"], ["Purple", "#765ba7"], ["Violet", "#9d7ad2"], ["Medium blue", "#3255a4"],
  ["Federal blue", "#3d5588"], ["Aqua", "#5ec8e5"], ["Teal", "#00838a"], ["Mint", "#82d8d5"], ["Hunter green", "#407060"],
  ["Kelly green", "#67b346"], ["Sunflower", "#ffb511"], ["Apricot", "#f6a04d"], ["Fluorescent orange", "#ff7477"],
  ["Brown", "#925f52"], ["Metallic gold", "#ac936e"], ["Grey", "#928d88"],
];

/** Returns the name of a colour, or the colour if it has none. */
export const nameOf = (colour) => namedInks.find(([, one]) => one === colour)?.[0] ?? colour;
