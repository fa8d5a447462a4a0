// api/openapi.json, as a public validator sees it: Redocly's, by its recommended rules.

import assert from "node:assert/strict";
import { createRequire } from "node:module";
import path from "node:path";
import { test } from "node:test";

const require = createRequire(path.join(process.env.CCDT_NODE_MODULES, "of-the-tests"));
const { createConfig, lint } = require("@redocly/openapi-core");

// A server has the address that whoever runs it gives it.
const unwanted = { "no-server-example.com": "off" };

test("the document is valid, and has nothing that is not used", async () => {
  const here = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
  const config = await createConfig({ extends: ["recommended"], rules: unwanted });
  const problems = await lint({ ref: path.resolve(here, "../../api/openapi.json"), config });
  assert.deepEqual(problems.map(({ ruleId, message, location }) => [ruleId, message, location[0]?.pointer]), []);
});
