// Time plots on canvas: drawn once per run, size or theme; what moves is laid over them.

import { NONE, fixed } from "./format.js";
import { PLOTS } from "./plotseries.js";
import { extent, locate } from "./series.js";
import { ticks, timeTicks } from "./timescale.js";

const FONT = '11px -apple-system, BlinkMacSystemFont, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';

// Sizes the backing store to the screen's pixels; returns a context that draws in CSS pixels.
export function prepare(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  return context;
}

export function cssColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function line(context, x1, y1, x2, y2) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

// A plot without a run says so: an empty frame could be a fault.
export function sayEmpty(context, x, y) {
  context.fillStyle = cssColor("--faint");
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText("No glide yet", x, y);
}

export class TimePlot {
  constructor(canvas, scale, kind, { axis = false } = {}) {
    const { down, ticks: valueTicks } = PLOTS[kind];
    Object.assign(this, { canvas, scale, kind, down, valueTicks, axis, run: null });
    this.top = 6;
    this.bottom = axis ? 24 : 6;
    this.setRun(null);
  }

  setRun(run, model = "planar") {
    this.run = run;
    Object.assign(this, PLOTS[this.kind][run?.model ?? model]);
  }

  limits(series) {
    let low = Infinity;
    let high = -Infinity;
    for (const { key, convert } of series) {
      const [a, b] = extent(this.run?.columns[key] ?? []);
      low = Math.min(low, convert(a));
      high = Math.max(high, convert(b));
    }
    if (series.some(({ right }) => right)) {
      const room = Math.max((high - low) * 0.06, 5);
      return [low - room, high + room];
    }
    if (this.kind === "angles") return [Math.min(low, 0) - 2, Math.max(high, 0) + 2];
    const pad = Math.max((high - low) * 0.08, 0.01);
    return [low - pad, high + pad];
  }

  draw() {
    const height = this.canvas.parentElement.clientHeight;
    const { width } = this.scale;
    const context = prepare(this.canvas, width, height);
    const inner = height - this.top - this.bottom;
    const right = this.series.filter((s) => s.right);
    const [low, high] = this.limits(this.series.filter((s) => !s.right));
    this.y = (v) => this.top + (this.down ? v - low : high - v) * (inner / (high - low));
    this.drawGrid(context, low, high, inner);
    if (!this.run) return sayEmpty(context, this.scale.x(this.scale.end / 2), this.top + inner / 2);
    if (right.length) this.setRightAxis(right, inner);
    context.save();
    context.beginPath();
    context.rect(this.scale.x(0), 0, this.scale.span, this.top + inner);
    context.clip();
    for (const series of [...this.series].reverse()) this.drawSeries(context, series);
    context.restore();
    if (right.length) this.drawRightAxis(context, right, inner);
    this.drawEvents(context, inner);
  }

  setRightAxis(series, inner) {
    const [low, high] = this.limits(series);
    this.yRight = (v) => this.top + (high - v) * (inner / (high - low));
    this.rightTicks = ticks(low, high, 3);
  }

  // Its numbers stand inside the plot, in the colour of its line and over all lines.
  drawRightAxis(context, series, inner) {
    const x = this.scale.x(this.scale.end) - 5;
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const v of this.rightTicks.values) {
      const text = fixed(v, this.rightTicks.digits);
      const y = Math.min(Math.max(this.yRight(v), this.top + 7), this.top + inner - 7);
      const { width } = context.measureText(text);
      context.fillStyle = cssColor("--plot-bg");
      context.fillRect(x - width - 3, y - 7, width + 6, 14);
      context.fillStyle = cssColor(`--${series[0].name}`);
      context.fillText(text, x, y);
    }
  }

  drawGrid(context, low, high, inner) {
    const { scale } = this;
    const [left, right, foot] = [scale.x(0), scale.x(scale.end), this.top + inner];
    context.fillStyle = cssColor("--plot-bg");
    context.fillRect(left, this.top, scale.span, inner);
    context.strokeStyle = cssColor("--grid");
    context.fillStyle = cssColor("--faint");
    context.lineWidth = 1;
    const vertical = this.run ? this.valueTicks(low, high, inner > 80 ? 4 : 3) : { values: [] };
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const v of vertical.values) {
      line(context, left, this.y(v), right, this.y(v));
      context.fillText(fixed(v, vertical.digits), left - 6, Math.min(Math.max(this.y(v), this.top + 5), foot - 4));
    }
    const times = timeTicks(scale.end, scale.span / 75);
    for (const t of times.values) line(context, scale.x(t), this.top, scale.x(t), foot);
    if (this.axis) this.drawTimes(context, times, foot);
    this.shadeBeyondEnd(context, inner);
  }

  drawTimes(context, times, foot) {
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const t of times.values) context.fillText(fixed(t / times.per, times.digits), this.scale.x(t), foot + 6);
    context.textAlign = "right";
    context.fillText(times.per === 1 ? "t (s)" : times.symbol, this.scale.x(0) - 12, foot + 6);
  }

  // A run may end before the mission does (surface, bed): the rest is visibly not computed.
  shadeBeyondEnd(context, inner) {
    const end = this.run?.columns.t.at(-1) ?? 0;
    if (!this.run || end >= this.scale.end - 1e-6) return;
    context.fillStyle = cssColor("--panel");
    context.globalAlpha = 0.75;
    context.fillRect(this.scale.x(end), this.top, this.scale.x(this.scale.end) - this.scale.x(end), inner);
    context.globalAlpha = 1;
  }

  drawSeries(context, { key, name, convert, width, dash, wraps, right }) {
    const { t } = this.run.columns;
    const y = right ? this.yRight : this.y;
    const values = this.run.columns[key];
    if (!values) return;
    context.strokeStyle = cssColor(`--${name}`);
    context.lineWidth = width;
    context.lineJoin = "round";
    context.setLineDash(dash);
    context.beginPath();
    let pen = false;
    for (let i = 0; i < t.length; i += 1) {
      const turned = i > 0 && wraps && Math.abs(values[i] - values[i - 1]) > Math.PI;
      if (pen && !turned) context.lineTo(this.scale.x(t[i]), y(convert(values[i])));
      else context.moveTo(this.scale.x(t[i]), y(convert(values[i])));
      pen = true;
    }
    context.stroke();
    context.setLineDash([]);
  }

  drawEvents(context, inner) {
    context.fillStyle = context.strokeStyle = cssColor("--warn");
    context.lineWidth = 1;
    for (const { time } of this.run.events ?? []) {
      const x = this.scale.x(time);
      const y = this.top + inner;
      context.globalAlpha = 0.55;
      context.setLineDash([1, 3]);
      line(context, x, this.top, x, y);
      context.setLineDash([]);
      context.globalAlpha = 1;
      context.beginPath();
      context.moveTo(x - 4, y);
      context.lineTo(x, y - 6);
      context.lineTo(x + 4, y);
      context.fill();
    }
  }

  values(t) {
    if (!this.run) return this.series.map(() => NaN);
    const place = locate(this.run.columns.t, t);
    return this.series.map(({ key, read }) => read(this.run.columns[key], place));
  }

  describe(t) {
    return this.values(t).map((v, i) => {
      const { label, show, unit } = this.series[i];
      return [label, Number.isFinite(v) ? `${show(v)} ${unit}` : NONE];
    });
  }
}
