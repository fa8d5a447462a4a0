// SPDX-License-Identifier: GPL-3.0-or-later
// Runs ccdt.wasm in browsers and in Node.js. README.md describes its use.

/** Texts of an answer, in the order of their numbers in module.cpp. */
const textNumbers = { body: 0, type: 1, warnings: 2, repaired: 3, problem: 4 };

const operations = { halftone: 0, sample: 1, analyze: 2 };

/** A refused request. `problem` is the body of the service's answer, application/problem+json. */
export class Refusal extends Error {
  /** @param {{ status: number, detail: string, errors?: { pointer: string, detail: string }[] }} problem */
  constructor(problem) {
    super(problem.detail);
    this.name = "Refusal";
    this.status = problem.status;
    this.problem = problem;
  }
}

/** Answers requests one after the other. Replaces an instance that has failed: its memory cannot be trusted. */
export class Engine {
  #module;
  /** @type {any} */
  #exports = null;
  /** @type {((share: number) => boolean | void) | undefined} */
  #progress;

  /** @param {WebAssembly.Module} module  compiled ccdt.wasm */
  constructor(module) {
    this.#module = module;
  }

  /**
   * Answers a request. Throws a Refusal for an invalid request, and another error if the instance fails.
   * @param {"halftone" | "sample" | "analyze"} operation
   * @param {Uint8Array} body  as it is sent to the service; pictures must be BMP
   * @param {object} [request]
   * @param {Iterable<[string, string]>} [request.options]  as in the query of a URL
   * @param {string} [request.type]  media type of the body
   * @param {number} [request.seconds]  returns null if the estimated time is longer
   * @param {(share: number) => boolean | void} [request.progress]  receives the completed share; true stops the work
   * @returns {{ type: string, body: Uint8Array<ArrayBuffer>, warnings: string, repaired: string, partial: boolean } | null}
   */
  answer(operation, body, { options = [], type = "", seconds = Infinity, progress } = {}) {
    this.#exports ??= this.#start();
    this.#progress = progress;
    try {
      return this.#compute(operation, body, ["", type, ...[...options].flat()], seconds);
    } catch (error) {
      if (!(error instanceof Refusal)) this.#exports = null;
      throw error;
    }
  }

  /**
   * @param {keyof typeof operations} operation
   * @param {Uint8Array} body
   * @param {string[]} texts
   * @param {number} seconds
   */
  #compute(operation, body, texts, seconds) {
    const exports = this.#exports;
    this.#store(exports.reserve_body, body);
    this.#store(exports.reserve_texts, new TextEncoder().encode(texts.map((text) => `${text}\0`).join("")));
    this.#check(exports.parse(operations[operation]));
    if (exports.seconds() > seconds) return null;
    this.#check(exports.run());
    const text = (/** @type {keyof typeof textNumbers} */ name) => new TextDecoder().decode(this.#bytes(name));
    return {
      type: text("type"), body: Uint8Array.from(this.#bytes("body")), warnings: text("warnings"), repaired: text("repaired"),
      partial: Boolean(exports.is_partial()),
    };
  }

  /** @param {number} isValid  1, or 0 after an error */
  #check(isValid) {
    if (!isValid) throw new Refusal(JSON.parse(new TextDecoder().decode(this.#bytes("problem"))));
  }

  /**
   * @param {(size: number) => number} reserve
   * @param {Uint8Array} bytes
   */
  #store(reserve, bytes) {
    const address = reserve(bytes.length);
    new Uint8Array(this.#exports.memory.buffer).set(bytes, address);
  }

  /** @param {keyof typeof textNumbers} name */
  #bytes(name) {
    const { memory, text, text_size: sizeOf } = this.#exports;
    return new Uint8Array(memory.buffer, text(textNumbers[name]), sizeOf(textNumbers[name]));
  }

  #start() {
    this.#exports = new WebAssembly.Instance(this.#module, this.#imports()).exports;
    this.#exports._initialize();
    return this.#exports;
  }

  /** Returns the functions that the module calls. Of the system's functions, only the clock does anything. */
  #imports() {
    const unavailable = 52;  // ENOSYS
    /** @type {Record<string, Record<string, any>>} */
    const imports = { ccdt: { progress: (/** @type {number} */ share) => (this.#progress?.(share) ? 1 : 0) } };
    for (const { module, name } of WebAssembly.Module.imports(this.#module)) {
      imports[module] ??= {};
      imports[module][name] ??= () => unavailable;
    }
    const system = imports.wasi_snapshot_preview1 ?? {};
    system.clock_time_get = (/** @type {number} */ clock, /** @type {bigint} */ precision, /** @type {number} */ address) => {
      const time = BigInt(Math.round(1e6 * performance.now()));
      new DataView(this.#exports.memory.buffer).setBigUint64(address, time, true);
      return 0;
    };
    system.proc_exit = (/** @type {number} */ code) => {
      throw new Error(`the module ended with ${code}`);
    };
    return imports;
  }
}

/**
 * Writes pixels as BMP, for answer().
 * @param {{ width: number, height: number, data: ArrayLike<number> }} image  as ImageData: red, green, blue, alpha
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function bitmapOf({ width, height, data }) {
  const head = 122;  // of the file and of BITMAPV4HEADER
  const bytes = new Uint8Array(head + 4 * width * height);
  const view = new DataView(bytes.buffer);
  const write = (/** @type {number} */ place, /** @type {number[]} */ ...words) => words.forEach((word, i) => view.setUint32(place + 4 * i, word, true));
  view.setUint16(0, 0x4d42, true);
  write(2, bytes.length, 0, head);
  write(14, 108, width, -height >>> 0);
  view.setUint16(26, 1, true);
  view.setUint16(28, 32, true);
  write(30, 3, 4 * width * height, 2835, 2835, 0, 0);  // bit fields, 72 dpi
  write(54, 0xff, 0xff00, 0xff0000, 0xff000000, 0x73524742);  // fields of red, green, blue and alpha; sRGB
  bytes.set(data, head);
  return bytes;
}
