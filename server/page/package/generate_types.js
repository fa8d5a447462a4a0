// SPDX-License-Identifier: GPL-3.0-or-later
// Prints the types of an OpenAPI document for TypeScript: generate_types.js openapi.json > openapi.d.ts
// Environment variable: CCDT_NODE_MODULES is the folder of npm packages.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { pathToFileURL } from "node:url";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-generator"));
const { default: generate, astToString } = require("openapi-typescript");
const { factory } = require("typescript");

/**
 * Rewrites parts of schemas that openapi-typescript does not support: alternatives that only require members, which it
 * would turn into `unknown`, and tuples whose last items are optional, which it would require.
 */
function simplify(key, value) {
  if (value?.prefixItems?.length > value?.minItems) {
    const { prefixItems: [items], ...others } = value;
    return { ...others, items };
  }
  const isRequirement = (schema) => Object.keys(schema).join() === "required";
  if (!["anyOf", "oneOf"].includes(key) || !value.every(isRequirement)) return value;
  if (key === "anyOf") return undefined;
  return value.map(({ required }) => ({ type: "object", required, properties: Object.fromEntries(required.map((name) => [name, {}])) }));
}

/** Returns TypeScript with Blobs for binary data, and with defaults as optional members. */
export async function generateTypes(file) {
  const document = JSON.parse(await readFile(file, "utf8"), simplify);
  const blob = factory.createTypeReferenceNode("Blob");
  const transform = ({ format }) => (format === "binary" ? blob : undefined);
  return astToString(await generate(document, { transform, defaultNonNullable: false }));
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) process.stdout.write(await generateTypes(process.argv[2]));
