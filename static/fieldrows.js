// Draws the rows of the left panel from their specs, and keeps them up to date in place: a rebuilt box would lose what is
// being typed. `env` says how a row reaches the server: change(spec, value), locked(), press(name).

import { el, setText } from "./dom.js";
import { frame, newId, problemNode, reshowUnit, unitNode } from "./fieldframe.js";
import { helpOn } from "./fieldhelp.js";
import { NumberBox, scrub } from "./fieldnumber.js";
import { matrixRow, namesRow, tableRow, vectorRow } from "./fieldlists.js";
import { unitNow } from "./unitchoice.js";

const opened = new Map(); // which groups a person opened or closed, by key

function numberRow(spec, env) {
  const id = newId();
  const problem = problemNode();
  const box = new NumberBox(spec, { id, send: (value) => env.change(box.spec, value), onRefused: problem.tell });
  const label = el("label", { class: "field-label", for: id }, spec.label);
  const unit = unitNode(spec);
  const slider = spec.slider ? sliderOf(box, env) : null;
  scrub(label, box);
  const root = frame(spec, slider ? "with-slider" : "", label, box.input, unit, slider?.input, problem.node);
  return {
    root,
    update(next, revision) {
      box.update(next, revision);
      reshowUnit(unit, next);
      box.reshow();
      slider?.update();
    },
  };
}

function sliderOf(box, env) {
  const input = el("input", { type: "range", class: "field-slider", "aria-label": `${box.spec.label}, slider`, tabindex: "-1", step: "any" });
  input.addEventListener("input", () => {
    const { per, step } = box.unit;
    const fine = step / 10;
    box.put(Number(((Math.round((Number(input.value) * per) / fine) * fine) / per).toPrecision(12)));
  });
  const update = () => {
    const [low, high] = box.spec.slider;
    const value = box.value ?? 0;
    input.min = String(Math.min(low, value));
    input.max = String(Math.max(high, value));
    if (document.activeElement !== input || !box.held) input.value = String(value);
    input.style.setProperty("--share", `${(100 * (value - Number(input.min))) / (Number(input.max) - Number(input.min) || 1)}%`);
  };
  const write = box.write.bind(box);
  box.write = (value) => {
    write(value);
    update();
  };
  return { input, update };
}

function readoutRow(spec) {
  const value = el("output", { class: "field-readout" });
  const unit = unitNode(spec);
  const root = frame(spec, "", el("span", { class: "field-label" }, spec.label), value, unit);
  const box = { update(next) {
    reshowUnit(unit, next);
    setText(value, new Intl.NumberFormat("en", { maximumFractionDigits: unitNow(next.quantity, next.unit).digits, minimumFractionDigits: unitNow(next.quantity, next.unit).digits, useGrouping: false }).format(next.value * unitNow(next.quantity, next.unit).per).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "\u2212"));
  } };
  return { root, update: box.update };
}

// Rows whose control shows the document's value again after a refusal: a choice cannot be half made.
function controlRow(spec, env, control, { show, read, wide = false }) {
  const problem = problemNode();
  let now = spec;
  let refusedAt = null;
  let revision = 0;
  let until = 0;
  const send = async () => {
    const answer = await env.change(now, read());
    until = answer?.revision ?? 0;
    control.removeAttribute("data-draft");
    if (answer?.ok === false) {
      refusedAt = Math.max(revision, answer.revision);
      problem.tell(answer.problem);
      if (wide) control.setAttribute("data-draft", "");
      else show(now.value);
    } else problem.tell(null);
  };
  control.addEventListener("input", () => control.setAttribute("data-draft", ""));
  control.addEventListener("change", send);
  const root = frame(spec, wide ? "wide" : "plain", el("label", { class: "field-label", for: control.id }, spec.label), control, problem.node);
  return {
    root,
    update(next, at) {
      now = next;
      revision = at;
      if (refusedAt !== null && at > refusedAt) problem.tell((refusedAt = null));
      const held = document.activeElement === control && (control.hasAttribute("data-draft") || at < until);
      if (refusedAt === null && !held) show(next.value);
    },
  };
}

function choiceRow(spec, env) {
  const options = spec.choices.map(([, words], k) => el("option", { value: String(k) }, words));
  const control = el("select", { class: "field-choice", id: newId() }, ...options);
  const show = (value) => (control.value = String(Math.max(spec.choices.findIndex(([choice]) => choice === value), 0)));
  return controlRow(spec, env, control, { show, read: () => spec.choices[Number(control.value)][0] });
}

function switchRow(spec, env) {
  const control = el("input", { class: "field-switch", type: "checkbox", role: "switch", id: newId() });
  return controlRow(spec, env, control, { show: (value) => (control.checked = Boolean(value)), read: () => control.checked });
}

function textRow(spec, env) {
  const control = el("input", { class: "field-text", type: "text", id: newId(), maxlength: spec.longest, spellcheck: "false" });
  return controlRow(spec, env, control, { show: (value) => (control.value = value ?? ""), read: () => (control.value === "" && spec.nullable ? null : control.value), wide: true });
}

function areaRow(spec, env) {
  const control = el("textarea", { class: "field-text", rows: "3", id: newId(), maxlength: spec.longest });
  return controlRow(spec, env, control, { show: (value) => (control.value = value ?? ""), read: () => control.value, wide: true });
}

function colorRow(spec, env) {
  const control = el("input", { class: "field-color", type: "color", id: newId() });
  const row = controlRow(spec, env, control, { show: (value) => (control.value = value ?? env.colorNow()), read: () => control.value });
  const clear = el("button", { class: "field-clear", type: "button", title: "Back to the colour that the studio gives", "aria-label": "Clear the colour", onclick: () => env.change(spec, null) }, "×");
  row.root.append(clear);
  const update = row.update;
  row.update = (next, at) => {
    update(next, at);
    clear.hidden = next.value === null;
  };
  return row;
}

function noteRow(spec) {
  const root = el("p", { class: `field-note ${spec.strong ? "strong" : ""}` }, spec.text);
  return { root, update: (next) => setText(root, next.text) };
}

function buttonsRow(spec, env) {
  let now = spec;
  const buttons = spec.buttons.map(([words], k) => el("button", { class: "btn small", type: "button", onclick: () => {
    const [, what] = now.buttons[k];
    if (typeof what === "string") env.press(what);
    else env.change({ ...now, write: what }, null);
  } }, words));
  const root = el("div", { class: "field-buttons" }, ...buttons);
  return { root, update: (next) => (now = next) };
}

// Closed groups have no rows: they are made when somebody looks.
function groupRow(spec, env) {
  const body = el("div", { class: "field-body" });
  const root = el("details", { class: "field-group", "data-pointer": spec.key.startsWith("/") ? spec.key : "", "data-testid": `group-${spec.label}` }, el("summary", {}, spec.label), body);
  root.open = opened.get(spec.key) ?? spec.open;
  const items = new Items(body, env);
  let now = spec;
  let revision = 0;
  const draw = () => items.update(root.open ? now.items : [], revision);
  root.addEventListener("toggle", () => {
    opened.set(spec.key, root.open);
    draw();
  });
  return {
    root,
    // At once: whoever asks for a field inside wants it there now.
    open() {
      root.open = true;
      draw();
    },
    update(next, at) {
      now = next;
      revision = at;
      draw();
    },
    items,
  };
}

const ROWS = {
  number: numberRow, vector: vectorRow, matrix: matrixRow, table: tableRow, names: namesRow, readout: readoutRow, choice: choiceRow, switch: switchRow,
  text: textRow, area: areaRow, color: colorRow, note: noteRow, buttons: buttonsRow, group: groupRow,
};

const flat = (specs) => specs.flatMap((spec) => (spec.row === "items" ? flat(spec.items) : [spec]));
// What an existing row cannot take over: rows that differ in it are made anew.
const shape = ({ row, key, label, choices, words, unit, quantity, nullable, placeholder, all, buttons }) => [row, key, label, choices, words, unit, quantity, nullable, placeholder, all, buttons?.map(([text]) => text)];

// A list of rows that follows a list of specs.
export class Items {
  constructor(root, env) {
    Object.assign(this, { root, env, rows: [], shape: null });
  }

  update(given, revision) {
    const specs = flat(given);
    const wanted = JSON.stringify(specs.map(shape));
    if (wanted !== this.shape) this.rebuild(specs, wanted);
    this.rows.forEach((row, k) => {
      row.spec = specs[k];
      row.update(specs[k], revision);
    });
    if (!(this.env.locked() === this.locked)) this.setLocked(this.env.locked());
  }

  // Rows that stay are kept with what is in them; only the others are made.
  rebuild(specs, wanted) {
    const before = new Map(this.rows.map((row) => [row.shape, row]));
    this.rows = specs.map((spec) => {
      const its = JSON.stringify(shape(spec));
      const kept = before.get(its);
      before.delete(its);
      return kept ?? this.made(spec, its);
    });
    this.shape = wanted;
    const focused = this.root.contains(document.activeElement) ? document.activeElement : null;
    const nodes = this.rows.map(({ root }) => root);
    for (const row of before.values()) row.root.remove();
    nodes.forEach((node, k) => this.root.children[k] !== node && this.root.insertBefore(node, this.root.children[k] ?? null));
    if (focused?.isConnected && document.activeElement !== focused) focused.focus();
    this.locked = undefined;
  }

  made(spec, its) {
    const row = ROWS[spec.row](spec, this.env);
    row.shape = its;
    row.spec = spec;
    if (spec.row !== "group" && spec.row !== "note" && spec.row !== "buttons") helpOn(row.root, () => row.spec);
    return row;
  }

  setLocked(locked) {
    this.locked = locked;
    for (const { root } of this.rows) for (const node of root.querySelectorAll("input, select:not(.field-unit), textarea, button")) node.disabled = locked;
  }

  // Opens the groups on the way to a pointer and returns the nearest row's element, or null.
  find(pointer) {
    const leads = (key) => key && (pointer === key || pointer.startsWith(`${key}/`));
    let best = null;
    for (const row of this.rows) {
      const here = leads(row.spec.pointer) ? row.root : null;
      const inside = row.items && holds(row.spec, pointer) ? (row.open(), row.items.find(pointer) ?? row.root) : null;
      const found = inside ?? here;
      if (found && (found.dataset.pointer ?? "").length > (best?.dataset.pointer ?? "").length) best = found;
      else best ??= found;
    }
    return best;
  }
}

const holds = ({ key, items }, pointer) => pointer === key || flat(items).some((spec) => (spec.pointer && (pointer === spec.pointer || pointer.startsWith(`${spec.pointer}/`))) || (spec.row === "group" && holds(spec, pointer)));
