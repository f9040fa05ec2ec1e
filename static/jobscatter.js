// The scatter of the cases over two columns, coloured by a third; a click on a point selects its case.

import { $, setText } from "./dom.js";
import { COLOR_SCALE, draw, plain, slotColor } from "./jobplots.js";
import { whole } from "./jobwords.js";
import { cssColor } from "./plotcanvas.js";
import { withUnit } from "./units.js";

const MOST_POINTS = 3000; // drawn as SVG: more would be slow to draw, and to see
const FOOT = 0.06; // of the height: how far below the points those without a value stand

const MOST_LETTERS = 90; // of a reason in a tooltip
const cut = (text) => (text.length > MOST_LETTERS ? `${text.slice(0, MOST_LETTERS).trimEnd()}…` : text);

export class Scatter {
  constructor(box, { onSelect }) {
    this.box = box;
    this.onSelect = onSelect;
  }

  // Rows to draw: each k-th of too many, the selected ones always.
  choose({ table, passing }) {
    const every = Math.max(1, Math.ceil(table.size / MOST_POINTS));
    const rows = { passing: [], others: [], failed: [] };
    const [x, y] = [table.values.get(this.x), table.values.get(this.y)];
    for (let i = 0; i < table.size; i += every) {
      if (table.group[i] !== null) {
        if (passing[i] && Number.isFinite(x[i])) rows.failed.push(i);
      } else if (Number.isFinite(x[i]) && Number.isFinite(y[i])) rows[passing[i] ? "passing" : "others"].push(i);
    }
    return { rows, every };
  }

  show({ table, passing, axes, selected }) {
    Object.assign(this, { table, x: axes.x, y: axes.y, color: axes.color });
    const { rows, every } = this.choose({ table, passing });
    this.foot = this.footOf();
    const traces = [this.others(rows.others), this.passing(rows.passing), this.failed(rows.failed), this.selected(selected)];
    Object.assign(this.box.dataset, { points: rows.passing.length, failed: rows.failed.length, selected: selected.length });
    const low = rows.failed.length ? ` ${whole(rows.failed.length)} failed: × at the foot.` : "";
    const part = every > 1 ? ` Every ${every === 2 ? "second" : every === 3 ? "third" : `${every}th`} case is drawn.` : "";
    setText($("scatter-note"), `${whole(rows.passing.length)} cases.${low}${part}`);
    this.box.setAttribute("aria-label", `Scatter of ${table.label(this.y)} over ${table.label(this.x)}; the table below holds the same cases`);
    const [x, y] = [this.axis(this.x), this.axis(this.y)];
    const drawn = draw(this.box, traces, { x, y, hovermode: "closest", uirevision: `${this.x} ${x.type} ${this.y} ${y.type}` });
    this.showKey();
    this.listen();
    return drawn;
  }

  axis(name) {
    const wide = this.table.isWide(name);
    return { title: wide ? `${this.table.label(name)} (logarithmic)` : this.table.label(name), type: wide ? "log" : "linear" };
  }

  // What the colours say, beside the choice of their column.
  showKey() {
    $("color-key").hidden = !this.color;
    if (!this.color) return;
    const scale = this.table.scale(this.color);
    const [low, high] = this.table.bounds(this.color);
    setText($("color-low"), scale.brief(low));
    setText($("color-high"), withUnit(scale.brief(high), scale.symbol));
  }

  listen() {
    if (this.listening) return;
    this.listening = true;
    this.box.on("plotly_click", ({ points: [point] }) => point.customdata !== undefined && this.onSelect(point.customdata));
  }

  column(name, rows) {
    const { per } = this.table.scale(name);
    const values = this.table.values.get(name);
    return rows.map((i) => values[i] * per);
  }

  footOf() {
    const [low, high] = this.table.bounds(this.y).map((v) => v * this.table.scale(this.y).per);
    if (this.table.isWide(this.y)) return low * (low / high) ** FOOT;
    return low - FOOT * (high - low || Math.abs(high) || 1);
  }

  // Height of a row's point: a failed case may have no value.
  heights(rows) {
    return this.column(this.y, rows).map((v, k) => (Number.isFinite(v) && this.isGiven(rows[k]) ? v : this.foot));
  }

  isGiven(row) {
    return this.table.group[row] === null || this.table.info.get(this.y).role === "parameter";
  }

  hover(i) {
    const { table } = this;
    const names = [...new Set([this.x, this.y, this.color].filter(Boolean))];
    const lines = names.map((name) => `${plain(table.words(name))} ${plain(table.textWithUnit(name, i))}`);
    const why = table.group[i] === null ? [] : [plain(cut(table.reason[i] ?? table.status[i])), "Click: why, and what can be opened"];
    return [`Case ${table.cases[i]}`, ...lines, ...why].join("<br>");
  }

  trace(rows, marker, more = {}) {
    return {
      type: "scatter", mode: "markers", x: this.column(this.x, rows), y: this.heights(rows), marker,
      customdata: rows.map((i) => this.table.cases[i]), text: rows.map((i) => this.hover(i)), hovertemplate: "%{text}<extra></extra>", ...more,
    };
  }

  size(count) {
    return count > 2000 ? 4 : count > 400 ? 5 : 7;
  }

  others(rows) {
    return this.trace(rows, { color: cssColor("--faint"), size: 4, opacity: 0.25 }, { hoverinfo: "skip", hovertemplate: null });
  }

  passing(rows) {
    const marker = { size: this.size(rows.length), opacity: rows.length > 400 ? 0.8 : 0.95, color: cssColor("--series-1") };
    if (this.color) {
      const [low, high] = this.table.bounds(this.color).map((v) => v * this.table.scale(this.color).per);
      Object.assign(marker, { color: this.column(this.color, rows), colorscale: COLOR_SCALE(), cmin: low, cmax: high });
    }
    return this.trace(rows, marker);
  }

  failed(rows) {
    return this.trace(rows, { symbol: "x-thin", size: 6, line: { color: cssColor("--bad"), width: 1.4 } });
  }

  selected(selected) {
    const known = selected.filter(({ n }) => this.table.rows.has(n));
    const rows = known.map(({ n }) => this.table.rows.get(n));
    const line = { color: known.map(({ slot }) => slotColor(slot)), width: 2.5 };
    return this.trace(rows, { symbol: "circle-open", size: 14, color: line.color, line });
  }

  // Where a case's point is on the screen, for tests.
  pointAt(n) {
    const { xaxis, yaxis } = this.box._fullLayout;
    const frame = this.box.getBoundingClientRect();
    const row = this.table.rows.get(n);
    const [x, y] = [this.column(this.x, [row])[0], this.heights([row])[0]];
    return { x: frame.left + xaxis._offset + xaxis.d2p(x), y: frame.top + yaxis._offset + yaxis.d2p(y) };
  }
}
