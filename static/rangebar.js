// The played range over the ruler: its ends can be dragged, and moved by arrow keys.

import { $, el } from "./dom.js";
import { clockText } from "./format.js";

export class RangeBar {
  constructor({ scale, clock }) {
    Object.assign(this, { scale, clock, root: $("range-bar") });
    this.fill = el("div", { class: "range-fill" });
    this.ends = ["from", "to"].map((side) => this.makeEnd(side));
    this.root.append(this.fill, ...this.ends);
  }

  makeEnd(side) {
    const words = side === "from" ? "Start of the played range" : "End of the played range";
    const node = el("div", { class: `range-end ${side}`, role: "slider", tabindex: 0, "aria-label": words, title: words, "data-testid": `range-end-${side}` });
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      node.setPointerCapture(event.pointerId);
      const box = this.root.getBoundingClientRect();
      const follow = (moving) => this.put(side, this.scale.t(moving.clientX - box.left));
      node.addEventListener("pointermove", follow);
      const end = () => node.removeEventListener("pointermove", follow);
      for (const name of ["pointerup", "pointercancel"]) node.addEventListener(name, end, { once: true });
    });
    node.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      this.put(side, this.clock.range[side] + (step * this.scale.seconds) / 100);
      event.preventDefault();
      event.stopPropagation();
    });
    return node;
  }

  // An end cannot pass the other; the range stays at least a little one.
  put(side, t) {
    const { from, to } = this.clock.range;
    const least = this.scale.seconds / 200;
    this.clock.setRange(side === "from" ? { from: Math.min(t, to - least), to } : { from, to: Math.max(t, from + least) });
  }

  draw() {
    const { range, end } = this.clock;
    this.root.hidden = !range;
    if (!range) return;
    const [left, right] = [range.from, range.to].map((t) => Math.min(Math.max(this.scale.x(t), this.scale.left), this.scale.right));
    Object.assign(this.fill.style, { left: `${left}px`, width: `${Math.max(right - left, 1)}px` });
    this.ends.forEach((node, k) => {
      const t = k ? range.to : range.from;
      node.style.left = `${k ? right : left}px`;
      node.hidden = !this.scale.shows(t);
      for (const [name, value] of Object.entries({ min: 0, max: end, now: t, text: clockText(t, end) })) node.setAttribute(`aria-value${name}`, String(value));
    });
  }
}
