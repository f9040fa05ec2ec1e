// Looking closer at a stretch of time: wheel, keys, and the bar over the ruler that shows where in the whole one is.

import { $, el } from "./dom.js";
import { clockText } from "./format.js";
import { describeKey, onKey } from "./keys.js";

const STEP = 1.5; // one press of a key
const PER_WHEEL = 0.0022; // of the logarithm, a pixel of the wheel
const NUDGE = 0.1; // of the window, an arrow key
const GROUP = "Time shown";
const KEYS = [
  [["ArrowLeft", "ArrowRight"], "On an end of the time shown, or of the played range: move it"],
  ["wheel", "Over the ruler: look closer or from farther"],
  ["Ctrl+wheel", "The same over lanes and plots"],
  ["Shift+wheel", "Earlier or later, when looking closer"],
  ["drag", "On the bar over the ruler, or its ends: move them"],
  ["double click", "On the bar, the ruler or a plot: show the whole time"],
];

export class TimeZoom {
  // `onChange` is called after each change of the window.
  constructor({ scale, clock, onChange }) {
    Object.assign(this, { scale, clock, onChange, root: $("zoom-bar") });
    this.thumb = el("div", { class: "zoom-thumb" });
    this.handles = ["from", "to"].map((side) => el("div", { class: `zoom-handle ${side}`, role: "slider", tabindex: 0, "aria-label": side === "from" ? "First moment shown" : "Last moment shown", "data-testid": `zoom-${side}` }));
    this.root.append(this.thumb, ...this.handles);
    this.listen();
    onKey("+", () => this.by(STEP), { words: "Look closer at the clock", group: GROUP });
    onKey("-", () => this.by(1 / STEP), { words: "Look from farther", group: GROUP });
    onKey("0", () => this.reset(), { words: "Show the whole time", group: GROUP });
    for (const [keys, words] of KEYS) describeKey(keys, words, GROUP);
  }

  listen() {
    $("rows").addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.root.addEventListener("dblclick", () => this.reset());
    $("scrub").addEventListener("dblclick", () => this.reset());
    $("plots").addEventListener("dblclick", (event) => event.target.tagName === "CANVAS" && this.reset());
    this.grab(this.thumb, (dt, [from, to]) => [from + dt, to + dt]);
    this.grab(this.handles[0], (dt, [from, to]) => [Math.min(from + dt, to - this.scale.end / 500), to]);
    this.grab(this.handles[1], (dt, [from, to]) => [from, Math.max(to + dt, from + this.scale.end / 500)]);
    this.handles.forEach((handle, side) => handle.addEventListener("keydown", (event) => this.press(event, side)));
  }

  // Ctrl and the wheel zoom anywhere; over the ruler the wheel alone does. Sideways, or with Shift, it pans.
  wheel(event) {
    const over = event.target.closest(".ruler, .strip");
    const sideways = event.shiftKey ? event.deltaY || event.deltaX : event.deltaX;
    const x = event.clientX - $("scrub").parentElement.getBoundingClientRect().left;
    if (event.ctrlKey || event.metaKey || (over && !event.shiftKey && event.deltaY)) this.scale.zoom(Math.exp(-event.deltaY * PER_WHEEL), this.scale.t(x));
    else if (sideways && this.scale.zoomed) this.scale.pan((sideways / this.scale.span) * this.scale.seconds);
    else return;
    event.preventDefault();
    this.onChange();
  }

  by(factor) {
    const { t } = this.clock;
    this.scale.zoom(factor, this.scale.shows(t) ? t : (this.scale.from + this.scale.to) / 2);
    this.onChange();
  }

  reset() {
    this.scale.setWindow(0, this.scale.end);
    this.onChange();
  }

  grab(node, make) {
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      const [x, window] = [event.clientX, [this.scale.from, this.scale.to]];
      node.setPointerCapture(event.pointerId);
      const follow = (moving) => {
        const [from, to] = make(((moving.clientX - x) / this.scale.span) * this.scale.end, window);
        this.scale.setWindow(Math.max(from, 0), node === this.thumb ? to + Math.max(-from, 0) : Math.min(to, this.scale.end));
        this.onChange();
      };
      node.addEventListener("pointermove", follow);
      const end = () => node.removeEventListener("pointermove", follow);
      for (const name of ["pointerup", "pointercancel"]) node.addEventListener(name, end, { once: true });
    });
  }

  press(event, side) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    const by = step * NUDGE * this.scale.seconds;
    const [from, to] = [this.scale.from + (side ? 0 : by), this.scale.to + (side ? by : 0)];
    if (to - from > this.scale.end / 500) this.scale.setWindow(Math.max(from, 0), Math.min(to, this.scale.end));
    this.onChange();
    event.preventDefault();
    event.stopPropagation();
  }

  // Playing on beyond the window turns the page; whoever moves the clock sees it. Returns whether the window changed.
  follow(t) {
    if (!this.scale.zoomed || this.scale.shows(t)) return false;
    this.scale.setWindow(t - 0.05 * this.scale.seconds, t + 0.95 * this.scale.seconds);
    return true;
  }

  draw() {
    const { scale } = this;
    const share = (t) => scale.left + (t / scale.end) * scale.span;
    const [left, right] = [share(scale.from), share(scale.to)];
    this.root.dataset.zoomed = String(scale.zoomed);
    Object.assign(this.thumb.style, { left: `${left}px`, width: `${Math.max(right - left, 4)}px` });
    this.handles.forEach((handle, side) => {
      const t = side ? scale.to : scale.from;
      handle.style.left = `${side ? right : left}px`;
      for (const [name, value] of Object.entries({ min: 0, max: scale.end, now: t, text: clockText(t, scale.end, { digits: 2 }) })) handle.setAttribute(`aria-value${name}`, String(value));
    });
  }
}
