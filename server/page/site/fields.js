// The options of a request as labelled inputs, each with the place where the server's objection to it is shown.

import { make } from "./dom.js";

let made = 0;

/** A slider beside a number. Numbers beyond the slider's ends may be typed; the server is asked whether it takes them. */
function numberInputs(field, id) {
  const number = make("input", { id, type: "number", value: field.value, step: field.step ?? "any" });
  const toSlider = field.log ? Math.log : (x) => x;
  const fromSlider = field.log ? (x) => Number(Math.exp(x).toPrecision(3)) : (x) => x;
  const slider = make("input", {
    type: "range", min: toSlider(field.min), max: toSlider(field.max), step: field.log ? 0.01 : field.step,
    attributes: { "aria-label": `${field.label}, slider` },
  });
  slider.value = toSlider(field.value);
  const tell = () => slider.setAttribute("aria-valuetext", number.value);
  slider.addEventListener("input", () => { number.value = Math.round(fromSlider(Number(slider.value)) * 100) / 100; tell(); });
  number.addEventListener("input", () => { slider.value = toSlider(Number(number.value)); tell(); });
  tell();
  return { number, slider, all: [number, slider] };
}

function numberField(field, id, change) {
  const { number, slider, all } = numberInputs(field, id);
  const entry = make("div", { className: "entry" });
  const auto = field.auto !== undefined && make("input", { type: "checkbox", checked: field.auto });
  const unit = field.units && make("select", { attributes: { "aria-label": `${field.label}, unit` } },
    ...field.units.map(([value, text]) => new Option(text, value)));
  const settle = () => [...all, ...(unit ? [unit] : [])].forEach((input) => { input.disabled = auto && auto.checked; });
  if (auto) {
    entry.append(make("label", {}, auto, "auto"));
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
  return { input: number, parts: [entry, slider], value };
}

/** Several numbers side by side, each with a label of its own; their value has commas between them. */
function numbersField(field, id, change) {
  const inputs = field.numbers.map(({ value, min, max, step }, index) =>
    make("input", { id: index === 0 ? id : `${id}-${index}`, type: "number", value, min, max, step }));
  for (const input of inputs) input.addEventListener("change", () => change(false));
  const place = make("div", { className: "numbers", attributes: { role: "group", "aria-label": field.label } },
    ...inputs.map((input, index) => make("label", {}, input, field.numbers[index].label)));
  return { input: inputs[0], parts: [place], value: () => inputs.map(({ value }) => (value === "" ? "" : Number(value))).join(",") };
}

function choiceField(field, id, change) {
  const select = make("select", { id }, ...field.choices.map(([value, text]) => new Option(text, value)));
  select.addEventListener("change", () => change(false));
  return { input: select, parts: [select], value: () => select.value };
}

function checkField(field, id, change) {
  const box = make("input", { id, type: "checkbox", checked: field.checked ?? false });
  box.addEventListener("change", () => change(false));
  return { input: box, parts: [box], value: () => box.checked };
}

/** Boxes for any of a few choices, of which `field.checked` are checked at first; their value lists them. */
function severalField(field, id, change) {
  const boxes = field.choices.map(([value, text], index) => {
    const box = make("input", { type: "checkbox", value, checked: field.checked.includes(value), ...(index === 0 && { id }) });
    box.addEventListener("change", () => change(false));
    return { box, label: make("label", {}, box, text) };
  });
  const place = make("div", { className: "several", attributes: { role: "group", "aria-label": field.label } },
    ...boxes.map(({ label }) => label));
  return { input: boxes[0].box, parts: [place], value: () => boxes.filter(({ box }) => box.checked).map(({ box }) => box.value) };
}

function colourField(field, id, change) {
  const well = make("input", { id, type: "color", value: field.value });
  const entry = make("div", { className: "entry" });
  const none = field.transparent && make("input", { type: "checkbox" });
  if (none) entry.append(make("label", {}, none, "transparent"));
  none?.addEventListener("change", () => { well.disabled = none.checked; change(false); });
  entry.append(well);
  well.addEventListener("input", () => change(true));
  well.addEventListener("change", () => change(false));
  return { input: well, parts: [entry], value: () => (none?.checked ? "transparent" : well.value) };
}

/** One well for each of 1 to as many colours as `field.colours` has, of which `field.number` are there at first. */
function paletteField(field, id, change) {
  const wells = [];
  const place = make("div", { className: "wells", attributes: { role: "group", "aria-label": field.label } });
  const more = make("button", { type: "button", textContent: "Add", attributes: { "aria-label": "Add an ink" } });
  const settle = () => {
    more.disabled = wells.length === field.colours.length;
    place.classList.toggle("single", wells.length === 1);
  };
  const remove = (index) => {
    for (let i = index; i + 1 < wells.length; ++i) wells[i].value = wells[i + 1].value;
    wells.pop().parentElement.remove();
    settle();
    more.focus();
    change(false);
  };
  const add = (value) => {
    const index = wells.length;
    const well = make("input", { type: "color", value, attributes: { "aria-label": `Ink ${index + 1}` } });
    if (index === 0) well.id = id;
    const less = make("button", { type: "button", textContent: "\u00d7", attributes: { "aria-label": `Remove ink ${index + 1}` } });
    well.addEventListener("input", () => change(true));
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
  place.append(more);
  field.colours.slice(0, field.number).forEach(add);
  return { input: wells[0], parts: [place], value: () => wells.map((well) => well.value).join(",") };
}

const makers = { number: numberField, numbers: numbersField, choice: choiceField, several: severalField, check: checkField, colour: colourField, palette: paletteField };

/**
 * Fields in a form. `change(draft)` is called while a slider moves, with true, and when it rests.
 * A field has `name`, `label`, `kind`, `value` (the default, which is left out of requests).
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
    entry.error = make("p", { id: `${id}-error`, className: "error" });
    entry.input.setAttribute("aria-describedby", entry.error.id);
    entry.element = make("div", { className: "field", attributes: { "data-name": field.name } },
      make("label", { htmlFor: id, textContent: field.label }), ...entry.parts, entry.error);
    form.append(entry.element);
    this.#entries.push(entry);
  }

  #find(name) {
    return this.#entries.find((entry) => entry.field.name === name);
  }

  /** What differs from the server's defaults, by name, of what is offered. */
  values() {
    const offered = this.#entries.filter(({ element }) => !element.hidden);
    const all = offered.map((entry) => [entry.field.name, entry.value(), entry.field.standard]);
    return Object.fromEntries(all.filter(([, value, standard]) => value !== undefined && value !== standard));
  }

  set(name, value) {
    this.#find(name).input.value = value;
  }

  offer(name, offered) {
    this.#find(name).element.hidden = !offered;
  }

  enable(name, enabled) {
    this.#find(name).input.disabled = !enabled;
  }

  /** Puts each objection beside the field that it is about, if there is one here. */
  show(errors) {
    for (const entry of this.#entries) {
      entry.error.textContent = "";
      entry.input.removeAttribute("aria-invalid");
    }
    for (const { pointer, detail } of errors) {
      const entry = this.#find(pointer.replace(/^\//, "").split("/")[0]);
      if (!entry) continue;
      entry.error.textContent = detail;
      entry.input.setAttribute("aria-invalid", "true");
    }
  }
}
