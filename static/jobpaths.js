// The paths of the selected cases, overlaid: fetched when a case is selected, kept while the page is open.

import { $, setText } from "./dom.js";
import { getPath } from "./jobapi.js";
import { draw, plain, slotColor, slotDash } from "./jobplots.js";
import { scaleOf } from "./units.js";

const VIEWS = {
  side: { across: "x", along: "z", x: "Along x", y: "Depth", down: true },
  above: { across: "y", along: "x", x: "East", y: "North", down: false },
};

export class Paths {
  constructor(box, { id, onChange }) {
    Object.assign(this, { box, id, onChange });
    this.known = new Map();
  }

  // What is known of a case's path: undefined (being fetched), {columns} or {problem}.
  async fetch(n) {
    if (this.known.has(n)) return;
    this.known.set(n, undefined);
    try {
      this.known.set(n, await getPath(this.id, n));
    } catch (error) {
      this.known.set(n, { problem: error.problem?.detail ?? error.message });
    }
    this.onChange();
  }

  // A job that runs again may compute a case anew.
  forget() {
    this.known.clear();
  }

  problemOf(n) {
    return this.known.get(n)?.problem ?? null;
  }

  view() {
    const turns = [...this.known.values()].some((path) => path?.columns?.y?.some((y) => Math.abs(y) > 1e-6));
    $("path-views").hidden = !turns;
    return VIEWS[turns ? document.querySelector("[name=path-view]:checked").value : "side"];
  }

  show({ table, selected }) {
    for (const { n } of selected) if (table.ran(n)) this.fetch(n);
    const view = this.view();
    const given = selected.filter(({ n }) => this.known.get(n)?.columns?.[view.along]);
    const columns = given.map(({ n }) => this.known.get(n).columns);
    const [across, along] = [view.across, view.along].map((name) => scaleOfAll(columns.map((c) => c[name] ?? [0])));
    const traces = given.map(({ n, slot }, k) => this.trace(n, slot, { columns: columns[k], view, across, along }));
    Object.assign(this.box.dataset, { paths: given.length, cases: given.map(({ n }) => n).join(" ") });
    this.box.setAttribute("aria-label", `Paths of ${given.length} selected cases; their values are below`);
    const waits = selected.some(({ n }) => table.ran(n) && this.known.get(n) === undefined);
    setText($("paths-note"), waits ? "Fetching…" : "");
    const none = given.length === 0 && !waits;
    this.box.hidden = none;
    this.hint(none, selected);
    if (none) return undefined;
    return draw(this.box, traces, {
      x: { title: `${view.x}, ${across.symbol}` }, y: { title: `${view.y}, ${along.symbol}`, autorange: view.down ? "reversed" : true }, hovermode: "closest",
    });
  }

  // Stands where the paths would, as long as there is none.
  hint(shown, selected) {
    $("paths-hint").hidden = !shown;
    $("show-telling").hidden = selected.length > 0;
    const none = selected.length === 1 ? `Case ${selected[0].n} has no path` : "None of the selected cases has a path";
    setText($("paths-hint-text"), selected.length > 0 ? `${none}: the reason is told below.` : "Click a point or a row: the path of its case is drawn here, several over each other.");
  }

  trace(n, slot, { columns, view, across, along }) {
    const zeros = columns[view.along].map(() => 0);
    const [x, y] = [columns[view.across] ?? zeros, columns[view.along]];
    const time = scaleOf("s", 0, columns.t?.at(-1) ?? 0);
    const text = y.map((v, i) => `Case ${n}<br>${plain(view.x)} ${across.withUnit(x[i])}<br>${plain(view.y)} ${along.withUnit(v)}${columns.t ? `<br>t ${time.withUnit(columns.t[i])}` : ""}`);
    return {
      type: "scatter", mode: "lines", x: x.map((v) => v && v * across.per), y: y.map((v) => v && v * along.per), // null stays null
      line: { color: slotColor(slot), dash: slotDash(slot), width: 2 }, text, hovertemplate: "%{text}<extra></extra>", name: `case ${n}`,
    };
  }
}

function scaleOfAll(columns) {
  let [low, high] = [Infinity, -Infinity];
  for (const column of columns) for (const v of column) [low, high] = [Math.min(low, v), Math.max(high, v)];
  return scaleOf("m", low <= high ? low : 0, low <= high ? high : 1);
}

// Least, middle and most of a metric among the cases that pass.
export function tellingCases({ table, passing, metric }) {
  const values = table.values.get(metric);
  const rows = [...values.keys()].filter((i) => passing[i] && table.group[i] === null && Number.isFinite(values[i]));
  rows.sort((a, b) => values[a] - values[b]);
  return [...new Set([rows[0], rows[rows.length >> 1], rows.at(-1)])].filter((i) => i !== undefined).map((i) => table.cases[i]);
}
