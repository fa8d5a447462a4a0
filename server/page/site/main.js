// Puts the page together: its panels, the tabs that choose among them, the key.

import { setKey } from "./api.js";
import { Analyze } from "./analyze.js";
import { Halftone } from "./halftone.js";
import { Sample } from "./sample.js";

const tabs = [...document.querySelectorAll("[role=tab]")];
const panelOf = (tab) => document.getElementById(tab.getAttribute("aria-controls"));

const halftone = new Halftone(document.getElementById("halftone"));
const sample = new Sample(document.getElementById("sample"));
const analyze = new Analyze(document.getElementById("analyze"), { halftone, sample });
const firstShown = {
  halftone: () => halftone.chooseSample("astronaut.jpg"),
  sample: () => sample.refresh(),
};

function show(tab) {
  for (const other of tabs) {
    other.setAttribute("aria-selected", String(other === tab));
    other.tabIndex = other === tab ? 0 : -1;
    panelOf(other).hidden = other !== tab;
  }
  const name = panelOf(tab).id;
  if (name === "analyze") analyze.refresh();
  firstShown[name]?.();
  delete firstShown[name];
}

function showNamed() {
  show(tabs.find((tab) => `#${panelOf(tab).id}` === location.hash) ?? tabs[0]);
}

for (const tab of tabs) {
  tab.addEventListener("click", () => {
    history.pushState(null, "", `#${panelOf(tab).id}`);  // following the anchor would take the focus away
    show(tab);
  });
}
document.querySelector("[role=tablist]").addEventListener("keydown", ({ key }) => {
  const steps = { ArrowRight: 1, ArrowLeft: -1 };
  if (!(key in steps)) return;
  const next = tabs[(tabs.indexOf(document.activeElement) + steps[key] + tabs.length) % tabs.length];
  next.focus();
  next.click();
});
addEventListener("popstate", showNamed);

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
  for (const panel of [halftone, sample, analyze]) panel.refresh();
});

showNamed();
