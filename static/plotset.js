// The plots below the lanes: which there are, what each shows, and their rows on the page.

import { $, el } from "./dom.js";
import { colorOf } from "./keptruns.js";
import { Legend } from "./legend.js";
import { MOST_PLOTS, emptyPlot, firstPlots, moved, readPlots, writePlots } from "./plotchoice.js";
import { PlotData } from "./plotdata.js";
import { focusByKeysOnly } from "./plotcursor.js";
import { openPicker } from "./plotpicker.js";
import { TimePlot } from "./plots.js";
import { runsByColor, seriesOf } from "./plotseries.js";
import { drawTimeAxis } from "./timeaxis.js";

class PlotRow {
  constructor(scale, { onMenu }) {
    this.canvas = el("canvas", { role: "slider", tabindex: 0, "aria-valuenow": 0 });
    focusByKeysOnly(this.canvas);
    this.menu = el("button", { type: "button", class: "plot-menu", "aria-haspopup": "dialog", onclick: () => onMenu(this) }, "⋯");
    const label = el("div", { class: "label" });
    this.legend = new Legend(label, this.menu);
    this.root = el("div", { class: "row plot" }, label, el("div", { class: "cell" }, this.canvas));
    this.plot = new TimePlot(this.canvas, scale);
  }

  // `place` from 0.
  name(place, title) {
    this.canvas.setAttribute("aria-label", `Plot ${place + 1}: ${title || "nothing chosen"}, over time`);
    this.canvas.dataset.testid = `plot-${place}`;
    this.root.dataset.testid = `plot-row-${place}`;
    this.menu.dataset.testid = `plot-menu-${place}`;
    this.menu.setAttribute("aria-label", `Plot ${place + 1}: outputs and range`);
    this.menu.title = "Outputs, range, order";
  }
}

export class PlotSet {
  // `onRows` is called when the rows changed, so that the layout follows.
  constructor({ scale, clock, onRows }) {
    Object.assign(this, { scale, clock, onRows, picker: null, rows: [], model: null, choices: [], hiddenKept: new Set(), drawTime: 0, cursor: null });
    this.data = new PlotData(() => this.refresh());
    $("add-plot").addEventListener("click", () => this.add());
  }

  update(state) {
    this.state = state;
    this.data.setState(state);
    const model = state.run?.model ?? state.model;
    if (model !== this.model) this.load(model);
    this.fill();
  }

  load(model) {
    this.model = model;
    this.choices = readPlots(model);
  }

  // Another choice of plots; kept for runs of this model.
  choose(choices) {
    this.choices = choices;
    writePlots(this.model, choices);
    this.fill();
    this.onRows();
  }

  change(k, changes) {
    this.choose(this.choices.map((each, place) => (place === k ? { ...each, ...changes } : each)));
  }

  add() {
    if (this.choices.length >= MOST_PLOTS) return;
    this.choose([...this.choices, emptyPlot()]);
    this.rows.at(-1).root.scrollIntoView({ block: "nearest" });
    this.open(this.rows.at(-1));
  }

  remove(k) {
    this.choose(this.choices.filter((_, place) => place !== k));
  }

  move(k, by) {
    this.choose(moved(this.choices, k, by));
    return Math.min(Math.max(k + by, 0), this.choices.length - 1);
  }

  reset() {
    this.choose(firstPlots(this.model));
  }

  open(row) {
    this.picker = openPicker(this, this.rows.indexOf(row));
  }

  // Rows as many as chosen, each with its curves as far as they are known.
  fill() {
    while (this.rows.length > this.choices.length) this.rows.pop().root.remove();
    while (this.rows.length < this.choices.length) {
      const row = new PlotRow(this.scale, { onMenu: (each) => this.open(each) });
      this.rows.push(row);
      $("plots").append(row.root);
    }
    $("add-plot").disabled = this.choices.length >= MOST_PLOTS;
    this.data.need([...new Set(this.choices.flatMap(({ outputs }) => outputs))]);
    const cellColors = new Map((this.state?.components ?? []).map(({ name, color }) => [name, color]));
    this.choices.forEach(({ outputs, ranges }, place) => {
      const { plot, legend } = this.rows[place];
      plot.show(runsByColor(outputs.flatMap((name, k) => this.seriesFor(name, k, cellColors))), { ranges, run: this.state?.run ?? null });
      this.rows[place].name(place, plot.title);
      legend.show(plot);
    });
  }

  seriesFor(name, place, cellColors) {
    const curve = this.data.curve(name);
    if (!curve) return [];
    const kept = this.shownKept.flatMap((run) => {
      const found = this.data.keptCurve(run.id, name);
      return found ? [{ ...found, color: colorOf(run).slice(4, -1), name: run.name }] : [];
    });
    return [{ ...seriesOf(name, curve.unit, { place, cellColors }), ...curve, kept }];
  }

  get shownKept() {
    return this.data.kept.filter(({ id }) => !this.hiddenKept.has(id));
  }

  // Curves have come, or kept runs were shown or hidden.
  refresh() {
    this.fill();
    this.draw();
    this.showTime(this.clock.t);
    this.picker?.showRanges();
  }

  draw() {
    const begun = performance.now();
    for (const { plot } of this.rows) plot.draw();
    drawTimeAxis($("time-axis"), this.scale);
    this.drawTime = performance.now() - begun; // ms, for tests
  }

  showTime(t) {
    for (const { plot, legend } of this.rows) legend.write(plot.describe(t));
  }

  showCursor(t) {
    for (const { plot, legend } of this.rows) legend.writeCursor(t === null ? null : plot.describe(t));
  }

  plotOf(canvas) {
    return this.rows.find((row) => row.canvas === canvas)?.plot ?? null;
  }
}
