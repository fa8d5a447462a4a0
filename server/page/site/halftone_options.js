// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for the options of /halftone: labels, initial values and help texts.

import { capabilities } from "./api.js";

const { max_sites: mostDots } = capabilities.limits;

export const fields = [
  { kind: "number", name: "sites", label: "Dots", value: Math.min(20000, mostDots), min: 200, max: Math.min(200000, mostDots), step: 1, log: true, auto: false,
    help: "auto: as many as the ink and the detail of the picture want, 4,096 to 100,000." },
  { kind: "number", name: "dot", label: "Radius", value: 3, min: 0.1, max: 12, log: true, auto: true, units: [["", "px"], ["mm", "mm"]],
    help: "auto: such that the tone is right. A radius of your own, with dots on auto, is a pen's: as many dots as make the tone right." },
  { kind: "number", name: "width_mm", label: "Picture's width, mm", value: 200, min: 20, max: 2000, step: 1, log: true },
  { kind: "choice", name: "tone", label: "Tone", standard: "linear", choices: [["linear", "linear"], ["perceptual", "perceptual: lighter"], ["density", "density: darker"]],
    help: "linear keeps the light that a far eye averages, perceptual the lightness. density puts dots in proportion to darkness, however they overlap." },
  { kind: "number", name: "detail", label: "Detail", value: 0.7, min: 0, max: 1, step: 0.05, standard: 0.7,
    help: "Dots blur what they show. This is how far edges are emphasised to make up for it: 0 leaves them, 1 overdoes it a little." },
  { kind: "choice", name: "dots", label: "Dots are", standard: "both", choices: [["both", "ink and paper"], ["ink", "ink"], ["paper", "paper, on black"]],
    help: "Ink and paper: black dots where the picture is light, white dots on black where it is dark, so that both come out clear. Pens can draw one of the two only." },
  { kind: "check", name: "antialias", label: "Soft rims", checked: true,
    help: "Pixels that the rim of a dot crosses are grey, as screens like it. Without it each pixel is covered or not, as printers do." },
  { kind: "choice", name: "color", label: "Inks", standard: "gray", choices: [["gray", "one"], ["cmyk", "CMYK: four"], ["rgb", "RGB: light on black"], ["palette", "a palette"]],
    help: "Each ink has dots of its own, which keep away from those of the others." },
  { kind: "palette", name: "palette", label: "Palette", number: 4, colours: ["#0078bf", "#ff48b0", "#ffe800", "#000000", "#00a95c", "#ff6c2f"] },
  { kind: "colour", name: "foreground", label: "Dots' colour", value: "#000000", standard: "#000000" },
  { kind: "colour", name: "background", label: "Background", value: "#ffffff", standard: "#ffffff", transparent: true },
];

export const moreFields = [
  { kind: "numbers", name: "levels", label: "Levels", standard: "0,1,1", numbers: [
    { label: "black point", value: 0, min: 0, max: 1, step: 0.05 }, { label: "white point", value: 1, min: 0, max: 1, step: 0.05 },
    { label: "gamma", value: 1, min: 0.1, max: 10, step: 0.1 }],
    help: "As in editors of pictures: up to the black point all is black, from the white point on white. A gamma above 1 lightens what is between." },
  { kind: "choice", name: "quality", label: "Quality", standard: "standard", choices: [["standard", "standard"], ["draft", "draft: faster"], ["best", "best: slower"]],
    help: "How evenly dots are spread: a draft takes half the time, the best twice as long." },
  { kind: "number", name: "seed", label: "Seed", value: 0, min: 0, max: 100, step: 1, standard: 0,
    help: "Another number gives other dots, as good. The same number gives the same dots again." },
  { kind: "number", name: "width", label: "Width, pixels", value: 1200, min: 100, max: 8000, step: 1, log: true, auto: true,
    help: "Of the result, for screens. auto: the largest that fits into 1,280 by 800, but at least 1,000 along the longer side. Scale and print width make pictures for print instead." },
  { kind: "number", name: "height", label: "Height, pixels", value: 800, min: 100, max: 8000, step: 1, log: true, auto: true,
    help: "Of the result. auto: as the shape of the picture has it." },
  { kind: "choice", name: "fit", label: "Into width and height", standard: "contain", choices: [["contain", "the whole picture"], ["cover", "its middle fills them"]] },
  { kind: "number", name: "scale", label: "Scale", value: 2, min: 0.1, max: 16, log: true, auto: true,
    help: "Pixels of the result to one of the picture, along each side, for print. auto: the width says how large it is." },
  { kind: "number", name: "iterations", label: "Iterations", value: 5, min: 0, max: 50, step: 1, standard: 5,
    help: "Rounds in which dots are evened out. 0 shows them as they begin." },
  { kind: "number", name: "passes", label: "Passes", value: 5, min: 1, max: 20, step: 1, standard: 5,
    help: "How often each dot is moved in a round." },
  { kind: "number", name: "width_mm", label: "Print width, mm", value: 200, min: 20, max: 2000, step: 1, log: true, auto: true, free: "none",
    help: "What files tell programs that print them: resolution in PNG and TIFF, size in SVG." },
  { kind: "choice", name: "style", label: "SVG has", standard: "fill", choices: [["fill", "circles"], ["stroke", "strokes, for plotters"]] },
  { kind: "choice", name: "on_deadline", label: "Out of time", standard: "error", choices: [["error", "refuse"], ["partial", "take what there is"]],
    help: "The server has a limit on how long a request may take." },
];

const most = (sites) => String(Math.min(sites, mostDots));

/** Presets. Each lists the settings that differ from their initial values. */
export const presets = [
  { title: "Newspaper", settings: { sites: most(9000), dots: "ink", foreground: "#1d1b18", background: "#efe9dc" } },
  { title: "Ink and paper", settings: {} },
  { title: "Risograph", settings: { sites: most(24000), color: "palette", palette: "#0078bf,#ff48b0,#ffe800", background: "#fbf8ef" } },
  { title: "Plotter", settings: { sites: "auto", plotter: "on", pen_mm: "1.5" } },
];
