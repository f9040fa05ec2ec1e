// Lanes, marks and plots on one time axis, with one red line through all of them.

import { $, el, setText } from "./dom.js";
import { Hover } from "./hover.js";
import { LaneSet } from "./lanes.js";
import { PathPlot } from "./pathplot.js";
import { PlotCursor } from "./plotcursor.js";
import { outsideAt } from "./plotoutside.js";
import { PlotSet } from "./plotset.js";
import { RangeBar } from "./rangebar.js";
import { EXTENSION_STEPS, TIME_STEPS } from "./snap.js";
import { Strip } from "./strip.js";
import { onScheme } from "./theme.js";
import { TimeScale, axisEnd } from "./timescale.js";
import { TimeZoom } from "./timezoom.js";
import { focusWarning } from "./warningfocus.js";

const SAID = 5000; // ms for which a message stands in the hint's place

export class Timeline {
  // actions: edit(patch), editLatest(patch), select(component index)
  constructor({ store, clock, actions }) {
    Object.assign(this, { store, clock, scale: new TimeScale(), asked: 0 });
    const { scale } = this;
    const redraw = () => this.redraw();
    this.lanes = new LaneSet({ scale, clock, actions, onDrop: () => this.fitAxis() && this.draw(), say: (words) => this.say(words) });
    this.plots = new PlotSet({ scale, clock, onRows: () => this.layout() });
    this.hover = new Hover({ scale, describe: (target, t) => this.describe(target, t), onMove: (t) => this.plots.showCursor(t) });
    this.cursor = new PlotCursor({ scale, clock, hover: this.hover, plotOf: (canvas) => this.plots.plotOf(canvas) });
    this.strip = new Strip({ store, clock, scale, note: (node, lines) => this.hover.note(node, lines), onWarning: focusWarning, onBookmarks: (bookmarks) => store.set({ bookmarks }) });
    this.zoom = new TimeZoom({ scale, clock, onChange: redraw });
    this.range = new RangeBar({ scale, clock });
    this.path = new PathPlot($("path"), { onSeek: (t) => clock.seek(t), keptOf: () => this.plots.shownKept });
    this.connectSnap();
    this.listen();
    store.watch(["state"], ({ state }) => state && this.update(state));
    store.watch(["consequences"], ({ consequences }) => this.hatch(consequences?.near_stop));
    clock.watch(() => this.showTime());
  }

  listen() {
    const sizes = new ResizeObserver(() => this.layout());
    for (const id of ["rows", "plots", "path"]) sizes.observe($(id));
    onScheme(() => this.draw());
    $("plots").addEventListener("pointerdown", (event) => this.scrubOn(event));
  }

  // On a plot the pointer takes the clock along.
  scrubOn(event) {
    const plot = this.plots.plotOf(event.target);
    if (!plot || event.button !== 0) return;
    const { canvas } = plot;
    const seek = ({ clientX }) => this.clock.seek(this.scale.t(clientX - canvas.getBoundingClientRect().left));
    canvas.setPointerCapture(event.pointerId);
    seek(event);
    canvas.addEventListener("pointermove", seek);
    const end = () => canvas.removeEventListener("pointermove", seek);
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, end, { once: true });
  }

  connectSnap() {
    const { snap } = this.lanes;
    for (const [id, steps, key] of [["snap-time", TIME_STEPS, "time"], ["snap-extension", EXTENSION_STEPS, "extension"]]) {
      $(id).replaceChildren(...steps.map(([value, words]) => el("option", { value }, words)));
      $(id).value = snap[key];
      $(id).addEventListener("change", () => snap.choose({ [key]: $(id).value }));
    }
  }

  // A word on what was done or cannot be done, in the hint's place.
  say(words) {
    setText($("lane-hint"), words);
    clearTimeout(this.quiet);
    this.quiet = setTimeout(() => this.lanes.hint(this.store.get("state")), SAID);
  }

  update(state) {
    this.lanes.sync(state);
    this.fitAxis();
    this.plots.update(state);
    this.path.setRun(state.run);
    this.lanes.hint(state);
    this.layout();
    this.hover.refresh();
  }

  // Returns whether the axis changed. Under a drag it stays: a point moved by a moving axis would run away.
  fitAxis() {
    const state = this.store.get("state");
    if (!state || this.lanes.drag.active) return false;
    const end = axisEnd({ duration: state.duration, runEnd: state.run?.columns.t.at(-1) ?? null, lastPoint: this.lanes.lastPoint() });
    if (end === this.scale.end) return false;
    this.scale.setEnd(end);
    return true;
  }

  layout() {
    this.left = $("ruler-label").offsetWidth;
    this.scale.width = Math.max($("rows").clientWidth - this.left, 120);
    this.draw();
  }

  // The server says which share of its stroke from a stop a cell is near it.
  hatch(near) {
    if (near === undefined || near === this.lanes.nearStop) return;
    this.lanes.nearStop = near;
    this.redraw();
  }

  // Zooming asks more often than a screen shows.
  redraw() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => this.draw());
  }

  draw() {
    cancelAnimationFrame(this.asked);
    this.asked = 0;
    this.drawRuler();
    this.strip.draw();
    this.lanes.draw();
    this.plots.draw();
    this.path.draw();
    this.showTime();
  }

  drawRuler() {
    const scrub = $("scrub");
    scrub.min = String(this.scale.from);
    scrub.max = String(this.scale.to);
    scrub.style.left = `${this.scale.left - 7}px`; // half a thumb, so that its tip is the line's head
    scrub.style.width = `${this.scale.span + 14}px`;
    scrub.value = String(this.clock.t); // the old ends may have held it back
    this.zoom.draw();
  }

  // Moves what moves; curves are drawn anew only where the window had to follow.
  showTime() {
    const { t } = this.clock;
    const moved = t !== this.shown;
    this.shown = t;
    if (moved && this.zoom.follow(t)) return this.draw();
    $("clock-line").hidden = !this.scale.shows(t);
    $("scrub").dataset.outside = t < this.scale.from ? "before" : t > this.scale.to ? "after" : ""; // its head is an arrow then
    $("clock-line").style.transform = `translateX(${(this.left ?? 0) + this.scale.x(t)}px)`;
    this.lanes.showTime(t);
    this.plots.showTime(t);
    this.path.showTime(t);
    this.range.draw();
    return undefined;
  }

  describe(target, t) {
    const lane = this.lanes.list.find((each) => each.svg.contains(target));
    if (lane) return { rows: lane.describe(t), notes: this.notesAt(t) };
    const plot = this.plots.plotOf(target);
    return plot && { rows: plot.table(t), notes: [...this.notesAt(t), ...outsideAt(plot.run, t).slice(0, 2)] };
  }

  notesAt(t) {
    const near = (this.store.get("state")?.run?.events ?? []).filter((e) => Math.abs(this.scale.x(e.time) - this.scale.x(t)) < 6);
    return near.slice(0, 2).map(({ label }) => label);
  }
}
