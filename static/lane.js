// One cell's lane: its command (wide, pale), its actual extension (thin), and points to drag.

import { el, setText, svg, swatch } from "./dom.js";
import { extensionScale, fixed } from "./format.js";
import { clamp, timeRange } from "./schedule.js";
import { at, commandCorners, extent, locate } from "./series.js";
import { timeStep } from "./timescale.js";

export const LANE_HEIGHT = 38;
const PAD = 8;
const SMALLEST_SHARE = 0.2; // of the whole stroke: below that a lane would show noise
const DOT = 5.5; // radius of a point in pixels; smaller where many share a lane
const SMALLEST_DOT = 2.8;
const CLICK_SLOP = 3; // pixels a press may wander and still be a click

const attributes = (node, values) => {
  for (const [name, value] of Object.entries(values)) node.setAttribute(name, value);
};

export class Lane {
  // hooks: onDrag(lane, k, point), onDrop, onOpen, onAdd, onRemove, onSelect, onSeek
  constructor(scale, hooks) {
    Object.assign(this, { scale, hooks, draft: null, dragging: null, circles: [], outstanding: 0, until: 0 });
    this.back = svg("rect", { class: "lane-back", rx: 3 });
    this.high = svg("text", { class: "lane-limit" });
    this.low = svg("text", { class: "lane-limit" });
    this.symbol = svg("text", { class: "lane-limit" });
    this.command = svg("path", { class: "command" });
    this.actual = svg("path", { class: "actual" });
    this.dots = svg("g", {});
    this.plot = svg("svg", {}, this.command, this.actual); // clips: the band is wide, and would paint beyond the end
    this.svg = svg("svg", { class: "lane", role: "group" }, this.back, this.high, this.low, this.symbol, this.plot, this.dots);
    this.name = el("button", { type: "button", class: "lane-name", onclick: () => hooks.onSelect(this) });
    this.value = el("output", { class: "lane-value" });
    this.root = el("div", { class: "row lane-row" }, el("div", { class: "label" }, this.name, this.value), this.svg);
    this.svg.addEventListener("dblclick", (event) => this.addAt(event));
    this.svg.addEventListener("click", (event) => event.target.closest(".dot") || hooks.onSeek(scale.t(this.offset(event)[0])));
  }

  update(schedule, component, { run, revision, duration }) {
    Object.assign(this, { schedule, component, run, revision, duration });
    this.unit = extensionScale(component?.unit);
    this.cell = run?.cells.find((c) => c.name === schedule.cell) ?? null;
    if (this.settled) this.draft = null;
    this.root.style.setProperty("--cell", schedule.color);
    this.root.dataset.testid = `lane-${schedule.cell}`;
    attributes(this.name, { title: `${schedule.cell}${schedule.controlled ? " (under control)" : ""}: show in the editor` });
    this.name.replaceChildren(swatch(schedule.color), el("span", {}, schedule.cell));
    const how = schedule.controlled ? "under control" : "schedule. Double-click adds a point";
    attributes(this.svg, { "aria-label": `${schedule.cell} ${how}.` });
    this.draw();
  }

  get points() {
    if (!this.draft) return this.schedule.points;
    return this.schedule.points.map((p, k) => (k === this.draft.k ? this.draft.point : p));
  }

  startValue() {
    return this.cell?.command[0] ?? this.component?.extension_neutral ?? 0;
  }

  // The stroke in use fills the lane (strokes are a millimetre or two); the numbers at the left say which.
  // Under a drag the range only grows: inside it the point stays under the pointer, beyond it at the edge, in sight.
  range() {
    const { extension_min: low, extension_max: high } = this.component ?? {};
    const cell = this.cell ? [...extent(this.cell.command), ...extent(this.cell.extension)] : [];
    const [a, b] = extent([this.startValue(), ...this.points.map((p) => p.extension), ...cell]);
    if (this.dragging) return extent([...this.dragging.range, a, b]);
    const whole = (high ?? b) - (low ?? a);
    const half = Math.max((b - a) * 0.6, whole * SMALLEST_SHARE * 0.5, 1e-4);
    const middle = clamp((a + b) / 2, (low ?? -Infinity) + half, (high ?? Infinity) - half);
    // What lies beyond the limits (they may have been edited since) is shown all the same.
    return [Math.min(a, clamp(middle - half, low, high)), Math.max(b, clamp(middle + half, low, high))];
  }

  draw() {
    const { scale } = this;
    const [low, high] = (this.shown = this.range());
    this.y = (e) => LANE_HEIGHT - PAD - ((e - low) / (high - low || 1)) * (LANE_HEIGHT - 2 * PAD);
    attributes(this.svg, { width: scale.width, height: LANE_HEIGHT, viewBox: `0 0 ${scale.width} ${LANE_HEIGHT}` });
    const inner = [scale.x(0), 0, scale.span, LANE_HEIGHT];
    attributes(this.plot, { x: inner[0], y: 0, width: inner[2], height: LANE_HEIGHT, viewBox: inner.join(" ") });
    attributes(this.back, { x: scale.x(0), y: 2, width: scale.span, height: LANE_HEIGHT - 4 });
    const digits = this.unit.symbol === "°" ? 0 : high - low < 0.002 ? 2 : 1;
    const edge = scale.x(0) - 8;
    const numbers = edge - (this.unit.symbol === "°" ? 7 : 21); // the unit stands once, beside both
    attributes(this.high, { x: numbers, y: 13 });
    attributes(this.low, { x: numbers, y: LANE_HEIGHT - 5 });
    attributes(this.symbol, { x: edge, y: LANE_HEIGHT / 2 + 4 });
    setText(this.symbol, this.unit.symbol);
    setText(this.high, fixed(high * this.unit.per, digits));
    setText(this.low, fixed(low * this.unit.per, digits));
    this.command.setAttribute("d", this.commandPath());
    this.actual.setAttribute("d", this.cell ? this.pathOf(this.run.columns.t, this.cell.extension) : "");
    this.drawPoints();
  }

  // Under control the command is what the run held: steps from sample to sample. Else it is the schedule's.
  commandPath() {
    if (this.schedule.controlled && this.cell) {
      const { t } = this.run.columns;
      const held = t.flatMap((time, i) => (i ? [time, time] : [time]));
      return this.pathOf(held, this.cell.command.flatMap((e, i) => (i ? [this.cell.command[i - 1], e] : [e])));
    }
    const corners = commandCorners(this.points, this.startValue(), this.scale.end);
    return this.pathOf(corners.map((c) => c[0]), corners.map((c) => c[1]));
  }

  pathOf(times, values) {
    let d = "";
    for (let i = 0; i < times.length; i += 1) {
      d += `${i ? "L" : "M"}${this.scale.x(times[i]).toFixed(1)} ${this.y(values[i]).toFixed(2)}`;
    }
    return d;
  }

  // Circles are kept while their number allows: a rebuilt one would lose focus and the pointer's capture.
  drawPoints() {
    const { points } = this;
    while (this.circles.length > points.length) this.circles.pop().remove();
    while (this.circles.length < points.length) this.circles.push(this.makePoint(this.circles.length));
    const r = clamp(this.scale.span / (3 * points.length), SMALLEST_DOT, DOT).toFixed(1);
    points.forEach((point, k) => {
      const words = point.shape === "ramp" ? "ramp up to" : "step at";
      attributes(this.circles[k], {
        cx: this.scale.x(point.time), cy: this.y(point.extension), r,
        "data-testid": `point-${this.schedule.cell}-${k}`,
        "aria-label": `${this.schedule.cell} point ${k + 1}: ${words} ${fixed(point.time, 2)} s, ${this.told(point.extension)}`,
      });
    });
  }

  makePoint(k) {
    const dot = svg("circle", { class: "dot", tabindex: 0, role: "button", "aria-haspopup": "dialog" });
    dot.addEventListener("pointerdown", (event) => event.button === 0 && this.press(event, k));
    dot.addEventListener("pointermove", (event) => this.move(event));
    dot.addEventListener("pointerup", () => this.release(true));
    dot.addEventListener("pointercancel", () => this.release(false));
    dot.addEventListener("dblclick", (event) => event.stopPropagation());
    dot.addEventListener("contextmenu", (event) => {
      event.preventDefault();
      this.hooks.onRemove(this, k);
    });
    dot.addEventListener("keydown", (event) => this.key(event, k));
    this.dots.append(dot);
    return dot;
  }

  offset(event) {
    const box = this.svg.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  valueAt(y) {
    const [low, high] = this.dragging?.range ?? this.shown;
    return low + ((LANE_HEIGHT - PAD - y) / (LANE_HEIGHT - 2 * PAD)) * (high - low);
  }

  told(extension) {
    return `${fixed(extension * this.unit.per, this.unit.digits)} ${this.unit.symbol}`;
  }

  // Tenths of a second and of a millimetre (whole degrees) unless Alt asks for all the digits.
  snapped(time, extension, free) {
    const step = timeStep(this.scale.end);
    const e = free ? extension : Math.round(extension / this.unit.snap) * this.unit.snap;
    return [free ? time : Math.round(time / step) * step, clamp(e, this.component?.extension_min, this.component?.extension_max)];
  }

  press(event, k) {
    event.target.setPointerCapture(event.pointerId);
    const [x, y] = this.offset(event);
    const point = this.schedule.points[k];
    this.dragging = { k, x, y, moved: false, range: this.shown, dx: this.scale.x(point.time) - x, dy: this.y(point.extension) - y };
  }

  move(event) {
    const drag = this.dragging;
    if (!drag) return;
    const [x, y] = this.offset(event);
    if (!drag.moved && Math.hypot(x - drag.x, y - drag.y) < CLICK_SLOP) return;
    drag.moved = true;
    const [time, extension] = this.snapped(this.scale.t(x + drag.dx), this.valueAt(y + drag.dy), event.altKey);
    this.moveTo(drag.k, time, extension);
  }

  moveTo(k, time, extension) {
    const base = this.schedule.points[k];
    const point = { ...base, time: clamp(time, ...timeRange(this.schedule.points, k, this.duration)), extension };
    this.draft = { k, point };
    this.draw();
    this.hooks.onDrag(this, k, point);
  }

  release(keep) {
    const drag = this.dragging;
    if (!drag) return;
    this.dragging = null;
    this.draw();
    this.hooks.onDrop();
    if (!drag.moved && keep) this.hooks.onOpen(this, drag.k, this.circles[drag.k]);
  }

  // A dragged point stays where it was put until a state as new as its last edit has come.
  get settled() {
    return !this.dragging && this.outstanding === 0 && this.revision >= this.until;
  }

  async sent(answer) {
    this.outstanding += 1;
    const revision = await answer.then((done) => done?.revision, () => undefined);
    this.outstanding -= 1;
    this.until = revision ?? 0;
    if (!this.settled) return;
    this.draft = null;
    this.draw();
  }

  key(event, k) {
    const [dt, de] = [timeStep(this.scale.end), this.unit.snap];
    const step = { ArrowLeft: [-dt, 0], ArrowRight: [dt, 0], ArrowUp: [0, de], ArrowDown: [0, -de] }[event.key];
    if (step) {
      const now = this.points[k];
      const [time, extension] = this.snapped(now.time + step[0], now.extension + step[1], event.altKey);
      this.moveTo(k, time, extension);
    } else if (event.key === "Enter" || event.key === " ") this.hooks.onOpen(this, k, this.circles[k]);
    else if (event.key === "Delete" || event.key === "Backspace") this.hooks.onRemove(this, k);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  addAt(event) {
    if (this.schedule.controlled) return;
    const [x, y] = this.offset(event);
    const [time, extension] = this.snapped(this.scale.t(x), this.valueAt(y), event.altKey);
    this.hooks.onAdd(this, { time, extension, shape: "step" });
  }

  showTime(t) {
    const e = this.cell ? at(this.cell.extension, locate(this.run.columns.t, t)) : this.startValue();
    setText(this.value, this.told(e));
  }

  describe(t) {
    if (!this.cell) return [];
    const place = locate(this.run.columns.t, t);
    return [["Command", this.told(at(this.cell.command, place))], ["Actual", this.told(at(this.cell.extension, place))]];
  }
}
