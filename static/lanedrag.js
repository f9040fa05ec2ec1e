// The pointer on the lanes: moves the chosen points together, or draws a band round those to choose.

import { el, setText } from "./dom.js";
import { clamp, movePatch, timeRoom } from "./schedule.js";

const CLICK_SLOP = 3; // pixels a press may wander and still be a click

export class LaneDrag {
  // set: lanes (Map), selection, snap, scale, send(patch, lanes), open(lane, k), seek(t), onDrop(); band: the element drawn
  constructor(set, band) {
    Object.assign(this, { set, band, drag: null, sweep: null, tip: el("div", { class: "tip", hidden: true, "aria-hidden": "true", "data-testid": "drag-tip" }) });
    band.after(this.tip);
  }

  get active() {
    return this.drag !== null;
  }

  press(lane, k, event) {
    const { selection } = this.set;
    const dot = event.target;
    if (event.shiftKey || event.ctrlKey || event.metaKey) return selection.toggle(lane.schedule.cell, k);
    const already = selection.has(lane.schedule.cell, k);
    if (!already) selection.only(lane.schedule.cell, k);
    if (lane.fixed) return undefined;
    const [x, y] = lane.offset(event);
    const point = lane.schedule.points[k];
    this.drag = { lane, k, x, y, already, moved: false, gesture: `points ${Date.now()}`, dx: this.set.scale.x(point.time) - x, dy: lane.y(point.extension) - y };
    for (const each of this.movable()) each.held = each.shown;
    dot.setPointerCapture(event.pointerId);
    const follow = (moving) => this.move(moving);
    dot.addEventListener("pointermove", follow);
    const end = (ending) => {
      dot.removeEventListener("pointermove", follow);
      for (const name of ["pointerup", "pointercancel"]) dot.removeEventListener(name, end);
      this.release(ending.type === "pointerup");
    };
    for (const name of ["pointerup", "pointercancel"]) dot.addEventListener(name, end);
    return undefined;
  }

  // The lanes with chosen points, of those that may be moved.
  movable() {
    return this.set.selection.cells.map((cell) => this.set.lanes.get(cell)).filter((lane) => lane && !lane.fixed);
  }

  move(event) {
    const { drag, set } = this;
    if (!drag) return;
    const [x, y] = drag.lane.offset(event);
    if (!drag.moved && Math.hypot(x - drag.x, y - drag.y) < CLICK_SLOP) return;
    drag.moved = true;
    const base = drag.lane.schedule.points[drag.k];
    const [t, e] = [set.scale.t(x + drag.dx), drag.lane.valueAt(y + drag.dy)];
    // Alt asks for all the digits.
    const time = event.altKey ? t : set.snap.times(t, set.scale);
    const extension = drag.lane.limited(event.altKey ? e : set.snap.extensions(e, drag.lane.unit));
    this.shift(time - base.time, extension - base.extension, drag.lane.unit);
    this.tellPoint(drag);
  }

  // The numbers of the point under the pointer, beside it.
  tellPoint({ lane, k }) {
    const { time, extension } = lane.points[k];
    setText(this.tip, `${lane.moment(time)} · ${lane.told(extension)}`);
    this.tip.hidden = false;
    const [dot, box] = [lane.circles[k].getBoundingClientRect(), this.band.parentElement.getBoundingClientRect()];
    const right = dot.right + 10 + this.tip.offsetWidth < box.right;
    const left = right ? dot.right + 10 : dot.left - 10 - this.tip.offsetWidth;
    Object.assign(this.tip.style, { left: `${left - box.left}px`, top: `${Math.max(dot.top - box.top - this.tip.offsetHeight, 2)}px` });
  }

  // All chosen points by the same time, and those read in the same unit by the same extension; one edit.
  shift(dt, de, unit) {
    const lanes = this.movable();
    const rooms = lanes.map((lane) => timeRoom(lane.schedule.points, this.set.selection.of(lane.schedule.cell), lane.duration));
    const by = clamp(dt, Math.max(...rooms.map(([low]) => low)), Math.min(...rooms.map(([, high]) => high)));
    const moves = new Map();
    for (const lane of lanes) {
      const rise = lane.unit.symbol === unit.symbol ? de : 0;
      lane.drafts = new Map([...this.set.selection.of(lane.schedule.cell)].map((k) => {
        const point = lane.schedule.points[k];
        return [k, { ...point, time: point.time + by, extension: lane.limited(point.extension + rise) }];
      }));
      moves.set(lane.schedule, lane.drafts);
      lane.draw();
    }
    this.set.send(movePatch(moves), lanes, { live: true, gesture: this.drag?.gesture });
  }

  release(kept) {
    const { drag } = this;
    if (!drag) return;
    this.drag = null;
    this.tip.hidden = true;
    for (const lane of this.set.lanes.values()) lane.held = null;
    for (const lane of this.movable()) lane.draw();
    this.set.onDrop();
    if (drag.moved || !kept) return;
    if (drag.already) this.set.selection.only(drag.lane.schedule.cell, drag.k);
    this.set.open(drag.lane, drag.k);
  }

  // On an empty place of a lane: a click moves the clock, a sweep chooses what it goes round.
  startBand(lane, event) {
    if (event.button !== 0) return;
    const { scale, selection } = this.set;
    const from = { x: event.clientX, y: event.clientY };
    const adds = event.shiftKey;
    lane.svg.setPointerCapture(event.pointerId);
    const follow = (moving) => {
      if (!this.sweep && Math.hypot(moving.clientX - from.x, moving.clientY - from.y) < CLICK_SLOP) return;
      this.sweep = { left: Math.min(from.x, moving.clientX), right: Math.max(from.x, moving.clientX), top: Math.min(from.y, moving.clientY), bottom: Math.max(from.y, moving.clientY) };
      this.drawBand();
    };
    const end = (ending) => {
      lane.svg.removeEventListener("pointermove", follow);
      for (const name of ["pointerup", "pointercancel"]) lane.svg.removeEventListener(name, end);
      const swept = this.sweep;
      this.sweep = null;
      this.band.hidden = true;
      if (ending.type !== "pointerup") return;
      if (swept) selection[adds ? "add" : "set"](this.inside(swept));
      else {
        if (!adds) selection.clear();
        this.set.seek(scale.t(lane.offset(ending)[0]));
      }
    };
    lane.svg.addEventListener("pointermove", follow);
    for (const name of ["pointerup", "pointercancel"]) lane.svg.addEventListener(name, end);
  }

  inside({ left, right, top, bottom }) {
    return [...this.set.lanes].map(([cell, lane]) => {
      const box = lane.svg.getBoundingClientRect();
      const within = ({ time, extension }) => {
        const [x, y] = [box.left + this.set.scale.x(time), box.top + lane.y(extension)];
        return this.set.scale.shows(time) && x >= left && x <= right && y >= top && y <= bottom;
      };
      return [cell, lane.points.flatMap((p, k) => (within(p) ? [k] : []))];
    });
  }

  drawBand() {
    const box = this.band.parentElement.getBoundingClientRect();
    const { left, right, top, bottom } = this.sweep;
    this.band.hidden = false;
    Object.assign(this.band.style, { left: `${left - box.left}px`, top: `${top - box.top}px`, width: `${right - left}px`, height: `${bottom - top}px` });
  }
}
