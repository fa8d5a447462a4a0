// SPDX-License-Identifier: GPL-3.0-or-later
// The element <ccdt-halftone> of the package, which computes in the browser unless it has a server.

import { HalftoneElement } from "./halftone_element.js";

const { loadEngine } = HalftoneElement;
HalftoneElement.loadEngine = (engine, server) => (engine || server ? loadEngine(engine) : import("./engine.js"));

export { HalftoneElement };
