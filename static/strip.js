// The strip over the lanes: what happened, which phase guidance was in, which warnings when, and bookmarks to drag.

import { $, el, svg } from "./dom.js";
import { clockText } from "./format.js";
import { describeKey } from "./keys.js";
import { bars, eventsOf, grouped, tracksOf } from "./stripmarks.js";

const TRACKS = { vertical: "Phase", lateral: "Way" };
const MOST_WARNINGS = 3; // lines; more share the last
const SLOP = 3;
const KEYS = [
  [["Enter", "Space", "click"], "On a mark, bookmark or phase: the clock goes there; on a warning: to it in the list"],
  [["ArrowLeft", "ArrowRight", "drag"], "On a bookmark: move it"],
  ["click", "Beside them: the clock goes there"],
];
const ICONS = {
  surface: "M1.5 6c1.5-2 3-2 4.5 0s3 2 4.5 0M6 11V8.2",
  bed: "M1.5 9.5h9M3 9.5 1.5 11M6 9.5 4.5 11M9 9.5 7.5 11M6 2v5",
  end_of_stroke: "M10 1.5v9M1.5 6h7M6 3.5 8.5 6 6 8.5",
  dive: "M1.5 3h9L6 9.5z",
  climb: "M1.5 9h9L6 2.5z",
  waypoint: "M6 1.5 10.5 6 6 10.5 1.5 6z",
  end: "M3 1.5v9.5M3 2h7L8 4.5 10 7H3",
};
const FLAG = "M2.5 1h7v10L6 8.2 2.5 11z";

const icon = (path) => svg("svg", { viewBox: "0 0 12 12", "aria-hidden": "true" }, svg("path", { d: path }));

export class Strip {
  // onWarning(warning) shows it in the list; onBookmarks(list) keeps them; note(node, lines) tells words beside a mark
  constructor({ store, clock, scale, note, onWarning, onBookmarks }) {
    Object.assign(this, { store, clock, scale, note, onWarning, onBookmarks, root: $("strip") });
    for (const [keys, words] of KEYS) describeKey(keys, words, "Events");
    store.watch(["bookmarks", "warnings"], () => this.draw());
    store.watch(["focusedWarning"], () => this.markFocused());
  }

  get state() {
    return this.store.get("state");
  }

  draw() {
    const { state } = this;
    if (!state) return;
    // A mark with the focus is made anew at its new place, and has it again.
    const focused = this.root.contains(document.activeElement) ? document.activeElement.dataset.testid : null;
    this.root.replaceChildren(...[this.marks(state), ...this.phases(state), this.warnings()].filter(Boolean));
    if (focused) this.root.querySelector(`[data-testid="${CSS.escape(focused)}"]`)?.focus();
  }

  row(kind, label, nodes) {
    const track = el("div", { class: "strip-track" }, ...nodes);
    track.addEventListener("click", (event) => event.target === track && this.clock.seek(this.scale.t(event.clientX - track.getBoundingClientRect().left)));
    return el("div", { class: `row strip-row ${kind}` }, el("div", { class: "label" }, label), track);
  }

  marks(state) {
    const events = grouped(eventsOf(state.run, state.duration), this.scale).map((group, k) => this.event(group, k));
    const bookmarks = (this.store.get("bookmarks") ?? []).map((each, k) => [each, k]).filter(([{ t }]) => this.scale.shows(t)).map(([each, k]) => this.bookmark(each, k));
    return events.length || bookmarks.length ? this.row("events", "Events", [...events, ...bookmarks]) : null;
  }

  event({ x, time, kind, count, words }, k) {
    const mark = el("button", { type: "button", class: `mark ${kind}`, "aria-label": words.join(", "), "data-kind": kind, "data-testid": `event-${k}`, onclick: () => this.clock.seek(time) },
      icon(ICONS[kind] ?? ICONS.waypoint), count > 1 ? el("b", {}, String(count)) : null);
    mark.style.left = `${x}px`;
    this.note(mark, words);
    return mark;
  }

  bookmark({ t, name }, k) {
    const when = clockText(t, this.scale.end, { digits: 2 });
    const mark = el("button", { type: "button", class: "mark bookmark", "aria-label": `Bookmark ${name} at ${when}. Arrow keys move it`, "data-testid": `mark-bookmark-${k}` }, icon(FLAG));
    mark.style.left = `${this.scale.x(t)}px`;
    this.note(mark, [name, when]);
    mark.addEventListener("pointerdown", (event) => event.button === 0 && this.drag(event, mark, k));
    mark.addEventListener("keydown", (event) => this.press(event, k));
    return mark;
  }

  // The mark itself moves under the pointer; the list is kept once, where it is let go.
  drag(event, mark, k) {
    const from = event.clientX;
    const start = this.store.get("bookmarks")[k].t;
    let moved = false;
    mark.setPointerCapture(event.pointerId);
    const at = (moving) => this.scale.t(this.scale.x(start) + moving.clientX - from);
    const follow = (moving) => {
      moved ||= Math.abs(moving.clientX - from) > SLOP;
      if (moved) mark.style.left = `${this.scale.x(at(moving))}px`;
    };
    mark.addEventListener("pointermove", follow);
    const end = (ending) => {
      if (moved && ending.type === "pointerup") this.moveBookmark(k, at(ending));
      else this.clock.seek(start);
    };
    for (const name of ["pointerup", "pointercancel"]) mark.addEventListener(name, end, { once: true });
  }

  moveBookmark(k, t) {
    const bookmarks = this.store.get("bookmarks");
    const to = Math.min(Math.max(t, 0), this.clock.end);
    this.onBookmarks(bookmarks.map((each, place) => (place === k ? { ...each, t: to } : each)));
  }

  press(event, k) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const bookmark = this.store.get("bookmarks")[k];
    if (step) this.moveBookmark(k, bookmark.t + (step * this.scale.seconds) / 200);
    else if (event.key === "Enter" || event.key === " ") this.clock.seek(bookmark.t);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  phases(state) {
    return [...tracksOf(state.run?.phases ?? [])].map(([track, phases]) => this.row("phases", TRACKS[track] ?? track, phases.flatMap((phase, k) => this.band(phase, track, k))));
  }

  band({ name, tone, from, to }, track, k) {
    return bars([[from, to]], this.scale, 2).map(([left, width]) => {
      const band = el("button", { type: "button", class: `band tone-${tone}`, "aria-label": `${name}, from ${clockText(from, this.scale.end)} to ${clockText(to, this.scale.end)}`, "data-testid": `phase-${track}-${k}`, onclick: (event) => this.seekIn(event) }, width > 34 ? name : "");
      Object.assign(band.style, { left: `${left}px`, width: `${Math.max(width - 1, 1)}px`, padding: width > 34 ? "" : "0" });
      this.note(band, [name, `${clockText(from, this.scale.end)} to ${clockText(to, this.scale.end)}`]);
      return band;
    });
  }

  // Where it was clicked; from the keyboard, where it begins.
  seekIn(event) {
    const track = event.currentTarget.parentElement.getBoundingClientRect();
    const x = event.detail ? event.clientX : event.currentTarget.getBoundingClientRect().left;
    this.clock.seek(this.scale.t(x - track.left));
  }

  // Those of the run and of what follows from it; `index` is their place in the list at the right.
  warnings() {
    const timed = this.store.get("warnings").map((warning, index) => ({ ...warning, index })).filter(({ times }) => times?.length);
    if (!timed.length) return null;
    const lines = Array.from({ length: Math.min(timed.length, MOST_WARNINGS) }, () => []);
    timed.forEach((warning, k) => lines[Math.min(k, MOST_WARNINGS - 1)].push(...this.warning(warning, k)));
    const row = this.row("doubts", "Warnings", lines.map((nodes) => el("div", { class: "doubt-line" }, ...nodes)));
    return row;
  }

  warning(warning, k) {
    return bars(warning.times, this.scale).map(([left, width], part) => {
      const bar = el("button", { type: "button", class: `doubt ${warning.severity ?? "warn"}`, tabindex: part ? -1 : 0, "aria-label": `Warning: ${warning.message}`, "data-warning": warning.index, "data-testid": `doubt-${k}-${part}`, onclick: () => this.onWarning(warning) });
      Object.assign(bar.style, { left: `${left}px`, width: `${width}px` });
      this.note(bar, [warning.message]);
      for (const [event, index] of [["pointerenter", warning.index], ["focus", warning.index], ["pointerleave", null], ["blur", null]]) bar.addEventListener(event, () => this.store.set({ focusedWarning: index }));
      return bar;
    });
  }

  markFocused() {
    const index = this.store.get("focusedWarning");
    for (const bar of this.root.querySelectorAll("[data-warning]")) bar.classList.toggle("focused", Number(bar.dataset.warning) === index && index !== null);
  }
}
