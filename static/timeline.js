// Lanes and plots on one time axis, with one red line through all of them.

import { $, el, setText } from "./dom.js";
import { clockText } from "./format.js";
import { Lane } from "./lane.js";
import { Legend } from "./legend.js";
import { PathPlot } from "./pathplot.js";
import { TimePlot } from "./plots.js";
import { PointEditor } from "./pointeditor.js";
import { addPatch, movePatch, removePatch } from "./schedule.js";
import { GUTTER, TimeScale, axisEnd } from "./timescale.js";

export class Timeline {
  // actions: edit(patch), editLatest(patch), select(component index)
  constructor({ store, clock, actions }) {
    Object.assign(this, { store, clock, actions, lanes: new Map(), scale: new TimeScale(), hovered: null });
    this.editor = new PointEditor({
      onApply: ({ cell, k }, point) => this.edit(cell, (schedule) => movePatch(schedule, k, point)),
      onDelete: ({ cell, k }) => this.edit(cell, (schedule) => removePatch(schedule, k)),
    });
    this.plots = [
      new TimePlot($("plot-depth"), this.scale, "depth"),
      new TimePlot($("plot-angles"), this.scale, "angles", { axis: true }),
    ];
    this.path = new PathPlot($("path"), { onSeek: (t) => clock.seek(t) });
    this.legends = [new Legend($("legend-depth")), new Legend($("legend-angles"))];
    this.listen();
    store.watch(["state"], ({ state }) => state && this.update(state));
    clock.watch(() => this.showTime());
  }

  listen() {
    new ResizeObserver(() => this.layout()).observe($("rows"));
    new ResizeObserver(() => this.layout()).observe($("path"));
    matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => this.draw());
    for (const plot of this.plots) this.listenTo(plot);
    $("rows").addEventListener("pointermove", (event) => this.hover(event));
    $("rows").addEventListener("pointerleave", () => this.unhover());
  }

  listenTo({ canvas }) {
    const seek = (event) => this.clock.seek(this.scale.t(event.clientX - canvas.getBoundingClientRect().left));
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", (event) => event.buttons & 1 && seek(event));
  }

  // Edits find the schedule anew: indices may have changed since a popover was opened.
  edit(cell, patchOf) {
    const lane = this.lanes.get(cell);
    if (lane) lane.sent(this.actions.edit(patchOf(lane.schedule)));
  }

  laneHooks() {
    return {
      onDrag: (lane, k, point) => {
        lane.sent(this.actions.editLatest(movePatch(lane.schedule, k, point)));
        if (this.fitAxis()) this.draw();
      },
      onDrop: () => this.fitAxis() && this.draw(),
      onAdd: (lane, point) => this.edit(lane.schedule.cell, (schedule) => addPatch(schedule, point)),
      onRemove: (lane, k) => this.edit(lane.schedule.cell, (schedule) => removePatch(schedule, k)),
      onOpen: (lane, k, anchor) => this.editor.open({ cell: lane.schedule.cell, k, point: lane.points[k], anchor, unit: lane.unit }),
      onSelect: (lane) => this.actions.select(lane.component?.index),
      onSeek: (t) => this.clock.seek(t),
    };
  }

  update(state) {
    this.syncLanes(state);
    this.fitAxis();
    this.plots.forEach((plot, i) => {
      plot.setRun(state.run, state.model);
      this.legends[i].show(plot);
    });
    this.path.setRun(state.run);
    this.layout();
  }

  // Returns whether the axis changed. Under a drag it stays: a point moved by a moving axis would run away.
  fitAxis() {
    const lanes = [...this.lanes.values()];
    const state = this.store.get("state");
    if (!state || lanes.some((lane) => lane.dragging)) return false;
    const lastPoint = Math.max(0, ...lanes.map((lane) => lane.points.at(-1)?.time ?? 0));
    const end = axisEnd({ duration: state.duration, runEnd: state.run?.columns.t.at(-1) ?? null, lastPoint });
    if (end === this.scale.end) return false;
    this.scale.end = end;
    $("scrub").max = String(end);
    $("scrub").value = String(this.clock.t); // the old end may have held it back
    return true;
  }

  syncLanes(state) {
    const names = new Set(state.schedules.map((s) => s.cell));
    for (const [name, lane] of this.lanes) {
      if (!names.has(name)) {
        lane.root.remove();
        this.lanes.delete(name);
      }
    }
    for (const schedule of state.schedules) {
      if (!this.lanes.has(schedule.cell)) this.lanes.set(schedule.cell, new Lane(this.scale, this.laneHooks()));
      const lane = this.lanes.get(schedule.cell);
      const component = state.components.find((c) => c.name === schedule.cell);
      lane.update(schedule, component, state);
      // Re-appending an unmoved lane would take the focus from its points.
      const place = $("lanes").children[state.schedules.indexOf(schedule)];
      if (place !== lane.root) $("lanes").insertBefore(lane.root, place ?? null);
    }
    $("no-cells").hidden = state.schedules.length > 0;
    const free = state.schedules.filter((s) => !s.controlled);
    this.hint ??= $("lane-hint").textContent;
    setText($("lane-hint"), free.length || !state.schedules.length ? this.hint : "All cells are under control: lanes show the commands they hold");
  }

  layout() {
    const label = $("ruler-label").offsetWidth;
    this.scale.width = Math.max($("rows").clientWidth - label, 120);
    this.left = label;
    const scrub = $("scrub");
    scrub.style.marginLeft = `${GUTTER - 7}px`; // half a thumb, so that its tip is the line's head
    scrub.style.width = `${this.scale.span + 14}px`;
    this.draw();
  }

  draw() {
    for (const lane of this.lanes.values()) lane.draw();
    for (const plot of this.plots) plot.draw();
    this.path.draw();
    this.showTime();
  }

  showTime() {
    const { t } = this.clock;
    $("clock-line").style.transform = `translateX(${(this.left ?? 0) + this.scale.x(t)}px)`;
    for (const lane of this.lanes.values()) lane.showTime(t);
    this.plots.forEach((plot, i) => this.legends[i].write(plot.describe(t)));
    this.path.showTime(t);
  }

  hover(event) {
    const x = event.clientX - $("rows").getBoundingClientRect().left - this.left;
    const subject = this.subjectOf(event.target);
    if (x < GUTTER || !subject || event.buttons) return this.unhover();
    const t = this.scale.t(x);
    $("hover-line").hidden = false;
    $("hover-line").style.transform = `translateX(${this.left + this.scale.x(t)}px)`;
    this.showTip(subject, t, event);
  }

  subjectOf(target) {
    const plot = this.plots.find(({ canvas }) => canvas === target);
    return plot ?? [...this.lanes.values()].find((lane) => lane.svg.contains(target));
  }

  showTip(subject, t, event) {
    const rows = [["Time", clockText(t, this.scale.end, { digits: 2 })], ...subject.describe(t)];
    const near = (this.store.get("state")?.run?.events ?? []).find((e) => Math.abs(this.scale.x(e.time) - this.scale.x(t)) < 6);
    const tip = $("tip");
    tip.replaceChildren(...rows.map(([name, value]) => el("div", {}, el("span", {}, name), el("b", {}, value))));
    if (near) tip.append(el("p", {}, near.label ?? near.kind));
    tip.hidden = false;
    const box = $("rows").getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const right = x + 16 + tip.offsetWidth < box.width;
    tip.style.left = `${right ? x + 16 : x - tip.offsetWidth - 16}px`;
    tip.style.top = `${Math.min(Math.max(y - tip.offsetHeight - 8, 2), box.height - tip.offsetHeight - 2)}px`;
  }

  unhover() {
    $("hover-line").hidden = true;
    $("tip").hidden = true;
  }
}
