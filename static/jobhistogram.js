// How a metric is spread: a histogram of the cases that pass, with their percentiles over it and their figures below.

import { $, el, setText } from "./dom.js";
import { isPart } from "./jobdata.js";
import { draw } from "./jobplots.js";
import { spreadOf } from "./jobspread.js";
import { whole } from "./jobwords.js";
import { cssColor } from "./plotcanvas.js";

const PERCENTILES = [["5", "dot"], ["25", "dash"], ["50", "solid"], ["75", "dash"], ["95", "dot"]];
const ROOM = 0.2; // of the axis: what a name over the plot needs

function bin(values, [low, high]) {
  const count = Math.min(Math.max(Math.round(Math.sqrt(values.length)), 6), 40);
  const width = (high - low) / count;
  const bins = new Array(count).fill(0);
  for (const v of values) bins[Math.min(Math.floor((v - low) / width), bins.length - 1)] += 1;
  return { bins, width };
}

// Of values that are all the same: a range with them in its middle.
const aroundOne = ([low, high]) => (high > low ? [low, high] : [low - (Math.abs(low) || 1) / 20, high + (Math.abs(high) || 1) / 20]);

export class Histogram {
  constructor(box, { onBrush }) {
    Object.assign(this, { box, onBrush });
  }

  show({ table, passing, brushes, summary, metric, job }) {
    const scale = table.scale(metric);
    const column = table.values.get(metric);
    const values = [];
    for (let i = 0; i < table.size; i += 1) if (passing[i] && table.group[i] === null && Number.isFinite(column[i])) values.push(column[i]);
    const [low, high] = aroundOne(table.bounds(metric).map((v) => v * scale.per));
    const { bins, width } = bin(values.map((v) => v * scale.per), [low, high]);
    const middles = bins.map((_, k) => low + (k + 0.5) * width);
    const text = bins.map((n, k) => `${whole(n)} ${n === 1 ? "case" : "cases"} from ${scale.show((low + k * width) / scale.per)} to ${scale.withUnit((low + (k + 1) * width) / scale.per)}`);
    const trace = { type: "bar", x: middles, y: bins, width: width * 0.94, text, textposition: "none", hovertemplate: "%{text}<extra></extra>",
      marker: { color: cssColor("--series-1"), opacity: 0.75 }, customdata: middles.map((_, k) => [(low + k * width) / scale.per, (low + (k + 1) * width) / scale.per]) };
    const part = passing.includes(0);
    const some = isPart(table, job); // figures of all cases would not be those of these bars
    const about = part || some ? spreadOf(values) : summary?.metrics[metric];
    this.box.dataset.cases = values.length;
    this.box.setAttribute("aria-label", `Histogram of ${table.label(metric)}, ${values.length} cases; its figures are below`);
    this.readouts(about, scale);
    setText($("spread-note"), part ? partText(values.length, { brushes, passing }) : some ? `Of the first ${whole(table.size)} of ${whole(job.progress.done)} cases.` : wholeText(about, job));
    const drawn = draw(this.box, [trace], { x: { title: table.label(metric) }, y: { title: "Cases", rangemode: "tozero" }, bargap: 0, ...this.marks(about, { table, metric, scale }) });
    this.listen(metric);
    return drawn;
  }

  listen(metric) {
    this.metric = metric;
    if (this.listening) return;
    this.listening = true;
    this.box.on("plotly_click", ({ points: [point] }) => this.onBrush(this.metric, point.customdata));
  }

  marks(about, { table, metric, scale }) {
    if (!about?.count) return {};
    const at = PERCENTILES.map(([p, dash]) => ({ p, dash, x: about.percentiles[p] * scale.per })).filter(({ x }) => Number.isFinite(x));
    const line = (dash) => ({ color: cssColor("--ink"), width: 1.3, dash });
    const shapes = at.map(({ dash, x }) => ({ type: "line", x0: x, x1: x, y0: 0, y1: 1, yref: "paper", line: line(dash) }));
    const apart = ROOM * ((table.bounds(metric)[1] - table.bounds(metric)[0]) * scale.per || 1);
    const median = at.find(({ p }) => p === "50")?.x;
    const named = at.filter(({ p, x }) => p === "50" || (["5", "95"].includes(p) && Math.abs(x - median) > apart));
    const annotations = named.map(({ p, x }) => ({ x, y: 1, yref: "paper", yanchor: "bottom", showarrow: false, text: p === "50" ? "median" : `${p} %`, font: { size: 10.5, color: cssColor("--dim") } }));
    return { shapes, annotations, margin: { l: 12, r: 12, t: 24, b: 12 } };
  }

  readouts(about, scale) {
    const node = $("spread");
    if (!about?.count) return node.replaceChildren(el("p", { class: "fine" }, about ? "None of these cases has a value." : "No figures yet."));
    const { interval, percentiles } = about;
    const half = interval ? (interval.high - interval.low) / 2 : null;
    const percentile = (p) => scale.show(percentiles[p]);
    const mean = interval ? `${scale.show(about.mean)} ± ${scale.show(half)}` : scale.show(about.mean);
    const rows = [
      ["Mean", mean, interval && `± is half the ${Math.round(100 * interval.confidence)} % interval of the mean`], ["SD", scale.show(about.sd)],
      ["Least", scale.show(about.least)], ["Most", scale.show(about.most)],
      ["5 %", percentile("5")], ["95 %", percentile("95")], ["25 %", percentile("25")], ["75 %", percentile("75")], ["Median", percentile("50")],
    ];
    return node.replaceChildren(...rows.map(([name, value, note]) => el("div", { title: note }, el("dt", {}, name), el("dd", {}, value, " ", el("small", {}, scale.symbol)))));
  }
}

// What the figures are of, where a filter holds.
function partText(count, { brushes, passing }) {
  const shown = passing.reduce((sum, v) => sum + v, 0);
  const of = `${whole(shown)} ${brushes.size > 0 ? "brushed" : "filtered"} ${shown === 1 ? "case" : "cases"}`;
  return count === shown || count === 0 ? `Of ${of}.` : `Of ${of}; ${whole(count)} ${count === 1 ? "has" : "have"} a value.`;
}

function wholeText(about, job) {
  if (!about?.count) return "";
  const missing = about.missing ? `; ${whole(about.missing)} ${about.missing === 1 ? "has" : "have"} none` : "";
  const chance = about.interval ? ` ± is half the ${Math.round(100 * about.interval.confidence)} % interval of the mean.` : job.kind === "monte_carlo" ? "" : " No interval of the mean: the cases are laid out, not drawn.";
  return `Of all ${whole(about.count)} cases with a value${missing}.${chance}`;
}
