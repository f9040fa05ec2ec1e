// What decides a metric, as small tables with colour or bars in them: correlations, and sensitivity indices.

import { $, el, setText } from "./dom.js";
import { fixed } from "./format.js";
import { scaleOf } from "./units.js";

const MOST_COLOR = 44; // per cent: text stays readable on it

// Orange where they rise together, blue where one falls, as strong as the correlation.
function shade(cell, value) {
  if (value === null) return;
  cell.style.background = `color-mix(in srgb, var(--series-${value > 0 ? 2 : 1}) ${Math.round(Math.abs(value) * MOST_COLOR)}%, var(--raised))`;
}

export function showCorrelations({ table, summary, axes, onPick }) {
  const pairs = (summary?.correlations ?? []).filter(({ parameter, metric }) => table.info.has(parameter) && table.info.has(metric));
  const usable = pairs.filter(({ pearson, spearman }) => pearson !== null || spearman !== null);
  $("correlations-panel").hidden = usable.length === 0;
  if (usable.length === 0) return;
  const how = document.querySelector("[name=correlation]:checked").value;
  const parameters = [...new Set(usable.map(({ parameter }) => parameter))];
  const metrics = [...new Set(usable.map(({ metric }) => metric))];
  const found = new Map(usable.map((pair) => [JSON.stringify([pair.parameter, pair.metric]), pair]));
  const cell = (metric, parameter) => {
    const pair = found.get(JSON.stringify([parameter, metric]));
    const value = pair?.[how] ?? null;
    const here = axes.x === parameter && axes.y === metric;
    const label = `${table.words(metric)} over ${table.words(parameter)}: ${fixed(value, 2)}. Show them in the scatter`;
    const button = el("button", { type: "button", "aria-label": label, "aria-pressed": String(here), title: pair ? `${pair.count} cases` : null, onclick: () => onPick(parameter, metric) }, fixed(value, 2));
    shade(button, value);
    return el("td", {}, button);
  };
  const focused = document.activeElement?.getAttribute("aria-label");
  $("correlations-head").replaceChildren(el("td"), ...parameters.map((name) => el("th", { scope: "col" }, el("span", {}, table.words(name)))));
  $("correlations-rows").replaceChildren(...metrics.map((metric) => el("tr", {}, el("th", { scope: "row", title: table.info.get(metric).meaning }, table.words(metric)), ...parameters.map((p) => cell(metric, p)))));
  if (focused) [...$("correlations-rows").querySelectorAll("button")].find((b) => b.getAttribute("aria-label") === focused)?.focus();
}

function bar(value, most, half) {
  const [fill, whisker] = [el("i"), el("u")];
  const part = (v) => `${most > 0 ? Math.min(Math.max((100 * v) / most, 0), 100) : 0}%`;
  fill.style.width = part(value);
  Object.assign(whisker.style, { left: part(value - half), width: part(Math.min(2 * half, most)) });
  return el("span", { class: "index-bar", "aria-hidden": "true" }, fill, half > 0 ? whisker : null);
}

const KINDS = {
  sobol: { columns: [["first", "Alone"], ["total", "With all interactions"]], note: "Shares of the variance; ± is half the 95 % interval." },
  morris: { columns: [["mu_star", "Mean size of effect"], ["sigma", "Spread of effect"]], note: "Change of the metric over a parameter's whole range." },
};

export function showIndices({ table, summary }) {
  const indices = summary?.indices ?? null;
  $("indices-panel").hidden = indices === null;
  if (indices === null) return;
  const select = $("index-metric");
  const names = Object.keys(indices);
  if (select.dataset.names !== names.join()) {
    select.dataset.names = names.join();
    select.replaceChildren(...names.map((name) => el("option", { value: name }, table.info.has(name) ? table.words(name) : name)));
    select.value = names.find((name) => indices[name].reason === null) ?? names[0];
  }
  showMetric(indices[select.value], { table, metric: select.value });
}

function showMetric(found, { table, metric }) {
  const kind = KINDS[found.method];
  $("indices").hidden = found.reason !== null;
  setText($("indices-note"), found.reason === null ? kind.note : `No indices: ${found.reason}.`);
  if (found.reason !== null) return;
  const columns = kind.columns.map(([key, label]) => ({ label, entries: Object.entries(found[key]).map(([name, v]) => [name, typeof v === "number" ? { value: v, half_width: 0 } : v]) }));
  const most = Math.max(...columns.flatMap(({ entries }) => entries.map(([, v]) => v.value + v.half_width)), found.method === "sobol" ? 1 : 0);
  const scale = found.method === "sobol" ? { show: (v) => fixed(v, 2), symbol: "" } : scaleOf(table.info.get(metric)?.unit ?? "1", 0, most);
  const sorted = columns.at(found.method === "sobol" ? 1 : 0).entries.toSorted((a, b) => b[1].value - a[1].value).map(([name]) => name);
  const cells = (name) => columns.flatMap(({ entries }) => {
    const { value, half_width: half } = entries.find(([key]) => key === name)[1];
    return [el("td", { class: "with-bar" }, bar(value, most, half)), el("td", { class: "number" }, scale.show(value), half > 0 ? el("small", {}, ` ± ${scale.show(half)}`) : null)];
  });
  $("indices-head").replaceChildren(el("td"), ...columns.map(({ label }) => el("th", { scope: "colgroup", colspan: "2" }, scale.symbol ? `${label}, ${scale.symbol}` : label)));
  $("indices-rows").replaceChildren(...sorted.map((name) => el("tr", {}, el("th", { scope: "row" }, table.info.has(name) ? table.words(name) : name), ...cells(name))));
}
