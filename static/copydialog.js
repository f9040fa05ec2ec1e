// The dialog in which a schedule is copied to another cell, or shifted and stretched in its own.

import { el, setText } from "./dom.js";
import { refusalBox, showRefusal } from "./refusal.js";
import { GAP } from "./schedule.js";
import { converted, shifted, stretched } from "./schedulecopy.js";

const MIRRORS = [["same", "The same"], ["change", "The same change from neutral"], ["mirrored", "Mirrored about neutral"]];

const field = (label, input, unit) => el("label", { class: "field" }, el("span", {}, label), input, unit ? el("u", {}, unit) : null);
const option = ([value, words]) => el("option", { value }, words);

export class CopyDialog {
  // set: lanes, put(cell, points), which answers the problem why it was refused, or null
  constructor(set) {
    this.set = set;
    this.waiting = false;
    this.to = el("select", { "data-testid": "copy-to" });
    this.how = el("select", { "data-testid": "copy-how" }, ...MIRRORS.map(option));
    this.later = el("input", { type: "number", step: "any", value: "0", required: true, "data-testid": "copy-later" });
    this.factor = el("input", { type: "number", step: "any", min: "0.001", value: "1", required: true, "data-testid": "copy-factor" });
    this.wrap = el("input", { type: "checkbox", "data-testid": "copy-wrap" });
    this.note = el("p", { class: "fine", role: "status", "data-testid": "copy-note" });
    this.refusal = refusalBox("copy-refused");
    this.title = el("h2", { id: "copy-title" });
    this.apply = el("button", { type: "submit", class: "btn primary", "data-testid": "copy-apply" });
    this.root = this.build();
    document.body.append(this.root);
  }

  build() {
    const cancel = el("button", { type: "button", class: "btn", "data-testid": "copy-cancel", onclick: () => this.root.close() }, "Cancel");
    const form = el("form", { method: "dialog", class: "body" }, this.title, field("To", this.to), field("Extensions", this.how),
      field("Later by", this.later, "s"), field("Stretched", this.factor, "×"),
      el("label", { class: "check" }, this.wrap, "Wrap round the end of the mission"), this.note, this.refusal,
      el("div", { class: "actions" }, cancel, this.apply));
    form.addEventListener("input", () => this.show());
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.send();
    });
    return el("dialog", { class: "dialog copy-schedule", "aria-labelledby": "copy-title", "data-testid": "copy-dialog" }, form);
  }

  // To itself where `to` says so; else to the cell across the plane of symmetry, or the next that can take it.
  open(lane, { to } = {}) {
    this.lane = lane;
    const { cell } = lane.schedule;
    const partner = this.set.list.find((each) => each.component.index === lane.component.partner)?.schedule.cell;
    const able = this.set.list.filter((each) => !each.fixed && each.unit.symbol === lane.unit.symbol);
    const words = (each) => (each === lane ? `${cell} itself` : each.schedule.cell === partner ? `${partner} (across)` : each.schedule.cell);
    this.to.replaceChildren(...able.map((each) => option([each.schedule.cell, words(each)])));
    const others = able.filter((each) => each !== lane).map((each) => each.schedule.cell);
    this.to.value = to ?? (others.includes(partner) ? partner : others[0] ?? cell);
    setText(this.title, to ? `Shift or stretch: ${cell}` : `Copy the schedule of ${cell}`);
    this.later.value = "0";
    this.factor.value = "1";
    this.wrap.checked = false;
    this.how.value = "same";
    this.show();
    this.root.showModal();
    (to ? this.later : this.to).focus();
  }

  get target() {
    return this.set.lanes.get(this.to.value);
  }

  // What the target's schedule will be, and how many of its points its stops cut.
  made() {
    const { lane, target } = this;
    const by = this.later.valueAsNumber;
    const factor = this.factor.valueAsNumber;
    if (!target || !Number.isFinite(by) || !(factor > 0)) return null;
    const start = lane.startValue();
    const moved = shifted(stretched(lane.schedule.points, factor), by, { start, duration: lane.duration, wrap: this.wrap.checked, gap: GAP });
    return converted(moved, this.how.value, { source: lane.component, target: target.component });
  }

  show() {
    const { lane } = this;
    showRefusal(this.refusal, null);
    setText(this.apply, this.target === this.lane ? "Apply" : "Copy");
    const made = this.made();
    const beyond = made?.points.filter(({ time }) => time > this.lane.duration).length;
    const parts = !made ? ["Give a time, and a stretch above 0."] : [
      made.points.length ? `${made.points.length} points, from ${lane.moment(made.points[0].time)} to ${lane.moment(made.points.at(-1).time)}.` : "No point is left within the mission.",
      made.cut ? `${made.cut} held back by the stops of ${this.to.value}.` : "",
      beyond ? `${beyond} after the mission's end.` : "",
      this.target !== this.lane && this.target?.schedule.points.length ? `Replaces its ${this.target.schedule.points.length} points.` : "",
    ];
    setText(this.note, parts.filter(Boolean).join(" "));
    this.apply.disabled = !made?.points.length;
  }

  // Open until the server has taken it: what was typed must not be lost with a refusal.
  async send() {
    const made = this.made();
    if (!made?.points.length || this.waiting) return;
    this.waiting = true;
    const problem = await this.set.put(this.to.value, made.points);
    this.waiting = false;
    if (problem) showRefusal(this.refusal, problem);
    else this.root.close();
  }
}
