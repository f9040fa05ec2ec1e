// The small popover in which a schedule point's numbers are typed.

import { el, setText } from "./dom.js";
import { refusalBox, showRefusal } from "./refusal.js";

const FIGURES = 9; // of an extension: a micrometre in metres, and no tail of a conversion

function field(label, unit, input) {
  return el("label", { class: "field" }, el("span", {}, label), input, typeof unit === "string" ? el("u", {}, unit) : unit);
}

export class PointEditor {
  // onApply(target, point) answers the problem why the point was refused, or null.
  constructor({ onApply, onDelete }) {
    this.onApply = onApply;
    this.onDelete = onDelete;
    this.waiting = false;
    this.time = el("input", { type: "number", step: "any", min: "0", required: true, "data-testid": "point-time" });
    this.extension = el("input", { type: "number", step: "any", required: true, "data-testid": "point-extension" });
    this.unit = el("u", {}, "mm");
    this.shape = el("select", { "data-testid": "point-shape" },
      el("option", { value: "step" }, "Step at this time"), el("option", { value: "ramp" }, "Ramp up to this time"));
    this.title = el("strong", {});
    this.refusal = refusalBox("point-refused");
    this.root = this.build();
    document.body.append(this.root);
    document.addEventListener("pointerdown", (event) => this.root.contains(event.target) || this.close());
  }

  build() {
    const remove = el("button", { type: "button", class: "btn", "data-testid": "point-delete", onclick: () => this.remove() }, "Delete");
    const apply = el("button", { type: "submit", class: "btn primary", "data-testid": "point-apply" }, "Apply");
    const form = el("form", { class: "popover", role: "dialog", "aria-label": "Schedule point", hidden: true, "data-testid": "point-editor" },
      this.title, field("Time", "s", this.time), field("Extension", this.unit, this.extension), field("Shape", "", this.shape), this.refusal,
      el("div", { class: "actions" }, remove, apply));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.apply();
    });
    form.addEventListener("input", () => this.tell(null));
    form.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key === "Escape") this.close(true);
    });
    return form;
  }

  open({ cell, k, point, moment, anchor, unit }) {
    this.target = { cell, k };
    this.tell(null);
    this.per = unit.per;
    setText(this.unit, unit.symbol);
    this.anchor = anchor;
    this.title.textContent = `${cell}, point ${k + 1} at ${moment}`;
    this.time.value = String(Number(point.time.toFixed(4)));
    this.extension.value = String(Number((point.extension * this.per).toPrecision(FIGURES)));
    this.shape.value = point.shape === "ramp" ? "ramp" : "step";
    this.root.hidden = false;
    this.place(anchor.getBoundingClientRect());
    this.time.focus();
    this.time.select();
  }

  place(at) {
    const { offsetWidth: width, offsetHeight: height } = this.root;
    const left = Math.min(Math.max(at.left + at.width / 2 - width / 2, 8), innerWidth - width - 8);
    const above = at.top - height - 10;
    this.root.style.left = `${left}px`;
    this.root.style.top = `${above > 8 ? above : Math.min(at.bottom + 10, innerHeight - height - 8)}px`;
  }

  close(giveFocusBack = false) {
    if (this.root.hidden) return;
    this.root.hidden = true;
    if (giveFocusBack && this.anchor?.isConnected) this.anchor.focus();
  }

  // The fields that a refusal is about are marked, and its words stand under them.
  tell(problem) {
    const pointers = problem?.errors?.map(({ pointer }) => pointer ?? "") ?? [];
    for (const name of ["time", "extension", "shape"]) this[name].setAttribute("aria-invalid", String(pointers.some((pointer) => pointer.endsWith(`/${name}`))));
    showRefusal(this.refusal, problem);
  }

  // Open until the server has taken it: what was typed must not be lost with a refusal.
  async apply() {
    const point = { time: this.time.valueAsNumber, extension: this.extension.valueAsNumber / this.per, shape: this.shape.value };
    if (!Number.isFinite(point.time) || !Number.isFinite(point.extension) || this.waiting) return;
    const { target } = this;
    this.waiting = true;
    const problem = await this.onApply(target, point);
    this.waiting = false;
    if (this.target !== target || this.root.hidden) return;
    if (!problem) return void this.close(true);
    this.tell(problem);
    this.place(this.anchor.getBoundingClientRect());
  }

  remove() {
    this.close();
    this.onDelete(this.target);
  }
}
