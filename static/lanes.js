// All lanes together: which points are chosen, and every edit of them as one patch, which is one step of undo.

import { $, setText } from "./dom.js";
import { CopyDialog } from "./copydialog.js";
import { describeKey } from "./keys.js";
import { Lane } from "./lane.js";
import { LaneDrag } from "./lanedrag.js";
import { openLaneMenu } from "./lanemenu.js";
import { PointEditor } from "./pointeditor.js";
import { addPatch, clean, movePatch, pastePatch, pointsPatch, removePatch } from "./schedule.js";
import { commandAt } from "./schedulecopy.js";
import { Selection } from "./selection.js";
import { Snap } from "./snap.js";

const HEIGHTS = [[2, 34], [3, 22], [Infinity, 20]]; // up to how many lanes, how high each is
const MANY = 4; // lanes: from here on the timeline is taller
const NAMES = { least: 206, most: 290, spare: 6 }; // px of the column of names, where there is room
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const FAST = 10;
const KEYS = [
  ["Tab", "To a lane's points, one by one"],
  [["Ctrl+Space", "Shift+Space"], "Add the point to those chosen, or take it away"],
  [["Ctrl+ArrowLeft", "Ctrl+ArrowRight"], "Add the point before or after to those chosen"],
  ["Ctrl+A", "Choose all points of the lane; once more: of all lanes"],
  ["Escape", "Choose none"],
  [["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], `Move the chosen points, ×${FAST} with Shift`],
  [["Enter", "Space"], "Type the point's numbers"],
  [["Delete", "Backspace"], "Delete the chosen points"],
  ["r", "Step or ramp"],
  [["Ctrl+C", "Ctrl+X"], "Copy or cut the chosen points"],
  ["Ctrl+V", "Paste points at the clock, into the lane last touched"],
  ["click", "On a point: type its numbers; elsewhere: move the clock there"],
  [["Shift+click", "Ctrl+click"], "Add the point to those chosen, or take it away"],
  [["drag", "Shift+drag"], "On a point: move it, or all that are chosen; elsewhere: choose what the sweep goes round (Shift: too)"],
  ["Alt+drag", "Move without snapping"],
  ["double click", "Add a point, on the command where that is near (Alt: without snapping)"],
];

const NEAR = 5; // px: a double click so near the command adds a point on it

// A point where the command is at a time, so that it changes nothing until it is moved.
function onCommand(lane, time) {
  const { points } = lane.schedule;
  const shape = points.find((p) => p.time > time)?.shape === "ramp" ? "ramp" : "step"; // part of a ramp stays on it
  return { time, extension: commandAt(points, lane.startValue(), time), shape };
}

export class LaneSet {
  // actions: edit(patch, {onRefused}), editLatest(patch), select(component index); onDrop: after a drag, when the axis may follow
  constructor({ scale, clock, actions, onDrop, say }) {
    Object.assign(this, { scale, clock, actions, onDrop, say, lanes: new Map(), clip: null, active: null, awaited: null, nearStop: null, snap: new Snap() });
    this.selection = new Selection(() => this.showChosen());
    this.drag = new LaneDrag(this, $("band"));
    this.editor = new PointEditor({
      onApply: ({ cell, k }, point) => this.changeOrTell(cell, (schedule) => movePatch(new Map([[schedule, new Map([[k, point]])]]))),
      onDelete: ({ cell, k }) => this.change(cell, (schedule) => removePatch(new Map([[schedule, [k]]]))),
    });
    this.copier = new CopyDialog(this);
    $("rows").addEventListener("keydown", (event) => this.press(event));
    this.describeKeys();
  }

  describeKeys() {
    for (const [keys, words] of KEYS) describeKey(keys, words, "Lanes");
  }

  hooks() {
    return {
      onPress: (lane, k, event) => {
        this.active = lane;
        this.drag.press(lane, k, event);
      },
      onKey: (lane, k, event) => this.pressOnPoint(lane, k, event),
      onBand: (lane, event) => {
        this.active = lane;
        this.drag.startBand(lane, event);
      },
      onAdd: (lane, event) => this.addAt(lane, event),
      nearStop: () => this.nearStop,
      onSelect: (lane) => this.actions.select(lane.component?.index),
      onMenu: (lane) => {
        this.active = lane;
        openLaneMenu(this, lane);
      },
    };
  }

  get list() {
    return [...this.lanes.values()];
  }

  sync(state) {
    const names = new Set(state.schedules.map((s) => s.cell));
    for (const [name, lane] of this.lanes) {
      if (names.has(name)) continue;
      lane.root.remove();
      this.lanes.delete(name);
    }
    const [, height] = HEIGHTS.find(([most]) => names.size <= most);
    state.schedules.forEach((schedule, place) => {
      if (!this.lanes.has(schedule.cell)) this.lanes.set(schedule.cell, new Lane(this.scale, this.hooks()));
      const lane = this.lanes.get(schedule.cell);
      lane.height = height;
      lane.update(schedule, state.components.find((c) => c.name === schedule.cell), state);
      // Re-appending an unmoved lane would take the focus from its points.
      const there = $("lanes").children[place];
      if (there !== lane.root) $("lanes").insertBefore(lane.root, there ?? null);
    });
    $("no-cells").hidden = state.schedules.length > 0;
    $("timeline").dataset.lanes = names.size >= MANY ? "many" : "few";
    this.fitNames(this.list.map((lane) => `${lane.schedule.cell} ${lane.locked}`).join("\n"));
    if (!this.lanes.has(this.active?.schedule.cell)) this.active = null;
    this.selection.prune((cell) => this.lanes.get(cell)?.schedule.points.length ?? 0);
    this.chooseAwaited(state.revision);
    this.showChosen();
  }

  // The column is as wide as the longest name asks for, as far as timeline.css leaves it room; measured only when there are others.
  fitNames(names) {
    if (names === this.named) return;
    this.named = names;
    const { least, most, spare } = NAMES;
    $("timeline").style.removeProperty("--names");
    const lacking = Math.max(0, ...this.list.map(({ name }) => name.lastChild.scrollWidth - name.lastChild.clientWidth));
    if (lacking > 0) $("timeline").style.setProperty("--names", `${Math.min(least + lacking + spare, most)}px`);
  }

  showChosen() {
    for (const [cell, lane] of this.lanes) lane.choose(this.selection.of(cell));
  }

  // `live` while something moves; all edits of one `gesture` are one step of undo.
  send(patch, lanes, { live = false, gesture, onRefused } = {}) {
    if (!patch.length) return Promise.resolve();
    const answer = live ? this.actions.editLatest(patch, gesture) : this.actions.edit(patch, { onRefused });
    for (const lane of lanes) lane.sent(answer);
    return answer;
  }

  // Edits find the schedule anew: indices may have changed since a popover was opened.
  change(cell, patchOf) {
    const lane = this.lanes.get(cell);
    return lane && !lane.fixed ? this.send(patchOf(lane.schedule), [lane]) : undefined;
  }

  // The problem why an edit was refused, or null: for whoever holds what was typed.
  async changeOrTell(cell, patchOf) {
    const lane = this.lanes.get(cell);
    if (!lane) return { title: `${cell} is gone`, detail: "Close this and choose another point." };
    if (lane.fixed) return { title: this.whyFixed(lane) };
    let problem = null;
    await this.send(patchOf(lane.schedule), [lane], { onRefused: (found) => (problem = found) });
    return problem;
  }

  // New points are chosen once they are there: indices are known only then.
  async chooseWhenDone(answer, times) {
    const done = await answer;
    if (!done) return;
    this.awaited = { revision: done.revision, times };
    this.chooseAwaited(this.list[0]?.revision ?? 0);
  }

  chooseAwaited(revision) {
    if (!this.awaited || revision < this.awaited.revision) return;
    const { times } = this.awaited;
    this.awaited = null;
    this.selection.set([...times].map(([cell, chosen]) => {
      const points = this.lanes.get(cell)?.schedule.points ?? [];
      return [cell, points.flatMap((p, k) => (chosen.some((t) => Math.abs(t - p.time) < 1e-3) ? [k] : []))];
    }));
  }

  open(lane, k) {
    if (!lane.fixed) this.editor.open({ cell: lane.schedule.cell, k, point: lane.points[k], moment: lane.moment(lane.points[k].time), anchor: lane.circles[k], unit: lane.typedUnit });
  }

  seek(t) {
    this.clock.seek(t);
  }

  addAt(lane, event) {
    if (lane.fixed) return this.say(this.whyFixed(lane));
    const [x, y] = lane.offset(event);
    const [t, e] = [this.scale.t(x), lane.valueAt(y)];
    const time = event.altKey ? t : this.snap.times(t, this.scale);
    const there = onCommand(lane, time);
    if (Math.abs(lane.y(there.extension) - y) > NEAR) {
      there.extension = lane.limited(event.altKey ? e : this.snap.extensions(e, lane.unit));
      there.shape = "step";
    }
    return this.change(lane.schedule.cell, (schedule) => addPatch(schedule, there));
  }

  addAtClock(lane) {
    const there = onCommand(lane, this.snap.times(this.clock.t, this.scale));
    const answer = this.change(lane.schedule.cell, (schedule) => addPatch(schedule, there));
    return answer && this.chooseWhenDone(answer, new Map([[lane.schedule.cell, [there.time]]]));
  }

  whyFixed({ schedule, locked }) {
    return locked ? `${schedule.cell} is locked: unlock it first, by its lock in the list of parts` : `${schedule.cell} is under control: its commands are the controller's`;
  }

  pressOnPoint(lane, k, event) {
    this.active = lane;
    const { cell } = lane.schedule;
    const arrow = ARROWS[event.key];
    const control = event.ctrlKey || event.metaKey;
    if (arrow && !control) {
      if (!this.selection.has(cell, k)) this.selection.only(cell, k);
      this.nudge(lane, k, arrow, event.shiftKey ? FAST : 1);
    } else if (arrow?.[0]) this.extend(lane, k, arrow[0]);
    else if (event.key === " " && (control || event.shiftKey)) this.selection.toggle(cell, k);
    else if (event.key === "Enter" || event.key === " ") this.open(lane, k);
    else {
      if (["Delete", "Backspace", "r", "R"].includes(event.key) && !this.selection.has(cell, k)) this.selection.only(cell, k);
      return; // press() has the rest
    }
    event.preventDefault();
    event.stopPropagation();
  }

  // Onwards from a point to its neighbour in sight, with both chosen.
  extend(lane, k, by) {
    const { cell, points } = lane.schedule;
    const next = points[k + by] && this.scale.shows(lane.points[k + by].time) ? k + by : k;
    this.selection.add([[cell, [k, next]]]);
    lane.circles[next].focus();
  }

  nudge(lane, k, [along, up], times) {
    if (lane.fixed) return this.say(this.whyFixed(lane));
    const [dt, de] = this.snap.nudge(this.scale, lane.unit);
    // From where the point was put, though its state may not have come yet.
    const [now, base] = [lane.points[k], lane.schedule.points[k]];
    const time = along ? this.snap.times(now.time + along * dt * times, this.scale) : now.time;
    const extension = up ? lane.limited(this.snap.extensions(now.extension + up * de * times, lane.unit)) : now.extension;
    return this.drag.shift(time - base.time, extension - base.extension, lane.unit);
  }

  press(event) {
    const control = event.ctrlKey || event.metaKey;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (event.target.closest("input, select, textarea, dialog, [popover]") || event.altKey) return;
    const acts = control
      ? { a: () => this.chooseAll(), c: () => this.copy(), x: () => this.copy() && this.remove(), v: () => this.paste() }
      : { Delete: () => this.remove(), Backspace: () => this.remove(), r: () => this.toggleShape(), Escape: () => this.selection.size > 0 && (this.selection.clear(), true) };
    if (!Object.hasOwn(acts, key) || event.shiftKey || acts[key]() === false) return;
    event.preventDefault();
    event.stopPropagation();
  }

  // Where all of the lane are chosen already, all of every lane.
  chooseAll(lane = this.active) {
    if (!lane) return false;
    const { cell, points } = lane.schedule;
    const lanes = this.selection.of(cell).size === points.length ? this.list : [lane];
    this.selection.set(lanes.map(({ schedule }) => [schedule.cell, schedule.points.map((_, k) => k)]));
    return true;
  }

  chosenPoints() {
    return this.selection.cells.map((cell) => [cell, [...this.selection.of(cell)].sort((a, b) => a - b).map((k) => this.lanes.get(cell).points[k])]);
  }

  // Times are kept from the first of all, so that what was apart stays apart.
  copy() {
    const chosen = this.chosenPoints();
    if (!chosen.length) return false;
    const first = Math.min(...chosen.map(([, points]) => points[0].time));
    const units = new Map(chosen.map(([cell]) => [cell, this.lanes.get(cell).unit.symbol]));
    this.clip = { chosen, first, units };
    this.say(`${this.selection.size} point${this.selection.size > 1 ? "s" : ""} copied: Ctrl+V puts them at the clock`);
    return true;
  }

  // One cell's points go into the lane last touched; those of several each into their own.
  paste(at = this.clock.t) {
    if (!this.clip) return false;
    const { chosen, first, units } = this.clip;
    const targets = chosen.map(([cell, points]) => [(chosen.length === 1 && this.active) || this.lanes.get(cell), cell, points]).filter(([lane]) => lane);
    const refused = targets.find(([lane, cell]) => lane.fixed || lane.unit.symbol !== units.get(cell));
    if (refused) return this.say(refused[0].fixed ? this.whyFixed(refused[0]) : `${refused[0].schedule.cell} moves in ${refused[0].unit.symbol}, not in ${units.get(refused[1])}`);
    const start = this.snap.times(at, this.scale);
    const put = targets.map(([lane, , points]) => [lane, points, start + points[0].time - first]);
    const patch = this.patchOf(put.map(([lane, points, when]) => [lane, (schedule) => pastePatch(schedule, points, { at: when, component: lane.component, duration: lane.duration })]));
    const times = new Map(put.map(([lane, points, when]) => [lane.schedule.cell, points.map((p) => p.time - points[0].time + when)]));
    return this.chooseWhenDone(this.send(patch, put.map(([lane]) => lane)), times);
  }

  patchOf(changes) {
    return changes.flatMap(([lane, make]) => make(lane.schedule));
  }

  remove() {
    const lanes = this.drag.movable();
    if (!lanes.length) return false;
    this.send(removePatch(new Map(lanes.map((lane) => [lane.schedule, [...this.selection.of(lane.schedule.cell)]]))), lanes);
    this.selection.clear();
    lanes[0].svg.focus({ preventScroll: true }); // its points go with the focus
    return true;
  }

  // All to the other shape of the first.
  toggleShape(shape = null) {
    const lanes = this.drag.movable();
    if (!lanes.length) return false;
    const [k] = this.selection.of(lanes[0].schedule.cell);
    const wanted = shape ?? (lanes[0].points[k].shape === "ramp" ? "step" : "ramp");
    const moves = lanes.map((lane) => [lane.schedule, new Map([...this.selection.of(lane.schedule.cell)].map((each) => [each, { ...lane.points[each], shape: wanted }]))]);
    this.send(movePatch(new Map(moves)), lanes);
    return true;
  }

  // A whole schedule anew, in another cell or in its own. Answers the problem why it was refused, or null.
  put(cell, points) {
    return this.changeOrTell(cell, (schedule) => pointsPatch(schedule, points.map(clean)));
  }

  draw() {
    for (const lane of this.list) lane.draw();
  }

  showTime(t) {
    for (const lane of this.list) lane.showTime(t);
  }

  lastPoint() {
    return Math.max(0, ...this.list.map((lane) => lane.points.at(-1)?.time ?? 0));
  }

  hint(state) {
    const free = state.schedules.filter((s) => !s.controlled);
    const words = "Double-click a lane to add a point · drag to move · sweep to choose several · ⋯ has more";
    setText($("lane-hint"), free.length || !state.schedules.length ? words : "All cells are under control: lanes show the commands they hold");
  }
}
