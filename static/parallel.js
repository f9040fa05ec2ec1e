// Parallel coordinates of the cases: a line a case, an axis a column. A range brushed on an axis selects what passes
// through it: with the pointer, or with the two handles that each axis has for the keyboard.

import { $, el, setText } from "./dom.js";
import { cssColor, prepare } from "./plotcanvas.js";

const PAD = { top: 20, bottom: 52, side: 62 };
const ROOM = 104; // pixels an axis needs
const COLORS = 24;
const ROUNDS = 10; // the colours are drawn in turns: else the last would cover the rest
const STEP = 0.02; // of an axis, for a press of an arrow key
const ON_THE_PROCESSOR = { willReadFrequently: true }; // thousands of thin lines: a graphics processor made of software takes a minute
const SLACK = 3; // pixels a pointer may move and still not have brushed

const mix = (a, b, t) => a.map((v, k) => Math.round(v + (b[k] - v) * t));
const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

function rainbow() {
  const stops = [0, 1, 2, 3, 4].map((k) => rgb(cssColor(`--scale-${k}`)));
  return Array.from({ length: COLORS }, (_, k) => {
    const at = (k / (COLORS - 1)) * (stops.length - 1);
    const i = Math.min(Math.floor(at), stops.length - 2);
    return `rgb(${mix(stops[i], stops[i + 1], at - i).join(",")})`;
  });
}

export class Parallel {
  constructor(box, { onBrush }) {
    Object.assign(this, { box, onBrush });
    this.canvas = box.querySelector("canvas");
    this.axes = el("div", { class: "axes" });
    box.append(this.axes);
    this.nodes = new Map();
    this.shown = null; // which columns, once a person has chosen
  }

  static room(width) {
    return Math.max(2, Math.floor((width - 2 * PAD.side) / ROOM) + 1);
  }

  // As many as have room, those of the scatter before all.
  names(table, { x, y, color }) {
    const all = table.axes.map(({ name }) => name);
    const room = Parallel.room(this.box.clientWidth);
    if (this.shown) return all.filter((name) => this.shown.has(name)).slice(0, room);
    const varying = all.filter((name) => table.bounds(name)[0] < table.bounds(name)[1]);
    const first = new Set([...new Set([x, y, color, ...varying, ...all].filter(Boolean))].slice(0, room));
    return all.filter((name) => first.has(name));
  }

  show({ table, passing, brushes, axes, selected, slotColor }) {
    Object.assign(this, { table, brushes });
    const { clientWidth: width, clientHeight: height } = this.box;
    const names = this.names(table, axes);
    this.height = height - PAD.top - PAD.bottom;
    this.bounds = new Map(names.map((name) => [name, wide(table.bounds(name))]));
    const gap = names.length > 1 ? (width - 2 * PAD.side) / (names.length - 1) : 0;
    this.at = new Map(names.map((name, k) => [name, PAD.side + k * gap]));
    this.drawLines(prepare(this.canvas, width, height, ON_THE_PROCESSOR), { names, passing, color: axes.color ?? axes.y, selected, slotColor });
    this.placeAxes(names);
    this.box.dataset.axes = names.length;
    this.box.dataset.brushes = brushes.size;
  }

  y(name, value) {
    const [low, high] = this.bounds.get(name);
    return PAD.top + this.height * (1 - (value - low) / (high - low));
  }

  value(name, y) {
    const [low, high] = this.bounds.get(name);
    return low + (high - low) * Math.min(Math.max(1 - (y - PAD.top) / this.height, 0), 1);
  }

  drawLines(context, { names, passing, color, selected, slotColor }) {
    const groups = this.grouped(passing, color);
    const count = passing.reduce((sum, v) => sum + v, 0);
    context.lineWidth = 1;
    context.globalAlpha = 0.12;
    this.strokeRows(context, groups.out, names, cssColor("--faint"));
    context.globalAlpha = Math.min(0.9, Math.max(0.05, 9 / Math.sqrt(Math.max(count, 1))));
    const colors = rainbow();
    for (let round = 0; round < ROUNDS; round += 1) {
      const turn = (rows) => rows.slice(Math.floor((rows.length * round) / ROUNDS), Math.floor((rows.length * (round + 1)) / ROUNDS));
      groups.inside.forEach((rows, k) => this.strokeRows(context, turn(rows), names, colors[k]));
    }
    context.setLineDash([3, 3]);
    this.strokeRows(context, groups.failed, names, cssColor("--bad"));
    context.setLineDash([]);
    context.globalAlpha = 1;
    context.lineWidth = 2.2;
    for (const { n, slot } of selected) if (this.table.rows.has(n)) this.strokeRows(context, [this.table.rows.get(n)], names, slotColor(slot));
  }

  // Rows by colour, so that each colour is one stroke.
  grouped(passing, color) {
    const { table } = this;
    const groups = { out: [], failed: [], inside: Array.from({ length: COLORS }, () => []) };
    const values = table.values.get(color);
    const [low, high] = wide(table.bounds(color));
    for (let i = 0; i < table.size; i += 1) {
      if (!passing[i]) groups.out.push(i);
      else if (table.group[i] !== null) groups.failed.push(i);
      else if (Number.isFinite(values[i])) groups.inside[Math.min(Math.floor(((values[i] - low) / (high - low)) * COLORS), COLORS - 1)].push(i);
      else groups.inside[0].push(i);
    }
    return groups;
  }

  strokeRows(context, rows, names, color) {
    if (rows.length === 0) return;
    context.strokeStyle = color;
    context.beginPath();
    for (const i of rows) {
      let pen = false;
      for (const name of names) {
        const v = this.table.values.get(name)[i];
        if (!Number.isFinite(v)) pen = false;
        else if (pen) context.lineTo(this.at.get(name), this.y(name, v));
        else {
          context.moveTo(this.at.get(name), this.y(name, v));
          pen = true;
        }
      }
    }
    context.stroke();
  }

  // Axes are kept while their column is shown, so that a handle keeps the focus.
  placeAxes(names) {
    for (const [name, axis] of this.nodes) {
      if (names.includes(name)) continue;
      axis.node.remove();
      this.nodes.delete(name);
    }
    names.forEach((name, k) => {
      if (!this.nodes.has(name)) this.nodes.set(name, new Axis(name, this));
      const axis = this.nodes.get(name);
      if (this.axes.children[k] !== axis.node) this.axes.insertBefore(axis.node, this.axes.children[k] ?? null);
      axis.show();
    });
  }
}

const wide = ([low, high]) => (high > low ? [low, high] : [low - (Math.abs(low) || 1) * 0.5, high + (Math.abs(high) || 1) * 0.5]);

class Axis {
  constructor(name, parent) {
    Object.assign(this, { name, parent });
    this.title = el("span", { class: "axis-title" });
    [this.high, this.low] = [el("span", { class: "axis-end top" }), el("span", { class: "axis-end" })];
    this.track = el("div", { class: "axis-track" });
    this.brush = el("div", { class: "axis-brush", hidden: true });
    this.handles = [0, 1].map((end) => this.handle(end));
    this.node = el("div", { class: "axis", role: "group" }, this.title, this.high, this.low, this.track, this.brush, ...this.handles);
    this.track.addEventListener("pointerdown", (event) => this.begin(event));
    this.track.addEventListener("dblclick", () => parent.onBrush(name, null));
  }

  get bounds() {
    return this.parent.bounds.get(this.name);
  }

  get range() {
    return this.parent.brushes.get(this.name) ?? this.bounds;
  }

  show() {
    const { parent, name } = this;
    const [table, [low, high], range] = [parent.table, this.bounds, this.range];
    const scale = table.scale(name);
    this.node.style.left = `${parent.at.get(name)}px`;
    this.node.setAttribute("aria-label", table.label(name));
    setText(this.title, table.label(name));
    this.title.title = table.label(name);
    setText(this.high, scale.brief(high));
    setText(this.low, scale.brief(low));
    const brushed = parent.brushes.has(name);
    this.brush.hidden = !brushed;
    const [top, foot] = [parent.y(name, Math.min(range[1], high)), parent.y(name, Math.max(range[0], low))];
    Object.assign(this.brush.style, { top: `${top}px`, height: `${Math.max(foot - top, 2)}px` });
    this.handles.forEach((handle, end) => {
      handle.style.top = `${end ? top : foot}px`;
      handle.toggleAttribute("data-set", brushed);
      handle.setAttribute("aria-valuemin", low);
      handle.setAttribute("aria-valuemax", high);
      handle.setAttribute("aria-valuenow", range[end]);
      handle.setAttribute("aria-valuetext", scale.withUnit(range[end]));
    });
  }

  handle(end) {
    const node = el("div", { class: "axis-handle", role: "slider", tabindex: "0", "aria-orientation": "vertical", "aria-label": `${end ? "At most" : "At least"} of ${this.name}`, "data-testid": `${end ? "most" : "least"}-${this.name}` });
    node.addEventListener("keydown", (event) => this.press(event, end));
    node.addEventListener("pointerdown", (event) => this.begin(event, end));
    return node;
  }

  press(event, end) {
    const [low, high] = this.bounds;
    const span = (high - low) * STEP;
    const steps = { ArrowUp: span, ArrowRight: span, ArrowDown: -span, ArrowLeft: -span, PageUp: 5 * span, PageDown: -5 * span, Home: -Infinity, End: Infinity };
    if (event.key === "Escape" || event.key === "Delete") this.parent.onBrush(this.name, null);
    else if (event.key in steps) this.set(end, this.range[end] + steps[event.key]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  set(end, value) {
    const range = [...this.range];
    const [low, high] = this.bounds;
    range[end] = Math.min(Math.max(value, end ? range[0] : low), end ? high : range[1]);
    this.parent.onBrush(this.name, range[0] <= low && range[1] >= high ? null : range);
  }

  // A drag along the axis makes a range; one of a handle moves that end; a click alone takes the range away.
  begin(event, end) {
    if (event.button !== 0) return;
    event.preventDefault();
    const top = this.parent.box.getBoundingClientRect().top;
    const [started, first] = [event.clientY, this.parent.value(this.name, event.clientY - top)];
    const move = ({ clientY }) => {
      const now = this.parent.value(this.name, clientY - top);
      if (end !== undefined) this.set(end, now);
      else if (Math.abs(clientY - started) > SLACK) this.parent.onBrush(this.name, [Math.min(first, now), Math.max(first, now)]);
    };
    const stop = ({ clientY }) => {
      removeEventListener("pointermove", move);
      if (end === undefined && Math.abs(clientY - started) <= SLACK) this.parent.onBrush(this.name, null);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", stop, { once: true });
    (end === undefined ? this.handles[0] : this.handles[end]).focus({ preventScroll: true, focusVisible: false });
  }
}

// The menu that says which columns have an axis.
export function connectAxisMenu(parallel, onChange) {
  let known = "";
  const menu = $("axis-menu");
  menu.addEventListener("change", () => {
    parallel.shown = new Set([...menu.querySelectorAll(":checked")].map(({ value }) => value));
    onChange();
  });
  return (table, axes) => {
    const names = table.axes.map(({ name }) => name);
    const shown = parallel.names(table, axes);
    const key = JSON.stringify([names, shown]);
    setText($("axis-count"), `${shown.length} of ${names.length}`);
    if (key === known || menu.contains(document.activeElement)) return;
    known = key;
    menu.replaceChildren(...names.map((name) => el("label", { class: "check" }, el("input", { type: "checkbox", value: name, checked: shown.includes(name) }), table.words(name))));
  };
}
