// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for the options of /halftone with `device`: labels, initial values and help texts.

import { capabilities } from "./api.js";
import { fields as halftoneFields, gravity, moreFields as moreHalftoneFields } from "./halftone_options.js";
import { printFields } from "./print_options.js";

const shared = (name) => [...printFields, ...moreHalftoneFields, ...halftoneFields].find((field) => field.name === name);

const { types, formats } = capabilities.halftone.devices;
export { formats, types };

export const fields = [
  { kind: "choice", name: "device", label: "Device", choices: types.map(({ name, title }) => [name, title]),
    help: "Panels show other colours than the pure ones that are sent to them: their white is grey, and their red is dark. The pixels are chosen by the colours that were measured on panels, and files have the pure colours." },
  { kind: "palette", name: "palette", label: "Palette", item: "colour", least: 2, number: 4,
    colours: ["#000000", "#ffffff", "#ff0000", "#ffff00", "#0000ff", "#00ff00", "#ff8000", "#00ffff", "#ff00ff", "#808080", "#404040", "#c0c0c0", "#800000", "#008000", "#000080", "#808000"],
    help: "Colours of the device, in the order of the values of pixels." },
  { kind: "number", name: "width", label: "Width, px", value: 800, min: 8, max: 4000, step: 1, log: true, auto: false,
    help: "auto: the width that keeps the aspect ratio. If the height is auto, too, the result has the pixels of the picture." },
  { kind: "number", name: "height", label: "Height, px", value: 480, min: 8, max: 4000, step: 1, log: true, auto: false,
    help: "auto: the height that keeps the aspect ratio." },
  { kind: "choice", name: "fit", label: "Fit", standard: "contain", choices: [["cover", "cut to fill"], ["contain", "whole picture"]] },
  gravity,
  { kind: "choice", name: "rotate", label: "Turn clockwise", standard: "0", choices: [["0", "no"], ["90", "90\u00b0"], ["180", "180\u00b0"], ["270", "270\u00b0"]],
    help: "The picture is turned before it is fitted." },
  { kind: "colour", name: "background", label: "Background", value: "#ffffff", standard: "#ffffff",
    help: "Colour around the picture and behind its transparent pixels." },
  shared("levels"),
  { kind: "choice", name: "format", label: "Format", standard: "png", choices: formats.map(({ name, title }) => [name, title]),
    help: "Packed pixels have no header: 1, 2 or 4 bits per pixel, from the top row, and each row begins with a new byte. ESC/POS has the commands for receipt and label printers, which have two colours." },
  { kind: "choice", name: "bit_order", label: "Leftmost pixel", standard: "msb", choices: [["msb", "in the highest bits"], ["lsb", "in the lowest bits"]] },
  { kind: "check", name: "invert_bits", label: "Invert all bits", standard: false },
];

export const moreFields = [
  shared("alpha"),
  { kind: "number", name: "spot", label: "Printed spot, px", value: 1.5, min: 1, max: 2, step: 0.05, auto: true, free: "none",
    help: "Diameter of the round spot that a printer makes for a dark pixel. Spots overlap; with this option, the print still has the tones of the picture." },
  { ...shared("width_mm"), help: "Sets the resolution of the file." },
  shared("on_deadline"),
];

/** Fields of the preview only. */
export const viewFields = [
  { kind: "check", name: "seen", label: "As seen", checked: true },
  { kind: "check", name: "compare", label: "Compare", standard: false },
  { kind: "choice", name: "zoom", label: "Zoom", standard: "fit", choices: [["fit", "fit"], ...[1, 2, 4, 8].map((factor) => [String(factor), `${factor} \u00d7`])] },
];

/** Presets. Each lists the settings that differ from their initial values. */
export const presets = [
  { title: "TRMNL 800\u00a0\u00d7\u00a0480", settings: {} },
  { title: "Spectra\u00a06 800\u00a0\u00d7\u00a0480", settings: { device: "spectra6" } },
  { title: "LED panel 64\u00a0\u00d7\u00a032", settings: { device: "custom", palette: "#000000,#ff0000,#ffff00,#00ff00,#00ffff,#0000ff,#ff00ff,#ffffff", width: "64", height: "32", background: "#000000" } },
  { title: "58 mm label printer", settings: { width: "384", height: "auto", format: "escpos" } },
];
