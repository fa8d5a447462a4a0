// SPDX-License-Identifier: GPL-3.0-or-later
// Shows the reference of the API, generated from the OpenAPI document of the server.

import { make } from "./dom.js";

const main = document.querySelector("main");

/** Merges a node of the document with the node that its `$ref` names. Members of the node itself take precedence. */
function resolve(whole, { $ref: reference, ...own }) {
  if (!reference) return own;
  const found = reference.slice(2).split("/").reduce((place, name) => place[name], whole);
  return { ...resolve(whole, found), ...own };
}

function rangeOf({ minimum, exclusiveMinimum, maximum }) {
  const from = minimum ?? exclusiveMinimum;
  if (from === undefined) return "";
  const least = minimum === undefined ? `above ${from}` : `${from}`;
  if (maximum === undefined) return minimum === undefined ? least : `from ${least}`;
  return minimum === undefined ? `${least}, up to ${maximum}` : `${least} to ${maximum}`;
}

/** Describes the values that a schema allows. */
function valuesOf(whole, node) {
  const schema = resolve(whole, node);
  if (schema.anyOf) return schema.anyOf.map((part) => valuesOf(whole, part)).join(" or ");
  if (schema.const !== undefined) return String(schema.const);
  if (schema.enum) return schema.enum.join(", ");
  if (schema.oneOf) return schema.oneOf.map((part) => valuesOf(whole, part)).join(" or ");
  return [schema.type, schema.pattern, rangeOf(schema)].filter(Boolean).join(" ");
}

/** Returns the members of a schema and of the schemas in its `allOf`. */
function membersOf(whole, node) {
  const schema = resolve(whole, node);
  const included = (schema.allOf ?? []).flatMap((part) => membersOf(whole, part));
  return [...included, ...Object.entries(schema.properties ?? {}).map(([name, part]) => [name, part, schema.required])];
}

/** Splits a text into plain texts and code elements at backticks. */
const prose = (text) => text.split("`").map((part, i) => (i % 2 ? make("code", { textContent: part }) : part));

/** Creates a table. Roles are explicit, because style sheets for narrow screens display cells as blocks. */
function table(label, titles, rows) {
  const row = (...cells) => make("tr", { role: "row" }, ...cells);
  const head = row(...titles.map((textContent) => make("th", { scope: "col", role: "columnheader", textContent })));
  const lines = rows.map(([name, ...cells]) => row(
    make("th", { scope: "row", role: "rowheader" }, make("code", { textContent: name })),
    ...cells.map((text, i) => make("td", { role: "cell", attributes: text ? { "data-title": titles[i + 1] } : {} }, ...prose(text)))));
  const group = (tag, ...all) => make(tag, { role: "rowgroup" }, ...all);
  return make("div", { className: "table-frame", tabIndex: 0, attributes: { role: "region", "aria-label": label } },
    make("table", { role: "table" }, group("thead", head), group("tbody", ...lines)));
}

/** Returns a table of members for each alternative form of a body. */
function tablesOf(whole, content, title) {
  const forms = (content.schema.anyOf ?? [content.schema]).map((form) => [form.$ref?.split("/").pop(), membersOf(whole, form)]);
  return forms.filter(([, members]) => members.length > 0).map(([name, members], i) => {
    const rows = members.map(([member, part, required]) => {
      const schema = resolve(whole, part);
      const fallback = schema.default === undefined ? "" : JSON.stringify(schema.default).replaceAll('"', "");
      return [member, valuesOf(whole, part), required?.includes(member) ? "required" : fallback, schema.description ?? ""];
    });
    return table(`Members for ${title}${i > 0 ? `: ${name}` : ""}`, ["member", "values", "default", "meaning"], rows);
  });
}

function examplesOf(content, path) {
  return Object.values(content.examples ?? {}).map(({ summary, value }) => make("details", {},
    make("summary", { textContent: summary }),
    make("pre", { textContent: `curl -H 'Content-Type: application/json' ${location.origin}${path} -d '${JSON.stringify(value)}'` })));
}

function sectionOf(whole, path, method, operation) {
  const title = `${method.toUpperCase()} ${path}`;
  const content = operation.requestBody?.content["application/json"];
  const statuses = Object.entries(operation.responses).map(([status, response]) => {
    const { description, content: types = {} } = resolve(whole, response);
    return [status, description, Object.keys(types).join(", ")];
  });
  return make("section", {},
    make("h2", { textContent: title }),
    make("p", {}, ...prose([operation.summary, operation.description].filter(Boolean).join(". "))),
    ...(content ? [...tablesOf(whole, content, title), ...examplesOf(content, path)] : []),
    table(`Answers of ${title}`, ["status", "when", "as"], statuses));
}

try {
  const whole = await (await fetch("/openapi.json")).json();
  document.querySelector(".lead").append(...prose(whole.info.description));
  for (const [path, { parameters, ...operations }] of Object.entries(whole.paths)) {
    for (const [method, operation] of Object.entries(operations)) main.append(sectionOf(whole, path, method, operation));
  }
} catch {
  document.querySelector(".error").textContent = "The description of the API cannot be read";
}
main.dataset.state = "done";
