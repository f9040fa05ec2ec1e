// The cursor that lanes and plots share: its line, the values under it, and the words of marks.

import { $, el } from "./dom.js";
import { clockText } from "./format.js";

function cell(value) {
  const [text, color] = Array.isArray(value) ? value : [value];
  const node = el("b", {}, text);
  if (color) node.style.color = color;
  return node;
}

export class Hover {
  // describe(target, t) answers {rows: [[name, value, ...]], notes: [text]} or null where there is nothing to tell; a
  // value may be [text, colour]
  constructor({ scale, describe, onMove }) {
    Object.assign(this, { scale, describe, onMove, last: null });
    $("rows").addEventListener("pointermove", (event) => this.move(event));
    $("rows").addEventListener("pointerleave", () => this.leave());
  }

  get left() {
    return $("ruler-label").offsetWidth;
  }

  move(event) {
    const box = $("rows").getBoundingClientRect();
    const x = event.clientX - box.left - this.left;
    if (x < this.scale.left || x > this.scale.right || event.buttons) return this.leave();
    return this.tell(event.target, this.scale.t(x), { x: event.clientX - box.left, y: event.clientY - box.top }, () => this.move(event));
  }

  // By keys: at a moment, half-way down what is read.
  put(target, t) {
    const [at, box] = [target.getBoundingClientRect(), $("rows").getBoundingClientRect()];
    this.tell(target, t, { x: this.left + this.scale.x(t), y: (at.top + at.bottom) / 2 - box.top }, () => this.put(target, t));
  }

  tell(target, t, place, again) {
    const told = this.describe(target, t);
    if (!told) return this.leave();
    this.last = again;
    $("hover-line").hidden = false;
    $("hover-line").style.transform = `translateX(${this.left + this.scale.x(t)}px)`;
    this.onMove(t);
    return this.show([["Time", clockText(t, this.scale.end, { digits: 2 })], ...told.rows], told.notes, place);
  }

  // What is told may have changed under a pointer at rest.
  refresh() {
    this.last?.();
  }

  leave() {
    this.last = null;
    $("hover-line").hidden = true;
    $("tip").hidden = true;
    this.onMove(null);
  }

  show(rows, notes, { x, y }) {
    const tip = $("tip");
    const columns = Math.max(0, ...rows.map((row) => row.length - 1));
    const table = el("div", { class: "tip-rows" }, ...rows.flatMap(([name, ...values]) => [el("span", {}, name), ...values.map(cell), ...Array(columns - values.length).fill(null).map(() => el("b", {}))]));
    table.style.gridTemplateColumns = `auto repeat(${columns}, auto)`;
    tip.replaceChildren(...(rows.length ? [table] : []), ...notes.map((text) => el("p", {}, text)));
    tip.hidden = false;
    const box = $("rows").getBoundingClientRect();
    const right = x + 16 + tip.offsetWidth < box.width;
    tip.style.left = `${right ? x + 16 : Math.max(x - tip.offsetWidth - 16, 2)}px`;
    tip.style.top = `${Math.min(Math.max(y - tip.offsetHeight - 8, 2), Math.max(box.height - tip.offsetHeight - 2, 2))}px`;
  }

  // Words beside a mark, for the pointer and for the keyboard.
  note(node, lines) {
    const show = () => {
      const [at, box] = [node.getBoundingClientRect(), $("rows").getBoundingClientRect()];
      this.show([], lines, { x: at.left - box.left, y: at.bottom - box.top + 40 });
    };
    node.addEventListener("pointerenter", show);
    node.addEventListener("focus", show);
    for (const name of ["pointerleave", "blur"]) node.addEventListener(name, () => ($("tip").hidden = true));
  }
}
