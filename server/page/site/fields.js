// SPDX-License-Identifier: GPL-3.0-or-later
// Labelled inputs for the options of a request, with help texts and the error messages of the server.

import { make } from "./dom.js";
import { namedInks, nameOf } from "./named_inks.js";

let made = 0;

/**
 * Creates a slider and a number input. Numbers outside the range of the slider can be typed; the server validates them.
 */
function numberInputs(field, id) {
  const number = make("input", { id, type: "number", value: field.value, step: field.step ?? "any" });
  const toSlider = field.log ? Math.log : (x) => x;
  const fromSlider = field.log ? (x) => Number(Math.exp(x).toPrecision(3)) : (x) => x;
  const slider = make("input", {
    type: "range", min: toSlider(field.min), max: toSlider(field.max), step: field.log ? 0.01 : field.step,
    attributes: { "aria-label": `${field.label}, slider` },
  });
  const announce = () => slider.setAttribute("aria-valuetext", Number(number.value).toLocaleString("en"));
  const put = (value) => {
    number.value = value;
    slider.value = toSlider(value);
    announce();
  };
  const rounded = (value) => (field.step === 1 ? Math.round(value) : Math.round(value * 100) / 100);
  slider.addEventListener("input", () => { number.value = rounded(fromSlider(Number(slider.value))); announce(); });
  number.addEventListener("input", () => { slider.value = toSlider(Number(number.value)); announce(); });
  put(field.value);
  const limit = (most) => { slider.max = toSlider(Math.min(field.max, most)); };
  return { number, slider, all: [number, slider], put, limit };
}

/**
 * Creates a field for a number. With `field.auto`, it has a checkbox, labelled `field.free`, by which the user leaves
 * the number to the server. Then the field is empty until `tell` shows the number of the server.
 */
function numberField(field, id, change) {
  const { number, slider, all, put: putNumber, limit } = numberInputs(field, id);
  const entry = make("div", { className: "entry" });
  const auto = field.auto !== undefined && make("input", { type: "checkbox", checked: field.auto });
  const unit = field.units && make("select", { attributes: { "aria-label": `${field.label}, unit` } },
    ...field.units.map(([value, text]) => new Option(text, value)));
  const settle = () => {
    for (const input of [...all, ...(unit ? [unit] : [])]) input.disabled = auto && auto.checked;
    if (auto?.checked) number.value = "";
    else if (auto && number.value === "") putNumber(field.value);
  };
  const tell = (told) => {
    if (auto?.checked && told !== undefined) putNumber(told);
  };
  if (auto) {
    entry.append(make("label", {}, auto, field.free ?? "auto"));
    auto.addEventListener("change", () => { settle(); change(false); });
  }
  settle();
  entry.append(number);
  if (unit) {
    entry.append(unit);
    unit.addEventListener("change", () => change(false));
  }
  slider.addEventListener("input", () => change(true));
  slider.addEventListener("change", () => change(false));
  number.addEventListener("change", () => change(false));
  const value = () => {
    if (auto && auto.checked) return undefined;
    if (number.value === "") return "";
    return unit && unit.value ? Number(number.value) + unit.value : Number(number.value);
  };
  const put = (text) => {
    const ending = (field.units ?? []).map(([name]) => name).find((name) => name && text.endsWith(name)) ?? "";
    const digits = text.slice(0, text.length - ending.length);
    const isNumber = digits !== "" && Number.isFinite(Number(digits));
    if (isNumber) putNumber(Number(digits));
    if (isNumber && unit) unit.value = ending;
    if (auto && (isNumber || text === "auto")) auto.checked = !isNumber;
    settle();
  };
  const say = (text) => (text === "auto" ? field.free ?? "auto" : text);
  return { input: number, parts: [entry, slider], value, text: () => String(value() ?? "auto"), put, limit, tell, say };
}

/** Creates number inputs side by side, each with its own label. The value joins the numbers with commas. */
function numbersField(field, id, change) {
  const inputs = field.numbers.map(({ value, min, max, step }, index) =>
    make("input", { id: index === 0 ? id : `${id}-${index}`, type: "number", value, min, max, step }));
  for (const input of inputs) input.addEventListener("change", () => change(false));
  const place = make("div", { className: "numbers", attributes: { role: "group", "aria-label": field.label } },
    ...inputs.map((input, index) => make("label", {}, input, field.numbers[index].label)));
  const value = () => inputs.map((input) => (input.value === "" ? "" : Number(input.value))).join(",");
  const put = (text) => text.split(",").slice(0, inputs.length).forEach((one, i) => { inputs[i].value = one; });
  return { input: inputs[0], parts: [place], value, text: value, put };
}

/**
 * Creates number inputs for levels, and two sliders for the same numbers: brightness for gamma, and contrast for the
 * distance between the points. A button asks the panel for levels, by the event `autolevels`.
 */
function levelsField(field, id, change) {
  const numbers = numbersField(field, id, (draft) => { settle(); change(draft); });
  const slider = (label, min, max, put) => {
    const input = make("input", { type: "range", min, max, step: 0.01 });
    input.addEventListener("input", () => { put(Number(input.value)); settle(); change(true); });
    input.addEventListener("change", () => change(false));
    return { input, place: make("label", { className: "scale" }, make("span", { textContent: label }), input) };
  };
  const levels = () => numbers.value().split(",").map(Number);
  const rounded = (value) => Number(value.toFixed(2));
  const brightness = slider("Brightness", -1, 1, (value) => {
    const [black, white] = levels();
    numbers.put(`${black},${white},${rounded(3 ** value)}`);
  });
  const contrast = slider("Contrast", 0, 0.9, (value) => {
    const [black, white, gamma] = levels();
    const start = Math.min(Math.max((black + white - 1 + value) / 2, 0), value);
    numbers.put(`${rounded(start)},${rounded(start + 1 - value)},${gamma}`);
  });
  const settle = () => {
    const [black, white, gamma] = levels();
    brightness.input.value = Math.log(gamma) / Math.log(3);
    contrast.input.value = 1 - white + black;
    brightness.input.setAttribute("aria-valuetext", `gamma ${gamma}`);
    contrast.input.setAttribute("aria-valuetext", `from ${black} to ${white}`);
  };
  const auto = make("button", { type: "button", textContent: "Auto", attributes: { "aria-label": "Auto levels" } });
  auto.addEventListener("click", () => auto.dispatchEvent(new CustomEvent("autolevels", { bubbles: true })));
  settle();
  const put = (text) => { numbers.put(text); settle(); };
  return { ...numbers, parts: [auto, brightness.place, contrast.place, ...numbers.parts], put };
}

function choiceField(field, id, change) {
  const select = make("select", { id }, ...field.choices.map(([value, text]) => new Option(text, value)));
  select.addEventListener("change", () => change(false));
  const value = () => select.value;
  const put = (text) => { if (field.choices.some(([name]) => name === text)) select.value = text; };
  const allow = (name, allowed) => {
    const option = [...select.options].find((one) => one.value === name);
    option.disabled = option.hidden = !allowed;
    if (!allowed && select.value === name) select.value = field.standard;
  };
  const say = (text) => field.choices.find(([name]) => name === text)?.[1] ?? text;
  return { input: select, parts: [select], value, text: value, put, allow, say };
}

function checkField(field, id, change) {
  const box = make("input", { id, type: "checkbox", checked: field.checked ?? false });
  box.addEventListener("change", () => change(false));
  return { input: box, parts: [box], value: () => box.checked, text: () => String(box.checked), put: (text) => { box.checked = text === "true"; }, say: (text) => (text === "true" ? "yes" : "no") };
}

/** Creates checkboxes, of which `field.checked` lists those checked at first. The value lists the checked ones. */
function severalField(field, id, change) {
  const boxes = field.choices.map(([value, text], index) => {
    const box = make("input", { type: "checkbox", value, checked: field.checked.includes(value), ...(index === 0 && { id }) });
    box.addEventListener("change", () => change(false));
    return { box, label: make("label", {}, box, text) };
  });
  const place = make("div", { className: "several", attributes: { role: "group", "aria-label": field.label } },
    ...boxes.map(({ label }) => label));
  const value = () => boxes.filter(({ box }) => box.checked).map(({ box }) => box.value);
  const put = (text) => boxes.forEach(({ box }) => { box.checked = text.split(",").includes(box.value); });
  return { input: boxes[0].box, parts: [place], value, text: () => value().join(","), put };
}

const isColour = (text) => /^#[0-9a-f]{6}$/.test(text);

function colourField(field, id, change) {
  const well = make("input", { id, type: "color", value: field.value });
  const entry = make("div", { className: "entry" });
  const none = field.transparent && make("input", { type: "checkbox" });
  if (none) entry.append(make("label", {}, none, "transparent"));
  none?.addEventListener("change", () => { well.disabled = none.checked; change(false); });
  entry.append(well);
  well.addEventListener("input", () => change(true));
  well.addEventListener("change", () => change(false));
  const value = () => (none?.checked ? "transparent" : well.value);
  const put = (text) => {
    if (isColour(text)) well.value = text;
    if (none) none.checked = well.disabled = text === "transparent";
  };
  return { input: well, parts: [entry], value, text: value, put };
}

/**
 * Creates colour inputs: at least `field.least`, and at most as many as `field.colours` has colours. Initially, there is
 * one for each of the first `field.number` colours. `field.item` is the word for what has a colour. With `field.isNamed`,
 * a menu adds inks by name; if there are as many as possible, the last one is replaced.
 */
function paletteField(field, id, change) {
  const { item, least } = field;
  const wells = [];
  const place = make("div", { className: "wells", attributes: { role: "group", "aria-label": field.label } });
  const more = make("button", { type: "button", textContent: "Add", attributes: { "aria-label": `Add another ${item}` } });
  const settle = () => {
    more.disabled = wells.length === field.colours.length;
    place.classList.toggle("fewest", wells.length === least);
    names.textContent = wells.map((well) => nameOf(well.value)).join(", ");
  };
  const names = make("p", { className: "hint", hidden: !field.isNamed });
  const menu = field.isNamed && make("select", { attributes: { "aria-label": "Add an ink by name" } }, new Option("By name", ""),
    ...namedInks.map(([name, colour]) => new Option(name, colour)));
  if (menu) menu.addEventListener("change", () => {
    if (wells.length < field.colours.length) add(menu.value);
    else wells.at(-1).value = menu.value;
    menu.value = "";
    settle();
    change(false);
  });
  const remove = (index) => {
    for (let i = index; i + 1 < wells.length; ++i) wells[i].value = wells[i + 1].value;
    wells.pop().parentElement.remove();
    settle();
    more.focus();
    change(false);
  };
  const add = (value) => {
    const index = wells.length;
    const well = make("input", { type: "color", value, attributes: { "aria-label": `${item[0].toUpperCase()}${item.slice(1)} ${index + 1}` } });
    if (index === 0) well.id = id;
    const less = make("button", { type: "button", textContent: "\u00d7", attributes: { "aria-label": `Remove ${item} ${index + 1}` } });
    well.addEventListener("input", () => { settle(); change(true); });
    well.addEventListener("change", () => change(false));
    less.addEventListener("click", () => remove(index));
    wells.push(well);
    more.before(make("span", {}, well, less));
    settle();
  };
  more.addEventListener("click", () => {
    add(field.colours.find((colour) => wells.every(({ value }) => value !== colour)));
    change(false);
  });
  place.append(more, ...(menu ? [menu] : []));
  field.colours.slice(0, field.number).forEach(add);
  const value = () => wells.map((well) => well.value).join(",");
  const put = (text) => {
    const colours = text.split(",").filter(isColour).slice(0, field.colours.length);
    if (colours.length < least) return;
    while (wells.length > colours.length) wells.pop().parentElement.remove();
    colours.forEach((colour, i) => { if (i < wells.length) wells[i].value = colour; else add(colour); });
    settle();
  };
  const say = (text) => text.split(",").map(nameOf).join(", ");
  return { input: wells[0], parts: [place, names], value, text: value, put, say };
}

/** Creates an input for a line of text. Requests omit an empty one. */
function textField(field, id, change) {
  const input = make("input", { id, type: "text", value: field.value ?? "", spellcheck: false, autocomplete: "off" });
  input.addEventListener("change", () => change(false));
  return { input, parts: [input], value: () => input.value || undefined, text: () => input.value, put: (text) => { input.value = text; } };
}

/** Creates a text area for JSON. A text that is not JSON is sent as a string, which the server rejects. */
function jsonField(field, id, change) {
  const area = make("textarea", { id, rows: 2, spellcheck: false });
  area.addEventListener("change", () => change(false));
  const value = () => {
    if (area.value.trim() === "") return undefined;
    try {
      return JSON.parse(area.value);
    } catch {
      return area.value;
    }
  };
  return { input: area, parts: [area], value, text: () => area.value, put: (text) => { area.value = text; } };
}

/** Creates an input for a picture, whose value is {image: base64}. The state does not contain it. */
function pictureField(field, id, change) {
  let image = null;
  const input = make("input", { id, type: "file", accept: "image/*" });
  const name = make("span", { className: "hint" });
  const less = make("button", { type: "button", textContent: "Remove", hidden: true, attributes: { "aria-label": `Remove: ${field.label}` } });
  const take = (base64, text) => {
    image = base64;
    name.textContent = text;
    less.hidden = base64 === null;
  };
  input.addEventListener("change", () => {
    const [file] = input.files;
    if (!file) return;
    const reader = new FileReader();
    reader.addEventListener("load", () => { take(reader.result.split(",")[1] ?? "", file.name); change(false); });
    reader.readAsDataURL(file);
    input.value = "";
  });
  less.addEventListener("click", () => { take(null, ""); input.focus(); change(false); });
  const parts = [make("div", { className: "entry" }, name, less, make("span", { className: "button" }, "Choose", input))];
  return { input, parts, value: () => (image === null ? undefined : { image }), text: () => "", put: () => take(null, "") };
}

const makers = { number: numberField, numbers: numbersField, levels: levelsField, choice: choiceField, several: severalField, check: checkField, colour: colourField, palette: paletteField, text: textField, json: jsonField, picture: pictureField };

/** Creates a button that shows and hides a help text: {button, line}. */
function helpFor(label, text, id) {
  const line = make("p", { id, className: "help", textContent: text, hidden: true });
  const button = make("button", {
    type: "button", className: "about", textContent: "?",
    attributes: { "aria-label": `About: ${label}`, "aria-expanded": "false", "aria-controls": id },
  });
  button.addEventListener("click", () => {
    line.hidden = !line.hidden;
    button.setAttribute("aria-expanded", String(!line.hidden));
  });
  return { button, line };
}

/** Adds a button and a help text to an element. */
export function explain(element, text) {
  const { button, line } = helpFor(element.textContent, text, `help-${++made}`);
  element.append(" ", button);
  element.after(line);
}

/**
 * Fields in a form. `change` is called with true while a slider moves, and with false when a value is final. A field
 * has `name`, `label`, `kind`, `value` (the initial value), `standard` (the default of the server, which requests omit)
 * and optionally `help`.
 */
export class Fields {
  #entries = [];

  constructor(form, fields, change) {
    form.addEventListener("submit", (event) => event.preventDefault());
    for (const field of fields) this.#add(form, field, change);
  }

  #add(form, field, change) {
    const id = `field-${++made}`;
    const entry = { field, ...makers[field.kind](field, id, change) };
    entry.first = entry.text();
    entry.error = make("p", { id: `${id}-error`, className: "error" });
    entry.input.setAttribute("aria-describedby", entry.error.id);
    const label = make("label", { htmlFor: id, textContent: field.label });
    const { button, line } = field.help ? helpFor(field.label, field.help, `${id}-help`) : {};
    entry.element = make("div", { className: "field", attributes: { "data-name": field.name } },
      ...(button ? [make("span", { className: "label" }, label, button)] : [label]),
      ...entry.parts, ...(line ? [line] : []), entry.error);
    form.append(entry.element);
    this.#entries.push(entry);
  }

  #find(name) {
    return this.#entries.find((entry) => entry.field.name === name);
  }

  get #offered() {
    return this.#entries.filter(({ element }) => !element.hidden);
  }

  /** Returns the values that differ from the defaults of the server, by name. Hidden fields are left out. */
  values() {
    const all = this.#offered.map((entry) => [entry.field.name, entry.value(), entry.field.standard]);
    return Object.fromEntries(all.filter(([, value, standard]) => value !== undefined && value !== standard));
  }

  /**
   * Returns the values that differ from the initial ones, as texts by name that `restore` accepts. Hidden fields are
   * left out.
   */
  state() {
    const changed = this.#offered.filter((entry) => entry.text() !== entry.first);
    return Object.fromEntries(changed.map((entry) => [entry.field.name, entry.text()]));
  }

  /** Returns the values of all fields in words: [{label, text, first}]. `first` is the initial value. Skips hidden fields. */
  inWords() {
    return this.#offered.map(({ field, first, text, say = String }) => ({ label: field.label, text: say(text()), first: say(first) }));
  }

  /** Sets each field to its text in a state, or to its initial value if the state has none. */
  restore(state) {
    for (const entry of this.#entries) {
      entry.put(entry.first);
      const text = state[entry.field.name];
      if (text !== undefined) entry.put(text);
    }
  }

  /** Sets a field to a text from a state. */
  put(name, text) {
    this.#find(name).put(text);
  }

  /** Returns the text of a field, hidden or not, that `put` accepts. */
  text(name) {
    return this.#find(name).text();
  }

  offer(name, offered) {
    this.#find(name).element.hidden = !offered;
  }

  /** Changes the default of the server, and sets the field to it if the field had the previous default. */
  setStandard(name, standard) {
    const entry = this.#find(name);
    const isThere = entry.text() === entry.field.standard;
    entry.field = { ...entry.field, standard };
    entry.first = standard;
    if (isThere) entry.put(standard);
  }

  /** Shows a number that the server has chosen in its field. */
  tell(name, number) {
    this.#find(name).tell(number);
  }

  enable(name, enabled) {
    this.#find(name).input.disabled = !enabled;
  }

  /** Shows or hides a choice. If a hidden choice was selected, the default of the server takes its place. */
  allow(name, choice, allowed) {
    this.#find(name).allow(choice, allowed);
  }

  /** Limits the range of a slider to what the server accepts. */
  limit(name, most) {
    this.#find(name).limit(most);
  }

  /** Shows each error beside its field. Skips fields that are hidden or not in this form. */
  show(errors) {
    for (const entry of this.#entries) {
      entry.error.textContent = "";
      entry.input.removeAttribute("aria-invalid");
    }
    for (const { pointer, detail } of errors) {
      const entry = this.#find(pointer.replace(/^\//, "").split("/")[0]);
      if (!entry || entry.element.hidden) continue;
      entry.error.textContent = detail;
      entry.input.setAttribute("aria-invalid", "true");
      const place = entry.element.closest("details");
      if (place) place.open = true;
    }
  }
}
