// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for the options of drawings for print: paper, files and resolution. Each option belongs to some formats only.

const ofShapes = ["svg", "pdf", "eps", "hpgl", "gcode", "dxf"];
const formatsOf = {
  ...Object.fromEntries(["paper", "margin", "marks", "split"].map((name) => [name, ofShapes])),
  dpi: ["png", "webp", "jpeg", "tiff"],
  jpeg_quality: ["jpeg"],
};

/** Sides of papers in mm. */
export const papers = {
  a4: [210, 297], a6: [105, 148], a5: [148, 210], a3: [297, 420], a2: [420, 594], a1: [594, 841], a0: [841, 1189],
  letter: [215.9, 279.4], legal: [215.9, 355.6], tabloid: [279.4, 431.8],
};
export const paperChoices = Object.keys(papers).map((name) => [name, name.length === 2 ? name.toUpperCase() : name]);

export const marksField = { kind: "check", name: "marks", label: "Registration marks", standard: false,
  help: "Each ink also draws four crosses in the margin, by which several inks are aligned. The margin must be at least 4 mm." };

export const printFields = [
  { kind: "number", name: "width_mm", label: "Print width, mm", value: 200, min: 20, max: 2000, step: 1, log: true, auto: true, free: "none",
    help: "The width at which other programs print the file. Sets the resolution of PNG and TIFF, and the size and unit of SVG. PDF and EPS need it, or a paper." },
  { kind: "number", name: "dpi", label: "Pixels per inch", value: 300, min: 72, max: 1200, step: 1, log: true, auto: true,
    help: "For files of pixels. Together with the print width, it decides the number of pixels." },
  { kind: "choice", name: "paper", label: "Paper", standard: "none", choices: [["none", "none"], ...paperChoices],
    help: "For SVG, PDF and EPS: the page is as large as the paper. The drawing lies in the middle, as large as the margins allow, or as wide as the print width." },
  { kind: "number", name: "margin", label: "Minimum margin, mm", value: 10, min: 0, max: 50, step: 1, standard: 10 },
  marksField,
  { kind: "choice", name: "split", label: "Files", standard: "one", choices: [["one", "one"], ["ink", "one for each ink"]],
    help: "For SVG, PDF and EPS. Several files are saved in one ZIP file." },
  { kind: "number", name: "jpeg_quality", label: "JPEG quality", value: 90, min: 1, max: 100, step: 1, standard: 90 },
];

/** Returns the options that a format has. Without a format, all options of print are left out, except the width. */
export const suited = (options, format) =>
  Object.fromEntries(Object.entries(options).filter(([name]) => formatsOf[name]?.includes(format) ?? true));

/**
 * Offers the fields that have a meaning.
 * @param hasWidth   whether the drawing has a width in mm
 * @param isPlotted  whether a pen draws, which has its own paper
 */
export function offerPrint(fields, { hasWidth, isPlotted }) {
  for (const name of ["paper", "split"]) fields.offer(name, !isPlotted);
  const isOnPaper = !isPlotted && fields.values().paper !== undefined;
  for (const name of ["margin", "marks"]) fields.offer(name, isOnPaper);
  fields.offer("dpi", !isPlotted && hasWidth);
}
