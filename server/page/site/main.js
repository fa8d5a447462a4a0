// SPDX-License-Identifier: GPL-3.0-or-later
// Sets up the page: its panels, the tabs that select a panel, the address, and the form for the API key.

import { readAddress, writeAddress } from "./address.js";
import { capabilities, setKey } from "./api.js";
import { acceptDrops } from "./dom.js";
import { Halftone } from "./halftone.js";

const tabs = [...document.querySelectorAll("[role=tab]")];
const nameOf = (tab) => tab.getAttribute("aria-controls");

const panels = { halftone: new Halftone(document.getElementById("halftone")) };
const loaders = {
  devices: async (element) => new (await import("./devices.js")).Devices(element),
  sample: async (element) => new (await import("./sample.js")).Sample(element),
  analyze: async (element) => new (await import("./analyze.js")).Analyze(element, { halftone: panels.halftone, sample: await panelNamed("sample") }),
};
const loading = {};

/** Returns a panel. Panels other than the first are loaded when they are first needed. */
async function panelNamed(name) {
  loading[name] ??= loaders[name]?.(document.getElementById(name));
  return panels[name] ??= await loading[name];
}

function select(tab) {
  for (const other of tabs) {
    other.setAttribute("aria-selected", String(other === tab));
    other.tabIndex = other === tab ? 0 : -1;
    document.getElementById(nameOf(other)).hidden = other !== tab;
  }
}

async function show() {
  const { panel: name, settings } = readAddress();
  const tab = tabs.find((one) => nameOf(one) === name) ?? tabs[0];
  const panel = await panelNamed(nameOf(tab));
  select(tab);
  await panel.restore(settings);
  panel.activate();
}

/** Promise for the end of the last `show`. Calls run one after another, and each reads the address when it starts. */
let shown = Promise.resolve();
function showAddress() {
  shown = shown.catch(() => {}).then(show);
}

for (const tab of tabs) {
  const element = document.getElementById(nameOf(tab));
  tab.addEventListener("click", async () => {
    select(tab);
    const panel = await panelNamed(nameOf(tab));
    if (element.hidden) return;
    writeAddress(nameOf(tab), panel.state(), true);
    panel.activate();
  });
  element.addEventListener("settings", ({ detail }) => {
    if (!element.hidden) writeAddress(nameOf(tab), panels[nameOf(tab)].state(), detail.isStep);
  });
  element.addEventListener("elsewhere", async ({ detail: { files, panel: name } }) => {
    select(tabs.find((one) => nameOf(one) === name));
    (await panelNamed(name)).take(files);
  });
}
document.querySelector("[role=tablist]").addEventListener("keydown", ({ key }) => {
  const steps = { ArrowRight: 1, ArrowLeft: -1 };
  if (!(key in steps)) return;
  const next = tabs[(tabs.indexOf(document.activeElement) + steps[key] + tabs.length) % tabs.length];
  next.focus();
  next.click();
});
addEventListener("popstate", showAddress);
const visible = () => Object.values(panels).find(({ element }) => !element.hidden);
acceptDrops((files) => visible()?.take(files), (isOver) => visible()?.find(".drop")?.classList.toggle("over", isOver));

const access = document.getElementById("access");
document.addEventListener("keyneeded", ({ detail }) => {
  access.hidden = false;
  document.getElementById("key-error").textContent = detail;
});
access.addEventListener("submit", (event) => {
  event.preventDefault();
  setKey(document.getElementById("key").value);
  access.hidden = true;
  document.getElementById("key-error").textContent = "";
  for (const panel of Object.values(panels)) panel.refresh();
});

document.getElementById("documentation").hidden = !capabilities.documentation;

showAddress();
