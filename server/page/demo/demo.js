// SPDX-License-Identifier: GPL-3.0-or-later
// The page that needs no server: dots of pictures and of a camera, and points on a torus.

import "./ccdt/element.js";
import { sample } from "./ccdt/wasm.js";

const [halftone, points] = document.querySelectorAll("section");
const dots = halftone.querySelector("ccdt-halftone"), video = halftone.querySelector("video");
const count = (number) => Number(number).toLocaleString("en");
const tell = (section, text) => { section.querySelector("[role=status]").textContent = text; };

/** Shows a file, and ends the camera. */
function showFile(file) {
  for (const track of video.srcObject?.getTracks() ?? []) track.stop();
  URL.revokeObjectURL(dots.getAttribute("src"));
  dots.setAttribute("src", URL.createObjectURL(file));
}

async function showCamera() {
  try {
    video.srcObject = await navigator.mediaDevices.getUserMedia({ video: true });
    await video.play();
    dots.setAttribute("src", "#camera");
  } catch (error) {
    tell(halftone, `The camera cannot be used: ${error.message}`);
  }
}

halftone.querySelector("[name=file]").addEventListener("change", ({ target }) => { if (target.files[0]) showFile(target.files[0]); });
halftone.querySelector("[name=camera]").addEventListener("click", showCamera);
halftone.querySelector("form").addEventListener("input", ({ target: { name, value } }) => {
  if (dots.hasAttribute(name)) dots.setAttribute(name, value);
});
dots.addEventListener("load", () => {
  const { duration } = performance.getEntriesByName("ccdt-halftone").at(-1);
  tell(halftone, `${count(dots.getAttribute("sites"))} dots, computed in this browser in ${Math.round(duration)} ms`);
  halftone.querySelector("a").href = dots.shadowRoot.querySelector("img").src;
});
dots.addEventListener("error", ({ message }) => tell(halftone, message));

function draw(places, tiles) {
  const context = points.querySelector("canvas").getContext("2d");
  const { width } = context.canvas, side = width / tiles;
  const radius = Math.max(0.3 * side / Math.sqrt(places.length), 0.7);
  context.clearRect(0, 0, width, width);
  context.beginPath();
  for (const [x, y] of places) {
    for (let tile = 0; tile < tiles ** 2; ++tile) {
      const [left, top] = [side * (x + tile % tiles), side * (y + Math.floor(tile / tiles))];
      context.moveTo(left + radius, top);
      context.arc(left, top, radius, 0, 2 * Math.PI);
    }
  }
  context.fill();
}

let isComputing = false, isOutdated = false;

/** Computes the points for the fields; again if they change in the meantime. */
async function spread() {
  isOutdated = isComputing;
  if (isComputing) return;
  isComputing = true;
  const { sites, seed, tiles } = points.querySelector("form").elements;
  const start = performance.now();
  try {
    const answer = await sample({ sites: Number(sites.value), seed: Number(seed.value), domain: { type: "torus", width: 1, height: 1 } });
    tell(points, `${count(answer.points.length)} points, computed in this browser in ${Math.round(performance.now() - start)} ms`);
    draw(answer.points, tiles.checked ? 2 : 1);
  } catch (error) {
    tell(points, error.message);
  }
  isComputing = false;
  if (isOutdated) spread();
}

points.addEventListener("input", spread);
spread();
navigator.serviceWorker?.register("service_worker.js");
