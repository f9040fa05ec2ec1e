// The small popover in which a schedule point's numbers are typed.

import { el, setText } from "./dom.js";

function field(label, unit, input) {
  return el("label", { class: "field" }, el("span", {}, label), input, typeof unit === "string" ? el("u", {}, unit) : unit);
}

export class PointEditor {
  constructor({ onApply, onDelete }) {
    this.onApply = onApply;
    this.onDelete = onDelete;
    this.time = el("input", { type: "number", step: "any", min: "0", required: true, "data-testid": "point-time" });
    this.extension = el("input", { type: "number", step: "any", required: true, "data-testid": "point-extension" });
    this.unit = el("u", {}, "mm");
    this.shape = el("select", { "data-testid": "point-shape" },
      el("option", { value: "step" }, "Step at this time"), el("option", { value: "ramp" }, "Ramp up to this time"));
    this.title = el("strong", {});
    this.root = this.build();
    document.body.append(this.root);
    document.addEventListener("pointerdown", (event) => this.root.contains(event.target) || this.close());
  }

  build() {
    const remove = el("button", { type: "button", class: "btn", "data-testid": "point-delete", onclick: () => this.remove() }, "Delete");
    const apply = el("button", { type: "submit", class: "btn primary", "data-testid": "point-apply" }, "Apply");
    const form = el("form", { class: "popover", role: "dialog", "aria-label": "Schedule point", hidden: true, "data-testid": "point-editor" },
      this.title, field("Time", "s", this.time), field("Extension", this.unit, this.extension), field("Shape", "", this.shape),
      el("div", { class: "actions" }, remove, apply));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.apply();
    });
    form.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key === "Escape") this.close(true);
    });
    return form;
  }

  open({ cell, k, point, anchor, unit }) {
    this.target = { cell, k };
    this.per = unit.per;
    setText(this.unit, unit.symbol);
    this.anchor = anchor;
    this.title.textContent = `${cell}, point ${k + 1}`;
    this.time.value = String(Number(point.time.toFixed(4)));
    this.extension.value = String(Number((point.extension * this.per).toFixed(4)));
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

  apply() {
    const point = { time: this.time.valueAsNumber, extension: this.extension.valueAsNumber / this.per, shape: this.shape.value };
    if (!Number.isFinite(point.time) || !Number.isFinite(point.extension)) return;
    this.close(true);
    this.onApply(this.target, point);
  }

  remove() {
    this.close();
    this.onDelete(this.target);
  }
}
