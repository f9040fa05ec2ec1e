// One cell's lane: its command (wide, pale), its actual extension (thin), where it is near a stop, and points to drag.

import { el, setText, svg, swatch } from "./dom.js";
import { clockText, extensionScale, fixed } from "./format.js";
import { clamp } from "./schedule.js";
import { commandAt } from "./schedulecopy.js";
import { at, commandCorners, extent, locate, stretches } from "./series.js";
import { quantityOf, unitNow } from "./unitchoice.js";

const PAD = 8;
const SMALLEST_SHARE = 0.2; // of the whole stroke: below that a lane would show noise
const DOT = 5.5; // radius of a point in pixels; smaller where many share a lane
const SMALLEST_DOT = 2.8;
const TWO_LINES = 30; // pixels: a lower lane has its limits on one line
const WIDEST = 7.5; // pixels of a digit: what has room for so many need not be measured
const LOCK = "M4.5 7V5a3.5 3.5 0 0 1 7 0v2M3 7h10v7H3z";

const attributes = (node, values) => {
  for (const [name, value] of Object.entries(values)) node.setAttribute(name, value);
};

export class Lane {
  // hooks: onPress(lane, k, event), onKey(lane, k, event), onBand(lane, event), onAdd(lane, event), onSelect, onMenu, nearStop()
  constructor(scale, hooks) {
    Object.assign(this, { scale, hooks, drafts: new Map(), held: null, circles: [], outstanding: 0, until: 0, height: 38, chosen: new Set() });
    this.buildPlot();
    this.name = el("button", { type: "button", class: "lane-name", onclick: () => hooks.onSelect(this) });
    this.value = el("output", { class: "lane-value" });
    this.menu = el("button", { type: "button", class: "lane-menu", "aria-haspopup": "menu", onclick: () => hooks.onMenu(this) }, "⋯");
    this.lock = svg("svg", { class: "lock", viewBox: "0 0 16 16", role: "img", "aria-label": "Locked" }, svg("path", { d: LOCK }));
    this.root = el("div", { class: "row lane-row" }, el("div", { class: "label" }, this.name, this.lock, this.value, this.menu), this.svg);
    this.svg.addEventListener("dblclick", (event) => event.target.closest(".dot") || hooks.onAdd(this, event));
    this.svg.addEventListener("pointerdown", (event) => event.target.closest(".dot") || hooks.onBand(this, event));
  }

  buildPlot() {
    this.back = svg("rect", { class: "lane-back", rx: 3 });
    this.stops = svg("path", { class: "near-stop", fill: "url(#stop-hatch)" });
    this.high = svg("text", { class: "lane-limit" });
    this.low = svg("text", { class: "lane-limit" });
    this.symbol = svg("text", { class: "lane-limit" });
    this.command = svg("path", { class: "command" });
    this.actual = svg("path", { class: "actual" });
    this.dots = svg("g", {});
    this.plot = svg("svg", {}, this.stops, this.command, this.actual); // clips: the band is wide, and would paint beyond the end
    // A point at the very edge is a whole circle all the same; one outside the window is not there.
    this.svg = svg("svg", { class: "lane", role: "group", tabindex: -1 }, this.back, this.high, this.low, this.symbol, this.plot, this.dots);
  }

  update(schedule, component, { run, revision, duration }) {
    Object.assign(this, { schedule, component, run, revision, duration });
    this.unit = extensionScale(component?.unit);
    this.cell = run?.cells.find((c) => c.name === schedule.cell) ?? null;
    if (this.settled) this.drafts.clear();
    this.locked = Boolean(component?.locked);
    this.fixed = this.locked || schedule.controlled; // by whom its points cannot be moved
    this.root.style.setProperty("--cell", schedule.color);
    attributes(this.root, { "data-testid": `lane-${schedule.cell}`, "data-locked": String(this.locked), "data-controlled": String(Boolean(schedule.controlled)) });
    this.lock.toggleAttribute("hidden", !this.locked);
    this.label();
  }

  label() {
    const { cell, color, controlled } = this.schedule;
    this.name.title = `${cell}${controlled ? " (under control)" : ""}: show in the editor`;
    this.name.replaceChildren(swatch(color), el("span", {}, cell));
    attributes(this.menu, { "aria-label": `${cell}: schedule`, title: `Schedule of ${cell}`, "data-testid": `lane-menu-${cell}` });
    const how = controlled ? "under control" : this.locked ? "schedule, locked" : "schedule. Double-click adds a point";
    attributes(this.svg, { "aria-label": `${cell} ${how}.` });
  }

  get points() {
    return this.schedule.points.map((p, k) => this.drafts.get(k) ?? p);
  }

  // As in the fields of the parts.
  get typedUnit() {
    const unit = this.component?.unit ?? "m";
    return unitNow(quantityOf(unit, "/mission/control/schedules", "extension"), unit);
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
    if (this.held) return extent([...this.held, a, b]);
    const whole = (high ?? b) - (low ?? a);
    const half = Math.max((b - a) * 0.6, whole * SMALLEST_SHARE * 0.5, 1e-4);
    const middle = clamp((a + b) / 2, (low ?? -Infinity) + half, (high ?? Infinity) - half);
    // What lies beyond the limits (they may have been edited since) is shown all the same.
    return [Math.min(a, clamp(middle - half, low, high)), Math.max(b, clamp(middle + half, low, high))];
  }

  draw() {
    const { scale, height } = this;
    const pad = Math.min(PAD, height / 4);
    const [low, high] = (this.shown = this.range());
    this.y = (e) => height - pad - ((e - low) / (high - low || 1)) * (height - 2 * pad);
    this.valueAt = (y) => low + ((height - pad - y) / (height - 2 * pad)) * (high - low);
    this.root.style.height = `${height}px`;
    attributes(this.svg, { width: scale.width, height, viewBox: `0 0 ${scale.width} ${height}` });
    attributes(this.plot, { x: scale.left, y: 0, width: scale.span, height, viewBox: `${scale.left} 0 ${scale.span} ${height}` });
    attributes(this.back, { x: scale.left, y: 2, width: scale.span, height: height - 4 });
    this.drawLimits(low, high);
    this.stops.setAttribute("d", this.stopsPath());
    this.command.setAttribute("d", this.commandPath());
    this.actual.setAttribute("d", this.cell ? this.pathOf(this.run.columns.t, this.cell.extension) : "");
    this.drawPoints();
  }

  drawLimits(low, high) {
    const digits = this.unit.symbol === "°" || high - low >= 0.01 ? 0 : high - low < 0.002 ? 2 : 1;
    const edge = this.scale.left - 8;
    const [most, least] = [high, low].map((e) => fixed(e * this.unit.per, digits));
    const oneLine = this.height < TWO_LINES;
    const numbers = oneLine ? edge : edge - (this.unit.symbol === "°" ? 9 : 25); // the unit stands once, beside both
    attributes(this.high, { x: numbers, y: oneLine ? this.height / 2 + 4 : 13 });
    attributes(this.low, { x: numbers, y: this.height - 5 });
    attributes(this.symbol, { x: edge, y: this.height / 2 + 4 });
    setText(this.symbol, oneLine ? "" : this.unit.symbol);
    setText(this.high, oneLine ? `${least}–${most} ${this.unit.symbol}` : most);
    setText(this.low, oneLine ? "" : least);
    this.fitLimit();
  }

  // Long numbers are drawn together: they must not run out of the gutter.
  fitLimit() {
    const room = this.scale.left - 10;
    this.high.removeAttribute("textLength");
    if (this.high.textContent.length * WIDEST > room && this.high.getComputedTextLength() > room) attributes(this.high, { textLength: room, lengthAdjust: "spacingAndGlyphs" });
  }

  // Where the cell was near a stop, by the server's word for near.
  nearStops() {
    const { extension_min: low, extension_max: high } = this.component ?? {};
    const near = this.hooks.nearStop();
    if (!this.cell || low == null || high == null || near == null) return [];
    const edge = (high - low) * near;
    return stretches(this.run.columns.t, this.cell.extension, (e) => e <= low + edge || e >= high - edge);
  }

  stopsPath() {
    return this.nearStops().map(([a, b]) => {
      const x = this.scale.x(a);
      return `M${x.toFixed(1)} 2H${Math.max(this.scale.x(b), x + 2).toFixed(1)}V${this.height - 2}H${x.toFixed(1)}Z`;
    }).join("");
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
    const { points, scale } = this;
    while (this.circles.length > points.length) this.circles.pop().remove();
    while (this.circles.length < points.length) this.circles.push(this.makePoint(this.circles.length));
    const shown = points.filter((p) => scale.shows(p.time)).length;
    const r = clamp(scale.span / (3 * Math.max(shown, 1)), SMALLEST_DOT, this.height < 30 ? 4.5 : DOT).toFixed(1);
    points.forEach((point, k) => {
      const words = point.shape === "ramp" ? "ramp up to" : "step at";
      attributes(this.circles[k], {
        cx: scale.x(point.time), cy: this.y(point.extension), r, visibility: scale.shows(point.time) ? "visible" : "hidden",
        "data-testid": `point-${this.schedule.cell}-${k}`, "data-shape": point.shape, "aria-pressed": String(this.chosen.has(k)), "aria-disabled": String(this.fixed),
        "aria-label": `${this.schedule.cell} point ${k + 1}: ${words} ${this.moment(point.time)}, ${this.told(point.extension)}`,
      });
    });
  }

  makePoint(k) {
    const dot = svg("circle", { class: "dot", tabindex: 0, role: "button", "aria-haspopup": "dialog" });
    dot.addEventListener("pointerdown", (event) => event.button === 0 && this.hooks.onPress(this, k, event));
    dot.addEventListener("keydown", (event) => this.hooks.onKey(this, k, event));
    this.dots.append(dot);
    return dot;
  }

  choose(chosen) {
    this.chosen = chosen;
    this.circles.forEach((dot, k) => dot.setAttribute("aria-pressed", String(chosen.has(k))));
  }

  offset(event) {
    const box = this.svg.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  // To a tenth of a second, which is what points snap to.
  moment(t) {
    return clockText(t, this.scale.end, { digits: 2, tenths: true });
  }

  told(extension) {
    return `${fixed(extension * this.unit.per, this.unit.digits)} ${this.unit.symbol}`;
  }

  limited(extension) {
    return clamp(extension, this.component?.extension_min, this.component?.extension_max);
  }

  // Points stay where they were put until a state as new as their last edit has come.
  get settled() {
    return !this.held && this.outstanding === 0 && this.revision >= this.until;
  }

  async sent(answer) {
    this.outstanding += 1;
    const revision = await answer.then((done) => done?.revision, () => undefined);
    this.outstanding -= 1;
    this.until = revision ?? 0;
    if (!this.settled) return;
    this.drafts.clear();
    this.draw();
  }

  showTime(t) {
    const e = this.cell ? at(this.cell.extension, locate(this.run.columns.t, t)) : this.startValue();
    setText(this.value, this.told(e));
  }

  // Between two samples a held command is the first one's; a schedule says itself what it asks for.
  commanded(t) {
    if (!this.schedule.controlled) return commandAt(this.points, this.startValue(), t);
    if (!this.cell) return null;
    const { i, f } = locate(this.run.columns.t, t);
    return this.cell.command[f < 1 ? i : Math.min(i + 1, this.cell.command.length - 1)];
  }

  describe(t) {
    const command = this.commanded(t);
    const rows = command === null ? [] : [["Command", this.told(command)]];
    return this.cell ? [...rows, ["Actual", this.told(at(this.cell.extension, locate(this.run.columns.t, t)))]] : rows;
  }
}
