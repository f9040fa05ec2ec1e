// The table of the cases: filtered as the charts are, sorted by any column, a page at a time.

import { $, el, setText } from "./dom.js";
import { slotColor, slotDash } from "./jobplots.js";
import { reasonParts, whole } from "./jobwords.js";

const A_PAGE = 25;

export class CaseList {
  constructor({ onSelect }) {
    this.onSelect = onSelect;
    this.sort = { name: "case", falling: false };
    this.page = 0;
    $("page-before").addEventListener("click", () => this.turn(-1));
    $("page-after").addEventListener("click", () => this.turn(1));
    $("cases").addEventListener("keydown", (event) => this.press(event));
    $("case-rows").addEventListener("click", ({ target }) => !target.closest("button, a") && this.select(target.closest("tr")));
  }

  show(values) {
    const filtered = values.filterKey !== this.filterKey;
    if (filtered) this.page = 0;
    Object.assign(this, values);
    this.rows = this.sorted();
    this.pages = Math.max(1, Math.ceil(this.rows.length / A_PAGE));
    this.page = Math.min(this.page, this.pages - 1);
    this.drawHead();
    this.draw();
  }

  turn(by) {
    this.page = Math.min(Math.max(this.page + by, 0), this.pages - 1);
    this.draw();
  }

  key(name) {
    const { table } = this;
    if (name === "case") return table.cases;
    if (name === "status") return table.status;
    return table.values.get(name) ?? table.texts.get(name).map((v) => JSON.stringify(v));
  }

  // Those without a value come last, whichever way round.
  sorted() {
    const { name, falling } = this.sort;
    const rows = [...this.passing.keys()].filter((i) => this.passing[i]);
    const values = this.key(name);
    const sign = falling ? -1 : 1;
    const missing = (v) => v === null || Number.isNaN(v);
    return rows.sort((a, b) => {
      const [u, v] = [values[a], values[b]];
      if (missing(u) || missing(v)) return missing(u) - missing(v) || a - b;
      return u < v ? -sign : u > v ? sign : a - b;
    });
  }

  drawHead() {
    const names = ["case", "status", ...this.table.infos.map(({ name }) => name)];
    const key = JSON.stringify([names, names.slice(2).map((name) => this.table.label(name)), this.sort]);
    if (key === this.headKey) return;
    this.headKey = key;
    const focused = document.activeElement?.dataset?.sort;
    $("case-head").replaceChildren(...names.map((name) => this.headCell(name)));
    if (focused) $("case-head").querySelector(`[data-sort=${CSS.escape(focused)}]`)?.focus();
  }

  headCell(name) {
    const info = this.table.info.get(name);
    const here = this.sort.name === name;
    const text = info ? this.table.words(name) : name === "case" ? "Case" : "Ended";
    const unit = info?.numeric ? this.table.scale(name).symbol : "";
    const button = el("button", { type: "button", class: "sort", "data-sort": name, title: info?.meaning, onclick: () => this.sortBy(name) }, text, unit ? el("small", {}, ` ${unit}`) : null);
    return el("th", { scope: "col", class: info?.numeric ? "number" : null, "aria-sort": here ? (this.sort.falling ? "descending" : "ascending") : "none" }, button);
  }

  sortBy(name) {
    this.sort = { name, falling: this.sort.name === name && !this.sort.falling };
    this.page = 0;
    this.rows = this.sorted();
    this.drawHead();
    this.draw();
  }

  draw() {
    const focused = document.activeElement?.dataset?.case;
    const first = this.page * A_PAGE;
    const shown = this.rows.slice(first, first + A_PAGE);
    $("case-rows").replaceChildren(...shown.map((i) => this.row(i)));
    if (focused) $("case-rows").querySelector(`[data-case="${focused}"]`)?.focus({ preventScroll: true });
    $("cases").dataset.rows = this.rows.length;
    $("no-cases").hidden = this.rows.length > 0;
    $("cases").hidden = this.rows.length === 0;
    $("pager").hidden = this.pages < 2;
    $("page-before").disabled = this.page === 0;
    $("page-after").disabled = this.page === this.pages - 1;
    setText($("page-text"), `${whole(first + 1)} to ${whole(first + shown.length)} of ${whole(this.rows.length)}`);
  }

  row(i) {
    const { table } = this;
    const n = table.cases[i];
    const chosen = this.selected.find((s) => s.n === n);
    const key = el("i", { class: "line-key", "aria-hidden": "true" });
    if (chosen) key.style.borderTop = `2.5px ${slotDash(chosen.slot) === "dash" ? "dashed" : "solid"} ${slotColor(chosen.slot)}`;
    const button = el("button", { type: "button", class: "case-button", "data-case": n, "aria-pressed": String(Boolean(chosen)), "aria-label": `Case ${n}: ${chosen ? "drop" : "show"} its path`, "data-testid": `case-${n}`, onclick: () => this.onSelect(n) }, key, String(n));
    const failed = table.group[i] !== null;
    const why = failed && table.reason[i] ? el("small", { title: table.reason[i] }, reasonParts(table.reason[i])[0].text) : null;
    return el("tr", { "data-row": n, class: chosen ? "chosen" : null },
      el("td", {}, button), el("td", { class: failed ? "ended failed" : "ended" }, table.status[i], why),
      ...table.infos.map((info) => el("td", { class: info.numeric ? "number" : null }, table.text(info.name, i))));
  }

  select(row) {
    if (row) this.onSelect(Number(row.dataset.row));
  }

  press(event) {
    const step = { j: 1, ArrowDown: 1, k: -1, ArrowUp: -1 }[event.key];
    if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
    const buttons = [...$("case-rows").querySelectorAll(".case-button")];
    const at = buttons.indexOf(document.activeElement);
    buttons[Math.min(Math.max(at + step, 0), buttons.length - 1)]?.focus();
    event.preventDefault();
  }
}
