// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the request of the page as a command line of `ccdt`, as a call of the Python package, and as an element in HTML.

const shellQuoted = (text) => (/^[\w.,:/-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
const quoted = (text) => JSON.stringify(text);
const onlyOfServices = ["on_deadline", "mesh"];  // options that a call does not have

/** Returns a value of JSON in Python. */
function literal(value) {
  if (value === null) return "None";
  if (typeof value === "boolean") return value ? "True" : "False";
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value !== "object") return JSON.stringify(value);
  return `{${Object.entries(value).map(([name, one]) => `${quoted(name)}: ${literal(one)}`).join(", ")}}`;
}

const keywords = (options) => Object.entries(options).filter(([name]) => !onlyOfServices.includes(name))
  .map(([name, value]) => `, ${name}=${literal(value)}`).join("");

function command(name, input, options, output) {
  const words = Object.entries(options).map(([option, value]) => ` --${option.replaceAll("_", "-")}=${shellQuoted(typeof value === "object" ? JSON.stringify(value) : String(value))}`);
  return `ccdt ${name}${input && ` ${shellQuoted(input)}`}${words.join("")} -o ${output}`;
}

/** Returns a file in both languages. Files of the server are downloaded: {before, imports, name, content}. */
function inputOf({ name, path, text }) {
  if (!path) return { before: "", imports: "", name, content: quoted(name) };
  const at = location.origin + path;
  const answer = `urlopen(${quoted(at)})`;
  return { before: `curl -sO ${shellQuoted(at)}\n`, imports: `${text ? "import json\n" : ""}from urllib.request import urlopen\n`,
    name, content: text ? `json.load(${answer})` : `${answer}.read()` };
}

/** Options of /halftone that `<ccdt-halftone>` does not have, because they are for files, prints and plotters. */
const onlyOfFiles = ["format", "width_mm", "style", "pen", "minutes", "speed", "dwell", "spot", "rotate", "bit_order", "invert_bits", "on_deadline"];

const escaped = (text) => String(text).replaceAll("&", "&amp;").replaceAll('"', "&quot;");

function elementOf({ name, path }, options) {
  const address = path ? location.origin + path : name;
  const attributes = Object.entries({ src: address, ...options, alt: "" }).filter(([option]) => !onlyOfFiles.includes(option));
  const missing = onlyOfFiles.filter((option) => option in options);
  return `${missing.length > 0 ? `<!-- without ${missing.join(", ")}, which the element does not have -->\n` : ""}<script type="module" src=${quoted(`${location.origin}/assets/element.js`)}></script>
<ccdt-halftone${attributes.map(([option, value]) => ` ${option}="${escaped(value)}"`).join("")}></ccdt-halftone>`;
}

export function localHalftone({ picture, options, file }) {
  const { before, imports, name, content } = inputOf(picture);
  return {
    HTML: elementOf(picture, options),
    ccdt: before + command("halftone", name, options, file),
    "import ccdt": `${imports}import ccdt\n\nccdt.halftone(${content}${keywords(options)}).save(${quoted(file)})`,
  };
}

/** Returns the area of a request in Python. */
function areaOf({ polygon, geometry, domain }, content) {
  const { type, width, height, depth } = domain ?? {};
  const sides = [width, height, depth].filter((side) => side !== undefined).join(", ");
  if (domain === "solid") return `ccdt.Solid(${content})`;
  if (type) return `ccdt.${type[0].toUpperCase()}${type.slice(1)}(${sides})`;
  return content ?? literal(polygon ?? geometry);
}

/**
 * @param options  members of the request, without the file
 * @param file     the file of the request, if there is one
 */
export function localSample({ options, file }, { isMask }) {
  const { before, imports, name, content } = file ? inputOf(file) : { before: "", imports: "" };
  const { polygon, geometry, domain, sites, format, ...others } = options;
  const output = isMask ? "mask.png" : "points.csv";
  const whole = file ? { ...options, ...(domain?.type && { domain: domain.type, ...Object.fromEntries(Object.entries(domain).slice(1)) }) } : options;
  const shell = before + command("sample", name ?? "", whole, output);
  if (isMask) {
    const bits = format === "mask16" ? ", bits=16" : "";
    return { ccdt: shell, "import ccdt": `import ccdt\n\nmask = ccdt.mask(${domain.width}, ${domain.height}${keywords({ ...(others.seed && { seed: others.seed }) })}${bits})` };
  }
  const density = file?.voxels ? `, density=numpy.load(${content})` : "";
  const number = sites === undefined ? "" : `, ${literal(sites)}`;
  return {
    ccdt: shell,
    "import ccdt": `${imports}${density && "import numpy\n"}import ccdt\n\npoints = ccdt.sample(${areaOf(options, content)}${number}${keywords(others)}${density})\npoints.save("points.csv")`,
  };
}
