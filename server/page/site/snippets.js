// SPDX-License-Identifier: GPL-3.0-or-later
// Shows the request of the page as code to copy, for curl, HTML, JavaScript and Python, the command and the Python package.

import { hasKey } from "./api.js";
import { make } from "./dom.js";
import { localHalftone, localSample } from "./local_snippets.js";

const shellQuoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;
const query = (options) => {
  const text = new URLSearchParams(options).toString();
  return text && `?${text}`;
};
const authorizations = {
  curl: ' -H "Authorization: Bearer $CCDT_KEY"',
  browser: ", headers: {Authorization: `Bearer ${prompt(\"API key\")}`}",
  node: ", headers: {Authorization: `Bearer ${process.env.CCDT_KEY}`}",
  python: ', headers={"Authorization": "Bearer " + os.environ["CCDT_KEY"]}',
};

/** Returns JavaScript that asks the user for a file. It works in a page and in the console of a browser. */
const choice = (name) => `const ${name} = await new Promise((choose) => {
  const input = Object.assign(document.createElement("input"), {type: "file"});
  input.onchange = () => { choose(input.files[0]); input.remove(); };
  document.body.prepend(input);
});`;

/**
 * Returns the code that reads a file in each language. Files of the server are downloaded. For other files, the browser
 * asks the user, and the other languages read the current folder.
 * @returns  {before, curl, browser, node, python}; `browser` and `node` are lines that define a constant
 */
function sourceOf({ name, path }, constant) {
  if (path) {
    const at = location.origin + path;
    const get = `const ${constant} = await (await fetch("${at}")).blob();\n`;
    return { before: `curl -s ${shellQuoted(at)} |\n  `, curl: "--data-binary @- ", browser: get, node: get, python: `urlopen("${at}").read()` };
  }
  const file = JSON.stringify(name);
  return {
    before: "", curl: `--data-binary ${shellQuoted(`@${name}`)} \\\n  `, browser: `${choice(constant)}\n`,
    node: `import {readFile} from "node:fs/promises";\nconst ${constant} = await readFile(${file});\n`, python: `open(${file}, "rb").read()`,
  };
}

/**
 * Returns the request in each language.
 *
 * @param source  code for the body, from `sourceOf` or `writtenOut`
 * @param body    {name, script}: the Python variable and the JavaScript expression for the body
 * @param result  {output, script, python, imports}: the file that curl writes, the code that reads `answer` in
 *                JavaScript and Python, and the imports of Python
 */
function snippetsOf(url, source, body, { output, script, python, imports = "" }) {
  const allow = (kind) => (hasKey() ? authorizations[kind] : "");
  const inScript = (kind) => `${source[kind]}const answer = await fetch("${url}",
  {method: "POST", body: ${body.script}${allow(kind)}});
if (!answer.ok) throw new Error(await answer.text());
${script}`;
  return {
    curl: `${source.before}curl${allow("curl")} ${source.curl}${shellQuoted(url)} -o ${output}${source.after ?? ""}`,
    Browser: inScript("browser"), Node: inScript("node"),
    Python: `${imports}${hasKey() ? "import os\n" : ""}from urllib.request import Request, urlopen

${body.name} = ${source.python}
request = Request("${url}", ${body.name}${allow("python")})
with urlopen(request) as answer${python}`,
  };
}

/** Returns the code that saves or describes the answer, with the name of the file. */
function toFile(output) {
  const [name] = output.split(".");
  return {
    output,
    script: `const ${name} = await answer.blob();\nconsole.log(${name}.type, ${name}.size);`,
    python: `, open("${output}", "wb") as file:\n    file.write(answer.read())`,
  };
}

/** @param member  member of the answer to print beside the number of points */
const toPoints = (member) => ({
  output: "points.json",
  script: `const {points, ${member}} = await answer.json();\nconsole.log(points.length, ${member});`,
  python: `:\n    result = json.load(answer)\nprint(len(result["points"]), result["${member}"])`,
  imports: "import json\n",
});

function halftoneSnippets({ picture, options, file }) {
  const url = `${location.origin}/halftone${query(options)}`;
  return snippetsOf(url, sourceOf(picture, "picture"), { name: "picture", script: "picture" }, toFile(file));
}

const maxArgument = 100_000;  // characters; Linux allows arguments of 128 KiB

/**
 * Returns the same as `sourceOf` for a body that is part of the code. curl gets the body as an argument or, if it is
 * too long, as a here-document.
 */
const writtenOut = (body) => ({
  ...(body.length > maxArgument
    ? { curl: "--data-binary @- \\\n  ", after: ` <<'END'\n${body}\nEND` }
    : { curl: `-d ${shellQuoted(body)} \\\n  `, after: "" }),
  before: "", browser: "", node: "", python: `r'''${body}'''.encode()`,
});

function sampleSnippets({ path, body, file }, { isMask, isVolume }) {
  const source = file ? sourceOf(file, "shape") : writtenOut(body);
  const inFile = file?.mesh ? "new Blob([shape])" : "shape";  // without a media type, because that of the browser may be wrong
  const script = file ? inFile : `JSON.stringify(${body})`;
  return snippetsOf(location.origin + path, source, { name: "body", script }, isMask ? toFile("mask.png") : toPoints(isVolume ? "seed" : "variation"));
}

export class Snippets {
  #texts = {};
  #kind = "curl";

  constructor(element) {
    const kinds = ["curl", "HTML", "Browser", "Node", "Python", "ccdt", "import ccdt"].map((kind) => {
      const button = make("button", { type: "button", textContent: kind });
      button.addEventListener("click", () => { this.#kind = kind; this.#refresh(); });
      return button;
    });
    const copy = make("button", { type: "button", className: "copy", textContent: "Copy" });
    copy.addEventListener("click", () => this.#copy());
    this.buttons = kinds;
    this.copy = copy;
    this.text = make("pre", { tabIndex: 0, attributes: { role: "region", "aria-label": "The request" } });
    element.append(make("div", { className: "kinds" }, ...kinds, copy), this.text);
  }

  /** Copies the text. Browsers allow this only over HTTPS and on the same machine; otherwise, selects the text. */
  async #copy() {
    getSelection().selectAllChildren(this.text);
    try {
      await navigator.clipboard.writeText(this.text.textContent);
      this.copy.textContent = "Copied";
    } catch {
      this.copy.textContent = "Selected";  // the browser does not permit copying
    }
  }

  #refresh() {
    for (const button of this.buttons) {
      button.setAttribute("aria-pressed", String(button.textContent === this.#kind));
      button.hidden = !(button.textContent in this.#texts);
    }
    this.text.textContent = this.#texts[this.#kind] ?? "";
    this.copy.textContent = "Copy";
  }

  showHalftone(request) {
    this.#texts = { ...halftoneSnippets(request), ...localHalftone(request) };
    this.#refresh();
  }

  showSample(request, kind) {
    this.#texts = { ...sampleSnippets(request, kind), ...localSample(request, kind) };
    this.#refresh();
  }
}
