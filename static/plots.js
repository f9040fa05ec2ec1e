// A plot over time on canvas: drawn once per run, size, window or scheme; what moves is laid over it.

import { NONE } from "./format.js";
import { axesOf } from "./plotaxis.js";
import { cssColor, hatch, line, prepare, sayEmpty } from "./plotcanvas.js";
import { outsideStretches } from "./plotoutside.js";
import { locate, within } from "./series.js";
import { timeTicks } from "./timescale.js";

const TOP = 5;
const BOTTOM = 4;
export const KEPT_WIDTH = 1.3;
const OUTSIDE = 0.17; // how strong the hatch is: seen, and no hindrance to reading

const paint = (color) => (color.startsWith("--") ? cssColor(color) : color);

export class TimePlot {
  constructor(canvas, scale) {
    Object.assign(this, { canvas, scale, series: [], axes: [], ranges: {}, run: null });
  }

  // `series`: looks with their curves {t, values} and `kept` [{t, values, color, name}]; what has no axis is not drawn.
  show(series, { ranges, run }) {
    this.axes = axesOf(series);
    this.series = series.filter((s) => this.axes.some((axis) => axis.series.includes(s)));
    Object.assign(this, { ranges, run });
  }

  get title() {
    const [left, right] = this.axes;
    if (!left) return "";
    const names = left.series.length > 1 && left.symbol === "°" ? "Angles" : left.series.map((s) => s.label).join(" · ");
    const unit = ({ symbol }) => (symbol ? ` (${symbol})` : "");
    if (!right) return names + unit(left);
    const other = right.series.length === 1 ? right.series[0].label.toLowerCase() + unit(right) : right.symbol || "1";
    return `${names}${unit(left)}, ${other} at right`;
  }

  draw() {
    const height = this.canvas.parentElement.clientHeight;
    const context = prepare(this.canvas, this.scale.width, height);
    const inner = Math.max(height - TOP - BOTTOM, 1);
    for (const axis of this.axes) {
      axis.fit(this.ranges[axis.right ? "right" : "left"], this.scale);
      axis.place(TOP, inner);
    }
    this.drawGrid(context, inner);
    const middle = [(this.scale.left + this.scale.right) / 2, TOP + inner / 2];
    if (!this.run) return sayEmpty(context, ...middle);
    if (!this.series.length) return sayEmpty(context, ...middle, "Nothing chosen: ⋯ at the left has the outputs");
    context.save();
    context.beginPath();
    context.rect(this.scale.left, 0, this.scale.span, TOP + inner);
    context.clip();
    this.drawOutside(context, inner);
    this.nameKept(context);
    this.drawCurves(context);
    this.drawEvents(context, inner);
    context.restore();
    if (this.axes[1]) this.drawRightAxis(context, this.axes[1], inner);
    return undefined;
  }

  drawGrid(context, inner) {
    const { scale } = this;
    const foot = TOP + inner;
    context.fillStyle = cssColor("--plot-bg");
    context.fillRect(scale.left, TOP, scale.span, inner);
    context.strokeStyle = cssColor("--grid");
    context.fillStyle = cssColor("--faint");
    context.lineWidth = 1;
    context.textAlign = "right";
    context.textBaseline = "middle";
    const [left] = this.run ? this.axes : [];
    for (const { v, y } of left?.ticks ?? []) {
      line(context, scale.left, y, scale.right, y);
      context.fillText(left.tell(v), scale.left - 6, Math.min(Math.max(y, TOP + 5), foot - 4), scale.left - 8);
    }
    for (const t of timeTicks(scale, scale.span / 75).values) line(context, scale.x(t), TOP, scale.x(t), foot);
    this.shadeBeyondEnd(context, inner);
  }

  // A run may end before the mission does (surface, bed): the rest is visibly not computed.
  shadeBeyondEnd(context, inner) {
    const end = this.run?.columns.t.at(-1) ?? 0;
    if (!this.run || end >= this.scale.to - 1e-6) return;
    const x = Math.max(this.scale.x(end), this.scale.left);
    context.fillStyle = cssColor("--panel");
    context.globalAlpha = 0.75;
    context.fillRect(x, TOP, this.scale.right - x, inner);
    context.globalAlpha = 1;
  }

  // Samples that left the data which the forces come from: their curves are drawn, on hatched ground.
  drawOutside(context, inner) {
    const color = cssColor("--warn");
    context.globalAlpha = OUTSIDE;
    for (const [a, b] of outsideStretches(this.run)) {
      if (b < this.scale.from || a > this.scale.to) continue;
      const x = this.scale.x(a);
      hatch(context, { x, y: TOP, width: Math.max(this.scale.x(b) - x, 1), height: inner, color });
    }
    context.globalAlpha = 1;
  }

  // The first named lies on top; kept runs below all of the present one.
  drawCurves(context) {
    context.lineJoin = "round";
    const curves = this.axes.flatMap((axis) => axis.series.map((series) => ({ axis, series }))).reverse();
    for (const { axis, series } of curves) {
      for (const kept of series.kept) this.drawCurve(context, axis, { ...series, ...kept, width: KEPT_WIDTH });
    }
    for (const { axis, series } of curves) this.drawCurve(context, axis, series);
    context.setLineDash([]);
  }

  drawCurve(context, axis, { t, values, color, width, dash, wraps }) {
    const [first, last] = within(t, this.scale.from, this.scale.to);
    context.strokeStyle = paint(color);
    context.lineWidth = width;
    context.setLineDash(dash);
    context.beginPath();
    let pen = false;
    for (let i = first; i <= last; i += 1) {
      if (values[i] === null) {
        pen = false;
        continue;
      }
      const turned = pen && wraps && Math.abs(values[i] - values[i - 1]) > Math.PI;
      const [x, y] = [this.scale.x(t[i]), axis.y(values[i])];
      if (pen && !turned) context.lineTo(x, y);
      else context.moveTo(x, y);
      pen = true;
    }
    context.stroke();
  }

  drawEvents(context, inner) {
    context.strokeStyle = cssColor("--faint");
    context.lineWidth = 1;
    context.setLineDash([1, 3]);
    for (const { time } of this.run.events ?? []) {
      if (this.scale.shows(time)) line(context, this.scale.x(time), TOP, this.scale.x(time), TOP + inner);
    }
    context.setLineDash([]);
  }

  // Its numbers stand inside the plot, in the colour of its first line and over all lines.
  drawRightAxis(context, axis, inner) {
    const x = this.scale.right - 5;
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const { v, y } of axis.ticks) {
      const text = axis.tell(v);
      const at = Math.min(Math.max(y, TOP + 7), TOP + inner - 7);
      const { width } = context.measureText(text);
      context.fillStyle = cssColor("--plot-bg");
      context.fillRect(x - width - 3, at - 7, width + 6, 14);
      context.fillStyle = paint(axis.series[0].color);
      context.fillText(text, x, at);
    }
  }

  tell(axis, series, curve, t) {
    const value = series.read(curve.values, locate(curve.t, t));
    return Number.isFinite(value) ? `${axis.show(series, value)} ${axis.symbol}`.trimEnd() : NONE;
  }

  axisOf(series) {
    return this.axes.find((axis) => axis.series.includes(series));
  }

  // Kept runs as [name, colour].
  get keptRuns() {
    return [...new Map(this.series.flatMap(({ kept }) => kept).map(({ name, color }) => [name, color]))];
  }

  // Their names in their colours, under the lines. A patch and no line: dashes are the outputs'.
  nameKept(context) {
    let x = this.scale.left + 8;
    context.textAlign = "left";
    context.textBaseline = "middle";
    for (const [name, color] of this.keptRuns) {
      context.fillStyle = paint(color);
      context.fillRect(x, TOP + 4, 8, 8);
      context.fillText(name, x + 12, TOP + 8);
      x += 24 + context.measureText(name).width;
    }
  }

  // [label, value] of each line of the present run.
  describe(t) {
    return this.series.map((series) => [series.label, this.run ? this.tell(this.axisOf(series), series, series, t) : NONE]);
  }

  // The same beside those of kept runs: a head of their names in their colours where there are any, and a row a line.
  table(t) {
    const runs = this.keptRuns;
    const head = runs.length ? [["", "Now", ...runs.map(([name, color]) => [name, paint(color)])]] : [];
    const rows = this.series.map((series, i) => {
      const others = runs.map(([name]) => series.kept.find((kept) => kept.name === name));
      return [...this.describe(t)[i], ...others.map((kept) => (kept ? this.tell(this.axisOf(series), series, kept, t) : NONE))];
    });
    return [...head, ...rows];
  }
}
