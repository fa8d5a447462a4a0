// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for the options of /halftone: labels, initial values and help texts.

import { capabilities } from "./api.js";

const { max_sites: maxDots } = capabilities.limits;

export const fields = [
  { kind: "number", name: "sites", label: "Dots", value: Math.min(20000, maxDots), min: 200, max: Math.min(200000, maxDots), step: 1, log: true, auto: false,
    help: "auto: a number that suits the tone and the detail of the picture." },
  { kind: "number", name: "dot", label: "Radius", value: 3, min: 0.1, max: 12, log: true, auto: true, units: [["", "px"], ["mm", "mm"]],
    help: "auto: the radius for which the tone is right. If you set the radius and leave Dots on auto, the number of dots makes the tone right." },
  { kind: "number", name: "width_mm", label: "Picture width, mm", value: 200, min: 20, max: 2000, step: 1, log: true },
  { kind: "choice", name: "tone", label: "Tone", standard: "linear", choices: [["linear", "linear"], ["perceptual", "perceptual: lighter"], ["density", "density: darker"]],
    help: "linear: the average light is right, as seen from a distance. perceptual: the average lightness is right. density: the number of dots is proportional to darkness, even where they overlap." },
  { kind: "number", name: "detail", label: "Detail", value: 0.7, min: 0, max: 1, step: 0.05, standard: 0.7,
    help: "Dots blur the picture. Sharpening compensates for this: 0 is none, 1 is a little too much." },
  { kind: "levels", name: "levels", label: "Levels", standard: "0,1,1", numbers: [
    { label: "black point", value: 0, min: 0, max: 1, step: 0.01 }, { label: "white point", value: 1, min: 0, max: 1, step: 0.01 },
    { label: "gamma", value: 1, min: 0.1, max: 10, step: 0.01 }],
    help: "As in image editors: values up to the black point become black, values from the white point on become white. A gamma above 1 lightens the values between. Auto: the points at which 0.5 % of the picture is black or white." },
  { kind: "choice", name: "dots", label: "Dots are", standard: "both", choices: [["both", "ink and paper"], ["ink", "ink"], ["paper", "paper on black"]],
    help: "Ink and paper: dots of ink in light areas, and holes in the ink in dark areas." },
  { kind: "check", name: "antialias", label: "Soft edges", checked: true,
    help: "Pixels at the edge of a dot are grey, which suits screens. Without this, a pixel is covered or not, which suits printers." },
  { kind: "choice", name: "color", label: "Inks", standard: "gray", choices: [["gray", "one"], ["cmyk", "CMYK"], ["rgb", "RGB: light on black"], ["palette", "a palette"]],
    help: "If dots are ink, dots of different inks keep a distance." },
  { kind: "palette", name: "palette", label: "Palette", item: "ink", isNamed: true, least: 1, number: 4, colours: ["#0078bf", "#ff48b0", "#ffe800", "#000000", "#00a95c", "#ff6c2f"] },
  { kind: "colour", name: "foreground", label: "Dot colour", value: "#000000", standard: "#000000" },
  { kind: "colour", name: "background", label: "Background", value: "#ffffff", standard: "#ffffff", transparent: true },
];

/** The point of the picture that stays visible when it is cut. */
export const gravity = { kind: "numbers", name: "gravity", label: "Focal point", standard: "0.5,0.5",
  numbers: ["from left", "from top"].map((label) => ({ label, value: 0.5, min: 0, max: 1, step: 0.01 })),
  help: "The point of the picture that is shown as near to the middle as possible. Drag it on the small picture." };

export const moreFields = [
  { kind: "number", name: "width", label: "Width, px", value: 1200, min: 100, max: 8000, step: 1, log: true, auto: true,
    help: "Width of the result, for screens. auto: the result fits into 1,280 by 800 pixels, but its longer side has at least 1,000. For print, set the scale or the print width instead." },
  { kind: "number", name: "height", label: "Height, px", value: 800, min: 100, max: 8000, step: 1, log: true, auto: true,
    help: "Height of the result. auto: the height that keeps the aspect ratio." },
  { kind: "choice", name: "fit", label: "Fit", standard: "contain", choices: [["contain", "whole picture"], ["cover", "cut to fill"]] },
  gravity,
  { kind: "number", name: "scale", label: "Scale", value: 2, min: 0.1, max: 16, log: true, auto: true,
    help: "Pixels of the result per pixel of the picture, along each side. For print. auto: the width determines the size." },
  { kind: "choice", name: "alpha", label: "Transparency", standard: "display", choices: [["display", "as in viewers"], ["linear", "lighter"]] },
  { kind: "choice", name: "quality", label: "Quality", standard: "standard", choices: [["standard", "standard"], ["draft", "draft: faster"], ["best", "best: slower"]],
    help: "How evenly dots are spread. A draft takes half as long as standard, best takes twice as long." },
  { kind: "number", name: "seed", label: "Seed", value: 0, min: 0, max: 100, step: 1, standard: 0,
    help: "Another number gives a different arrangement of dots, of equal quality." },
  { kind: "number", name: "iterations", label: "Iterations", value: 5, min: 0, max: 50, step: 1, standard: 5,
    help: "Rounds that spread the dots evenly. 0 shows the initial positions." },
  { kind: "number", name: "passes", label: "Passes", value: 5, min: 1, max: 20, step: 1, standard: 5,
    help: "How often each dot is moved per iteration." },
  { kind: "choice", name: "style", label: "Dots in SVG", standard: "fill", choices: [["fill", "filled"], ["stroke", "strokes for plotters"]] },
  { kind: "choice", name: "on_deadline", label: "At the time limit", standard: "error", choices: [["error", "show an error"], ["partial", "show the result so far"]],
    help: "The server limits how long a request may take." },
];

const most = (sites) => String(Math.min(sites, maxDots));

/** Presets. Each lists the settings that differ from their initial values. */
export const presets = [
  { title: "Newspaper", settings: { sites: most(9000), dots: "ink", foreground: "#1d1b18", background: "#efe9dc" } },
  { title: "Ink and paper", settings: {} },
  { title: "Risograph", settings: { sites: most(24000), color: "palette", palette: "#0078bf,#ff48b0,#ffe800", background: "#fbf8ef" } },
  { title: "Plotter", settings: { sites: "auto", plotter: "on", pen_mm: "1.5" } },
  { title: "One line", settings: { sites: "auto", plotter: "on", pen_mm: "0.5", style: "path" } },
];
