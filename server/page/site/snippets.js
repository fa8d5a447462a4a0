// The request on the page as lines that work elsewhere when pasted.

import { hasKey } from "./api.js";
import { make } from "./dom.js";

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

/** Lets whoever runs it choose a file: anywhere in a page, or pasted into a browser's console. */
const choice = (name) => `const ${name} = await new Promise((choose) => {
  const input = Object.assign(document.createElement("input"), {type: "file"});
  input.onchange = () => { choose(input.files[0]); input.remove(); };
  document.body.prepend(input);
});`;

/** A picture that the server has comes from there, another from the folder that one is in. */
function halftoneSnippets({ picture, options }) {
  const url = `${location.origin}/halftone${query(options)}`;
  const at = picture.path && location.origin + picture.path;
  const allow = (kind) => (hasKey() ? authorizations[kind] : "");
  const output = `dots.${options.format ?? "png"}`;
  const file = JSON.stringify(picture.name);
  const curl = at
    ? `curl -s ${shellQuoted(at)} |\n  curl${allow("curl")} --data-binary @- ${shellQuoted(url)} -o ${output}`
    : `curl${allow("curl")} --data-binary ${shellQuoted(`@${picture.name}`)} \\\n  ${shellQuoted(url)} -o ${output}`;
  const script = (read, kind) => `${read}
const answer = await fetch("${url}",
  {method: "POST", body: picture${allow(kind)}});
if (!answer.ok) throw new Error(await answer.text());
const dots = await answer.blob();
console.log(dots.type, dots.size);`;
  const get = at && `const picture = await (await fetch("${at}")).blob();`;
  const browser = script(get || choice("picture"), "browser");
  const node = script(get || `import {readFile} from "node:fs/promises";\nconst picture = await readFile(${file});`, "node");
  const python = `${hasKey() ? "import os\n" : ""}from urllib.request import Request, urlopen

picture = ${at ? `urlopen("${at}").read()` : `open(${file}, "rb").read()`}
request = Request("${url}", picture${allow("python")})
with urlopen(request) as answer, open("${output}", "wb") as file:
    file.write(answer.read())`;
  return { curl, Browser: browser, Node: node, Python: python };
}

/** The body in each language: a file of the sender's own, or the text itself. */
function sampleBodies({ body, file }) {
  if (file?.path) {
    const at = location.origin + file.path;
    const get = `const shape = await (await fetch("${at}")).text();\n`;
    return {
      before: `curl -s ${shellQuoted(at)} |\n  `, curl: "--data-binary @-", fetch: "shape", python: `urlopen("${at}").read()`,
      browser: get, node: get,
    };
  }
  if (!file) {
    return { curl: `-d ${shellQuoted(body)}`, fetch: `JSON.stringify(${body})`, python: `r'''${body}'''.encode()`,
      browser: "", node: "" };
  }
  const name = JSON.stringify(file.name);
  return {
    curl: `--data-binary ${shellQuoted(`@${file.name}`)}`, fetch: "shape", python: `open(${name}, "rb").read()`,
    browser: `${choice("shape")}\n`, node: `import {readFile} from "node:fs/promises";\nconst shape = await readFile(${name});\n`,
  };
}

function sampleSnippets(request) {
  const url = location.origin + request.path;
  const body = sampleBodies(request);
  const allow = (kind) => (hasKey() ? authorizations[kind] : "");
  const curl = `${body.before ?? ""}curl${allow("curl")} ${body.curl} \\\n  ${shellQuoted(url)} -o points.json`;
  const script = (kind) => `${body[kind]}const answer = await fetch("${url}",
  {method: "POST", body: ${body.fetch}${allow(kind)}});
if (!answer.ok) throw new Error(await answer.text());
const {points, variation} = await answer.json();
console.log(points.length, variation);`;
  const python = `import json
${hasKey() ? "import os\n" : ""}from urllib.request import Request, urlopen

body = ${body.python}
request = Request("${url}", body${allow("python")})
with urlopen(request) as answer:
    result = json.load(answer)
print(len(result["points"]), result["variation"])`;
  return { curl, Browser: script("browser"), Node: script("node"), Python: python };
}

/** Shows one kind of snippet at a time, and copies it. */
export class Snippets {
  #texts = {};
  #kind = "curl";

  constructor(element) {
    const kinds = ["curl", "Browser", "Node", "Python"].map((kind) => {
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

  /** Browsers let pages write to the clipboard only over HTTPS and on the same machine; elsewhere the text is selected. */
  async #copy() {
    getSelection().selectAllChildren(this.text);
    if (!navigator.clipboard) return;
    await navigator.clipboard.writeText(this.text.textContent);
    this.copy.textContent = "Copied";
  }

  #refresh() {
    for (const button of this.buttons) button.setAttribute("aria-pressed", String(button.textContent === this.#kind));
    this.text.textContent = this.#texts[this.#kind] ?? "";
    this.copy.textContent = "Copy";
  }

  showHalftone(request) {
    this.#texts = halftoneSnippets(request);
    this.#refresh();
  }

  showSample(request) {
    this.#texts = sampleSnippets(request);
    this.#refresh();
  }
}
