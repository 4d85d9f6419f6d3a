"use strict";
// The form: a field for each key of a profile, made from the table of keys that the server sends.
class ProfileForm {
  // `box` is the form's element; `change` is called with every edit.
  constructor(box, tables, change) {
    Object.assign(this, { box, tables, change });
    this.fields = new Map();
    this.choices = [];
    this.parts = [];
    const groups = new Map();
    for (const table of tables) {
      const first = table.path.split(".")[0];
      let group = groups.get(first);
      if (!group) {
        group = this.group(first);
        groups.set(first, group);
      }
      const part = document.createElement("div");
      if (table.choices.length) part.append(this.choice(table));
      for (const key of table.keys) part.append(this.field(key));
      const isLong = table.path.startsWith("tolerance.");
      group.append(isLong ? this.folded(table.path, part) : part);
      const parent = tables.find((other) => other.path === table.path.split(".").slice(0, -1).join("."));
      if (parent && parent.choices.length) this.parts.push({ part, path: table.path });
    }
  }

  group(name) {
    const set = document.createElement("fieldset");
    const legend = document.createElement("legend");
    legend.textContent = name || "profile";
    set.append(legend);
    this.box.append(set);
    if (name !== "tolerance") return set;
    const { details, inner } = this.details("Errors of making and mounting");
    set.append(details);
    return inner;
  }

  details(title) {
    const details = document.createElement("details");
    const summary = document.createElement("summary");
    summary.textContent = title;
    const inner = document.createElement("div");
    details.append(summary, inner);
    return { details, inner };
  }

  folded(title, part) {
    const { details, inner } = this.details(title);
    inner.append(part);
    return details;
  }

  choice(table) {
    const row = document.createElement("div");
    row.className = "field";
    const label = document.createElement("label");
    const select = document.createElement("select");
    select.id = "choice-" + table.path;
    label.htmlFor = select.id;
    label.textContent = "kind of " + table.path;
    select.append(new Option("none", ""));
    for (const name of table.choices) select.append(new Option(name, name));
    select.addEventListener("change", () => {
      const path = table.path.split(".");
      if (select.value) this.change({ path, take: { name: select.value, among: table.choices } });
      else this.change({ path, value: null });
    });
    row.append(label, select);
    this.choices.push({ table, select });
    return row;
  }

  field(key) {
    const row = document.createElement("div");
    row.className = "field";
    const id = "key-" + key.path;
    const label = document.createElement("label");
    label.htmlFor = id;
    label.textContent = key.key;
    const unit = document.createElement("span");
    unit.className = "unit";
    unit.textContent = " " + key.unit;
    label.append(unit);
    const inputs = document.createElement("div");
    inputs.className = "inputs";
    const about = document.createElement("p");
    about.className = "about";
    about.id = "about-" + key.path;
    about.textContent = key.meaning + (key.range ? " (" + key.range + ")" : "");
    const wrong = document.createElement("p");
    wrong.className = "wrong";
    wrong.id = "wrong-" + key.path;
    wrong.hidden = true;
    row.append(label, inputs, wrong, about);
    const field = { key, row, wrong, controls: [], path: key.path.split(".") };
    const make = { flag: "select", word: "select", words: "words", number: "number", whole: "number", pair: "pair" };
    this[(make[key.kind] || "line") + "Control"](field, inputs, id);
    for (const control of field.controls) {
      control.setAttribute("aria-describedby", about.id + " " + wrong.id);
    }
    this.fields.set(key.path, field);
    return row;
  }

  send(field, edit) {
    // (The value may be refused: the field then shows again what is in the text.)
    field.shown = undefined;
    this.change({ path: field.path, ...edit });
  }

  // A number, and a slider around it.
  numberInput(field, inputs, id, name, sent) {
    const [low, high] = field.key.limits;
    const number = document.createElement("input");
    number.type = "number";
    number.step = field.key.kind === "whole" ? "1" : "any";
    number.id = id;
    if (name) number.setAttribute("aria-label", name);
    if (low !== null) number.min = low;
    if (high !== null) number.max = high;
    const slider = document.createElement("input");
    slider.type = "range";
    slider.setAttribute("aria-label", (name || field.key.key) + ", slider");
    const put = (text) => sent(text === "" ? null : Number(text));
    number.addEventListener("change", () => put(number.value));
    slider.addEventListener("input", () => { number.value = slider.value; put(slider.value); });
    inputs.append(number, slider);
    field.controls.push(number, slider);
    return (value) => {
      const held = document.activeElement === slider;
      if (document.activeElement !== number || number.value === "") number.value = value === null ? "" : value;
      if (typeof value !== "number") { slider.disabled = true; return; }
      slider.disabled = false;
      if (held && Number(slider.min) <= value && value <= Number(slider.max)) return;
      const [from, to] = this.span(field.key, value);
      slider.min = from;
      slider.max = to;
      slider.step = field.key.kind === "whole" || field.key.unit.endsWith("], px") ? 1 : this.step(to - from);
      slider.value = value;
    };
  }

  // A five-hundredth of a span, rounded to 1, 2 or 5.
  step(span) {
    const raw = span / 500;
    const ten = Math.pow(10, Math.floor(Math.log10(raw)));
    return Number(([1, 2, 5, 10].find((n) => n * ten >= raw * 0.999) * ten).toPrecision(1));
  }

  // Limits of a slider: those of angles, or a few times the value, within the key's own.
  span(key, value) {
    let from = value > 0 ? value / 3 : 3 * value;
    let to = value > 0 ? 3 * value : value / 3;
    if (value === 0) [from, to] = [-1, 1];
    if (key.unit.includes("degrees")) [from, to] = key.key === "azimuth_deg" ? [-360, 360] : key.key === "elevation_deg" ? [-89, 89] : [0.1, 179.9];
    if (key.unit === "share") [from, to] = [0, 1];
    if (key.kind === "whole" && key.limits[1] <= 100) [from, to] = key.limits;
    if (key.kind === "whole" || key.unit.endsWith("], px")) [from, to] = [Math.max(1, Math.floor(from)), Math.ceil(to)];
    const [low, high] = key.limits;
    if (low !== null) from = Math.max(from, low);
    if (high !== null) to = Math.min(to, high);
    return [Number(from.toPrecision(4)), Number(to.toPrecision(4))];
  }

  numberControl(field, inputs, id) {
    const show = this.numberInput(field, inputs, id, "", (value) => this.send(field, { value }));
    field.show = (found) => show(found && typeof found.value === "number" ? found.value : null);
  }

  pairControl(field, inputs, id) {
    const names = field.key.unit.replace(/^\[/, "").split("]")[0].split(", ");
    let now = null;
    const shows = [0, 1].map((k) => this.numberInput(field, inputs, k ? id + "-1" : id, names[k] || "", (value) => {
      if (now) { this.send(field, { value, index: k }); return; }
      const numbers = field.controls.filter((control) => control.type === "number").map((control) => control.value);
      if (numbers.every((text) => text !== "")) this.send(field, { value: numbers.map(Number) });
    }));
    field.show = (found) => {
      now = found && Array.isArray(found.value) && found.value.length === 2 ? found.value : null;
      shows.forEach((show, k) => show(now && typeof now[k] === "number" ? now[k] : null));
    };
  }

  selectControl(field, inputs, id) {
    const select = document.createElement("select");
    select.id = id;
    const words = field.key.kind === "flag" ? ["true", "false"] : field.key.words;
    if (!words.length) { this.lineControl(field, inputs, id); return; }
    select.append(new Option("by default", ""));
    for (const word of words) select.append(new Option(word, word));
    select.addEventListener("change", () => {
      const value = field.key.kind === "flag" ? select.value === "true" : select.value;
      this.send(field, { value: select.value === "" ? null : value });
    });
    inputs.append(select);
    field.controls.push(select);
    field.show = (found) => { select.value = found ? String(found.value) : ""; };
  }

  wordsControl(field, inputs, id) {
    const group = document.createElement("div");
    group.className = "words";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", field.key.key);
    const boxes = field.key.words.map((word, k) => {
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.id = k ? id + "-" + word : id;
      box.value = word;
      label.append(box, " " + word);
      group.append(label);
      box.addEventListener("change", () => {
        const value = boxes.filter((other) => other.checked).map((other) => other.value);
        this.send(field, { value });
      });
      return box;
    });
    inputs.append(group);
    field.controls.push(...boxes);
    field.show = (found) => {
      const words = found && Array.isArray(found.value) ? found.value : [];
      boxes.forEach((box) => { box.checked = words.includes(box.value); });
    };
  }

  // A line of text, or of TOML.
  lineControl(field, inputs, id) {
    const isText = field.key.kind === "text";
    // Lists may have lines, and comments in them.
    const isToml = field.key.kind === "toml";
    const input = document.createElement(isToml ? "textarea" : "input");
    if (isToml) input.wrap = "off"; else input.type = "text";
    input.id = id;
    input.addEventListener("change", () => {
      const text = input.value;
      this.send(field, text === "" ? { value: null } : isText || field.key.kind === "word" ? { value: text } : { toml: text });
    });
    inputs.append(input);
    field.controls.push(input);
    field.show = (found) => {
      if (document.activeElement === input) return;
      input.value = !found ? "" : typeof found.value === "string" ? found.value : found.toml || "";
      if (isToml) input.rows = Math.min(input.value.split("\n").length, 12);
    };
  }

  // Shows the values of a text; none where it is no TOML.
  show(values) {
    if (this.isShown !== Boolean(values)) {
      this.isShown = Boolean(values);
      for (const control of this.box.elements) control.disabled = !values;
      // (Sliders of keys without a value are off.)
      for (const field of this.fields.values()) field.shown = undefined;
    }
    if (!values) return;
    for (const { table, select } of this.choices) {
      select.value = table.choices.find((name) => values[table.path + "." + name]) || "";
    }
    for (const { part, path } of this.parts) part.hidden = !values[path];
    for (const field of this.fields.values()) {
      const found = values[field.key.path];
      const now = JSON.stringify(found ?? null);
      if (field.shown !== now) field.show(found);
      field.shown = now;
    }
  }

  // Shows errors at the fields of their keys.
  complain(errors, keys) {
    for (const field of this.fields.values()) {
      const own = errors.filter((_, k) => keys[k] === field.key.path);
      const said = own.map((error) => error.message + (error.hint ? " (" + error.hint + ")" : "")).join("; ");
      if (field.said === said) continue;
      field.said = said;
      field.wrong.hidden = !own.length;
      field.wrong.textContent = said;
      for (const control of field.controls) control.setAttribute("aria-invalid", own.length ? "true" : "false");
    }
  }
}
