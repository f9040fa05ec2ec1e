// The paths of the selected cases, overlaid: fetched when a case is selected, kept while the page is open.

import { $, el, setText } from "./dom.js";
import { getPath } from "./jobapi.js";
import { draw, plain, slotColor, slotDash } from "./jobplots.js";
import { scaleOf } from "./units.js";
import { longerThan } from "./format.js";

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

  show({ selected }) {
    for (const { n } of selected) this.fetch(n);
    const view = this.view();
    const given = selected.filter(({ n }) => this.known.get(n)?.columns?.[view.along]);
    const columns = given.map(({ n }) => this.known.get(n).columns);
    const [across, along] = [view.across, view.along].map((name) => scaleOfAll(columns.map((c) => c[name] ?? [0])));
    const traces = given.map(({ n, slot }, k) => this.trace(n, slot, { columns: columns[k], view, across, along }));
    Object.assign(this.box.dataset, { paths: given.length, cases: given.map(({ n }) => n).join(" ") });
    this.box.setAttribute("aria-label", `Paths of ${given.length} selected cases; their values are below`);
    this.box.hidden = selected.length === 0;
    $("paths-hint").hidden = selected.length > 0;
    const waits = selected.some(({ n }) => this.known.get(n) === undefined);
    setText($("paths-note"), waits ? "Fetching…" : "");
    if (selected.length === 0) return undefined;
    return draw(this.box, traces, {
      x: { title: `${view.x}, ${across.symbol}` }, y: { title: `${view.y}, ${along.symbol}`, autorange: view.down ? "reversed" : true }, hovermode: "closest",
    });
  }

  trace(n, slot, { columns, view, across, along }) {
    const zeros = columns[view.along].map(() => 0);
    const [x, y] = [columns[view.across] ?? zeros, columns[view.along]];
    const time = longerThan(columns.t?.at(-1) ?? 0);
    const text = y.map((v, i) => `Case ${n}<br>${plain(view.x)} ${across.withUnit(x[i])}<br>${plain(view.y)} ${along.withUnit(v)}${columns.t ? `<br>t ${(columns.t[i] / time.per).toFixed(1)} ${time.symbol}` : ""}`);
    return {
      type: "scatter", mode: "lines", x: x.map((v) => v * across.per), y: y.map((v) => v * along.per),
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

// The selected cases side by side: one row a value, one column a case.
export function showSelected({ table, selected, paths, job, links }) {
  const known = selected.filter(({ n }) => table.rows.has(n));
  $("selected").hidden = known.length === 0;
  $("selected").dataset.cases = known.map(({ n }) => n).join(" ");
  const head = known.map(({ n, slot }) => caseHead(n, slot, { job, problem: paths.problemOf(n), links }));
  const line = (name, cells, { unit = "", title = null } = {}) => el("tr", {}, el("th", { scope: "row", title }, name, unit ? el("small", {}, ` ${unit}`) : null), ...cells, el("td", { class: "rest" }));
  const rows = table.infos.map((info) => {
    const cells = known.map(({ n }) => el("td", {}, table.text(info.name, table.rows.get(n))));
    return line(table.words(info.name), cells, { unit: info.numeric ? table.scale(info.name).symbol : "", title: info.meaning });
  });
  const status = line("Ended", known.map(({ n }) => el("td", { title: table.reason[table.rows.get(n)] }, table.status[table.rows.get(n)])));
  $("selected-head").replaceChildren(el("th", { scope: "col" }, el("span", { class: "visually-hidden" }, "Value")), ...head, el("td", { class: "rest" }));
  $("selected-rows").replaceChildren(status, ...rows);
}

function caseHead(n, slot, { job, problem, links }) {
  const key = el("i", { class: "line-key", "aria-hidden": "true" });
  key.style.borderTop = `2.5px ${slotDash(slot) === "dash" ? "dashed" : "solid"} ${slotColor(slot)}`;
  return el("th", { scope: "col" },
    el("div", { class: "case-head" }, key, `Case ${n}`, el("button", { class: "btn small", type: "button", "aria-label": `Drop case ${n}`, title: "Drop it", "data-testid": `drop-${n}`, onclick: () => links.drop(n) }, "×")),
    el("div", { class: "case-links" },
      el("a", { href: links.studio(n), "data-testid": `open-case-${n}`, "aria-label": `Open case ${n} in the studio` }, "Open in the studio"),
      el("a", { href: links.design(n), download: `${job.id}-case-${n}.json`, "aria-label": `Download the design of case ${n}` }, "Download design")),
    problem ? el("p", { class: "case-problem" }, `No path: ${problem}`) : null);
}
