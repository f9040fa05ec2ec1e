// Rows that hold several numbers or names: vectors, matrices, tables of points, and the choice of some of the cells.

import { el, setText } from "./dom.js";
import { frame, newId, problemNode, reshowUnit, unitNode } from "./fieldframe.js";
import { NumberBox, scrub } from "./fieldnumber.js";
import { unitNow } from "./unitchoice.js";

const replaced = (list, k, value) => list.map((old, n) => (n === k ? value : old));

export function vectorRow(spec, env) {
  const problem = problemNode();
  let now = spec;
  const entry = (k) => ({ ...now, pointer: `${now.pointer}/${k}`, value: now.value?.[k], nullable: false });
  const boxes = spec.words.map((word, k) => new NumberBox(entry(k), {
    label: `${spec.label} ${word}`, onRefused: problem.tell,
    // The entry alone, so that two people may each drag one.
    send: (value) => env.change({ ...entry(k), key: `${now.key}/${k}`, write: () => [{ op: "replace", path: `${now.pointer}/${k}`, value }] }, value),
  }));
  const unit = unitNode(spec);
  const clear = spec.nullable ? el("button", { class: "field-clear", type: "button", "aria-label": `No ${spec.label.toLowerCase()} of its own`, title: "None", onclick: () => env.change(now, null) }, "×") : null;
  const cells = boxes.map((box, k) => {
    const word = el("span", { class: "field-axis", "aria-hidden": "true" }, spec.words[k]);
    scrub(word, box);
    return el("div", { class: "field-entry" }, word, box.input);
  });
  const root = frame(spec, `entries-${spec.words.length}`, el("span", { class: "field-label" }, spec.label), el("div", { class: "field-entries" }, ...cells), unit, clear, problem.node);
  return {
    root,
    update(next, revision) {
      now = next;
      reshowUnit(unit, next);
      boxes.forEach((box, k) => {
        box.update(entry(k), revision);
        box.reshow();
      });
    },
  };
}

const PLACES = ["surge", "sway", "heave", "roll", "pitch", "yaw"];

// Six by six; an entry and its mirror image across the diagonal are one number.
export function matrixRow(spec, env) {
  const problem = problemNode();
  let now = spec;
  const entry = (i, k) => ({ ...now, row: "number", quantity: null, scale: "log", pointer: `${now.pointer}/${i}/${k}`, value: now.value?.[i]?.[k] });
  const write = (i, k, value) => {
    const cells = i === k ? [[i, k]] : [[i, k], [k, i]];
    return env.change({ ...now, key: `${now.key}/${i}/${k}`, write: () => cells.map(([a, b]) => ({ op: "replace", path: `${now.pointer}/${a}/${b}`, value })) }, value);
  };
  const boxes = PLACES.map((row, i) => PLACES.map((column, k) => new NumberBox(entry(i, k), { label: `${spec.label}, ${row} by ${column}`, onRefused: problem.tell, send: (value) => write(i, k, value) })));
  const head = el("tr", {}, el("td", {}), ...PLACES.map((word) => el("th", { scope: "col" }, word)));
  const table = el("table", { class: "field-matrix" }, el("thead", {}, head), el("tbody", {}, ...boxes.map((row, i) => el("tr", {}, el("th", { scope: "row" }, PLACES[i]), ...row.map((box) => el("td", {}, box.input))))));
  const clear = spec.nullable ? el("button", { class: "btn small", type: "button", onclick: () => env.change(now, null) }, "Remove the matrix") : null;
  const root = frame(spec, "wide matrix", el("span", { class: "field-label" }, `${spec.label}, ${spec.unit}`), table, clear, problem.node);
  return {
    root,
    update(next, revision) {
      now = next;
      boxes.forEach((row, i) => row.forEach((box, k) => box.update(entry(i, k), revision)));
    },
  };
}

export function tableRow(spec, env) {
  const problem = problemNode();
  const body = el("tbody", {});
  const heads = spec.columns.map(() => el("th", { scope: "col" }));
  const add = el("button", { class: "btn small", type: "button" }, "Add a row");
  const table = el("table", { class: "field-table", "aria-label": spec.label }, el("thead", {}, el("tr", {}, ...heads, el("td", {}))), body);
  const root = frame(spec, "wide", el("span", { class: "field-label" }, spec.label), table, el("div", { class: "field-buttons" }, add), problem.node);
  const state = { now: spec, rows: [], body, problem, env };
  add.addEventListener("click", () => put(state, [...state.now.rows, state.now.added], "added"));
  return {
    root,
    update(next, revision) {
      state.now = next;
      next.columns.forEach((column, n) => setText(heads[n], [column.label, unitNow(column.quantity, column.unit).symbol].filter(Boolean).join(", ")));
      fitRows(state);
      state.rows.forEach((row, k) => row.update(next.rows[k], revision));
    },
  };
}

async function put({ now, env, problem }, rows, key) {
  const answer = await env.change({ ...now, key: `${now.key} ${key}`, write: () => now.writeRows(rows) }, null);
  if (answer) problem.tell(answer.ok ? null : answer.problem);
  return answer;
}

// Rows stay while their number allows: a rebuilt one would lose what is being typed.
function fitRows(state) {
  while (state.rows.length > state.now.rows.length) state.rows.pop().root.remove();
  while (state.rows.length < state.now.rows.length) {
    const row = madeRow(state, state.rows.length);
    state.rows.push(row);
    state.body.append(row.root);
  }
  for (const row of state.rows) row.remove.disabled = state.now.rows.length <= state.now.least;
}

function madeRow(state, k) {
  const cells = state.now.columns.map((column, n) => (column.choices ? choiceCell(state, k, n) : numberCell(state, k, n)));
  const remove = el("button", { class: "field-clear", type: "button", "aria-label": `Remove row ${k + 1}`, title: "Remove", onclick: () => put(state, state.now.rows.filter((_, i) => i !== k), "removed") }, "×");
  const root = el("tr", {}, ...cells.map(({ node }) => el("td", {}, node)), el("td", {}, remove));
  return { root, remove, update: (row, revision) => cells.forEach((cell) => cell.update(row, revision)) };
}

const cellSpec = (column, value) => ({ ...column, value, nullable: false });

function numberCell(state, k, n) {
  const column = () => state.now.columns[n];
  const write = (value) => put(state, replaced(state.now.rows, k, column().set(state.now.rows[k], value)), `${k} ${n}`);
  const box = new NumberBox(cellSpec(column(), column().get(state.now.rows[k])), { label: `${column().label} ${k + 1}`, send: write, onRefused: state.problem.tell });
  const update = (row, revision) => {
    box.update(cellSpec(column(), column().get(row)), revision);
    box.reshow();
  };
  return { node: box.input, update };
}

function choiceCell(state, k, n) {
  const { choices, label } = state.now.columns[n];
  const node = el("select", { class: "field-choice", "aria-label": `${label} ${k + 1}` }, ...choices.map(([value, words]) => el("option", { value }, words)));
  node.addEventListener("change", () => put(state, replaced(state.now.rows, k, state.now.columns[n].set(state.now.rows[k], node.value)), `${k} ${n}`));
  return { node, update: (row) => (node.value = state.now.columns[n].get(row)) };
}

// Some of the cells; none chosen is null, which means all.
export function namesRow(spec, env) {
  const problem = problemNode();
  let now = spec;
  const boxes = spec.all.map((name) => {
    const box = el("input", { type: "checkbox", id: newId() });
    box.addEventListener("change", async () => {
      const chosen = now.all.filter((_, k) => boxes[k].checked);
      const answer = await env.change(now, chosen.length ? chosen : null);
      problem.tell(answer?.ok === false ? answer.problem : null);
    });
    return box;
  });
  const list = el("div", { class: "field-names" }, ...spec.all.map((name, k) => el("label", { for: boxes[k].id }, boxes[k], name)));
  const root = frame(spec, "wide", el("span", { class: "field-label" }, spec.label), list, problem.node);
  return {
    root,
    update(next) {
      now = next;
      boxes.forEach((box, k) => (box.checked = (next.value ?? []).includes(next.all[k])));
    },
  };
}
