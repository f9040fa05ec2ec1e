// The panel of one plot: which outputs it shows, its ranges, its place among the others.

import { el, setText } from "./dom.js";
import { openFloating, place } from "./floating.js";
import { MOST_OUTPUTS } from "./plotchoice.js";
import { axisOf, shortName } from "./plotseries.js";
import { scaleOf } from "./units.js";

const written = (unit) => scaleOf(unit, 1, 1).symbol || "–"; // of no size in particular

function matches({ name, label, cell }, words) {
  const text = `${name} ${shortName(name)} ${label} ${cell ?? ""}`.toLowerCase();
  return words.every((word) => text.includes(word));
}

class Picker {
  constructor(set, k) {
    Object.assign(this, { set, k, items: [], boxes: [] });
    this.search = el("input", { type: "search", placeholder: "Search outputs", "aria-label": "Search outputs", "data-testid": "output-search" });
    this.list = el("div", { class: "output-list", role: "group", "aria-label": "Outputs", "data-testid": "output-list" });
    this.note = el("p", { class: "fine", role: "status" });
    this.ranges = el("div", { class: "ranges" });
    this.search.addEventListener("input", () => this.filter());
    this.search.addEventListener("keydown", (event) => event.key === "ArrowDown" && (event.preventDefault(), this.list.querySelector("input:enabled")?.focus()));
    this.list.addEventListener("keydown", (event) => this.walk(event));
  }

  get choice() {
    return this.set.choices[this.k];
  }

  async open() {
    this.panel = openFloating(this.set.rows[this.k].menu, { class: "floating picker", role: "dialog", "aria-label": `Plot ${this.k + 1}`, "data-testid": "plot-picker" },
      [this.search, this.list, this.note, this.ranges, this.keptRow(), this.actions()], { onClose: () => (this.set.picker = null) });
    this.panel.addEventListener("keydown", (event) => event.stopPropagation());
    this.search.focus();
    this.showRanges();
    try {
      this.items = await this.set.data.list();
    } catch (error) {
      return setText(this.note, error.problem?.detail ?? error.problem?.title ?? error.message);
    }
    return this.fillList();
  }

  // What is shown already stands first.
  fillList() {
    const { outputs } = this.choice;
    const first = outputs.flatMap((name) => this.items.filter((item) => item.name === name));
    const rest = this.items.filter((item) => !outputs.includes(item.name));
    this.boxes = [...first, ...rest].map((item) => {
      const box = el("input", { type: "checkbox", "data-testid": `output-${item.name}` });
      box.checked = outputs.includes(item.name);
      box.addEventListener("change", () => this.toggle(item, box.checked));
      const row = el("label", { title: item.label }, box, el("span", {}, shortName(item.name)), el("small", {}, item.label), el("u", {}, written(item.unit)));
      return { item, box, row };
    });
    this.list.replaceChildren(...this.boxes.map(({ row }) => row));
    this.filter();
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { item, row } of this.boxes) row.hidden = !matches(item, words);
    this.allow();
  }

  // Two axes at most, and as many curves as can be told apart.
  allow() {
    const { outputs } = this.choice;
    const unit = (name) => this.items.find((item) => item.name === name)?.unit;
    const axes = new Set(outputs.map((name) => axisOf(name, unit(name))));
    const full = outputs.length >= MOST_OUTPUTS;
    for (const { item, box } of this.boxes) box.disabled = !box.checked && (full || (axes.size >= 2 && !axes.has(axisOf(item.name, item.unit))));
    const none = this.boxes.length > 0 && this.boxes.every(({ row }) => row.hidden);
    setText(this.note, none ? "No output is named like that." : full ? `A plot shows ${MOST_OUTPUTS} outputs at most: add another plot.` : axes.size >= 2 ? "Two units at most in a plot: others go into another plot." : "");
  }

  toggle({ name }, on) {
    const outputs = on ? [...this.choice.outputs, name] : this.choice.outputs.filter((each) => each !== name);
    this.set.change(this.k, { outputs, ranges: { left: null, right: null } });
    this.allow();
    this.showRanges();
  }

  walk(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const all = this.boxes.filter(({ row, box }) => !row.hidden && !box.disabled).map(({ box }) => box);
    const at = all.indexOf(document.activeElement) + step;
    (at < 0 ? this.search : all[Math.min(at, all.length - 1)])?.focus();
  }

  showRanges() {
    const { axes } = this.set.rows[this.k].plot;
    this.ranges.replaceChildren(...axes.map((axis) => this.rangeRow(axis)));
    place(this.panel, this.set.rows[this.k].menu); // it has another height now
  }

  // Two numbers fix it; emptied, the range follows the curves again.
  rangeRow(axis) {
    const side = axis.right ? "right" : "left";
    const kept = this.choice.ranges[side];
    const box = (words, value, shown) => el("input", { type: "number", step: "any", "aria-label": `${words}, ${side} axis`, value: value ?? "", placeholder: shown?.toPrecision(3), "data-testid": `range-${side}-${words.toLowerCase()}` });
    const [low, high] = [box("From", kept?.[0], axis.low), box("To", kept?.[1], axis.high)];
    const apply = () => {
      const range = [low.valueAsNumber, high.valueAsNumber];
      const right = range.every(Number.isFinite) && range[0] < range[1];
      high.setCustomValidity(right || !low.value || !high.value ? "" : "The upper end must be above the lower one");
      high.reportValidity();
      this.set.change(this.k, { ranges: { ...this.choice.ranges, [side]: right ? range : null } });
    };
    low.addEventListener("change", apply);
    high.addEventListener("change", apply);
    return el("div", { class: "axis-range" }, el("span", {}, axis.right ? "Right axis" : "Left axis"), low, el("i", {}, "to"), high, el("u", {}, axis.symbol));
  }

  keptRow() {
    const { kept } = this.set.data;
    if (!kept.length) return el("p", { class: "fine" }, "Runs you keep are laid over the present one.");
    const boxes = kept.map((run) => {
      const box = el("input", { type: "checkbox", "data-testid": `show-kept-${run.id}` });
      box.checked = !this.set.hiddenKept.has(run.id);
      box.addEventListener("change", () => {
        this.set.hiddenKept[box.checked ? "delete" : "add"](run.id);
        this.set.refresh();
      });
      const mark = el("i", { class: "swatch", "aria-hidden": "true" });
      mark.style.background = `var(--kept-${run.place + 1})`;
      return el("label", {}, box, mark, run.name);
    });
    return el("fieldset", { class: "kept-shown" }, el("legend", {}, "Laid over, in all plots"), ...boxes);
  }

  actions() {
    const button = (words, act, testid, more = {}) => el("button", { type: "button", class: "btn small", "data-testid": testid, onclick: act, ...more }, words);
    const move = (by) => () => (this.k = this.set.move(this.k, by));
    return el("div", { class: "actions" },
      button("Up", move(-1), "plot-up"), button("Down", move(1), "plot-down"),
      button("As at first", () => (this.panel.hidePopover(), this.set.reset()), "plots-reset", { title: "All plots as they were before any was changed" }),
      button("Remove", () => (this.panel.hidePopover(), this.set.remove(this.k)), "plot-remove"));
  }
}

export function openPicker(set, k) {
  const picker = new Picker(set, k);
  picker.open();
  return picker;
}
