// The cursor of the time plots by keys: it reads their values at another time than the clock's, and takes the clock there.

import { $ } from "./dom.js";
import { clockText } from "./format.js";
import { describeKey } from "./keys.js";
import { clamp } from "./schedule.js";

const STEP = 0.01; // of the time shown
const FAST = 10;

// What keys alone have a use for, a click does not choose: the keys after it are the page's, as ever.
export function focusByKeysOnly(node) {
  node.addEventListener("mousedown", (event) => {
    event.preventDefault();
    document.activeElement?.blur?.();
  });
}

// A canvas as a slider: where in its range it is, in words.
export function sayPlace(canvas, { low, high, now, text }) {
  for (const [name, value] of Object.entries({ min: low, max: high, now, text })) canvas.setAttribute(`aria-value${name}`, String(value));
}

export class PlotCursor {
  // `plotOf` answers the plot of a canvas, or null.
  constructor({ scale, clock, hover, plotOf }) {
    Object.assign(this, { scale, clock, hover, plotOf, t: 0 });
    $("plots").addEventListener("focusin", ({ target }) => this.plotOf(target) && this.put(target, this.scale.shows(clock.t) ? clock.t : scale.from));
    $("plots").addEventListener("focusout", ({ target }) => this.plotOf(target) && hover.leave());
    $("plots").addEventListener("keydown", (event) => this.press(event));
    describeKey(["ArrowLeft", "ArrowRight"], `On a plot: its cursor back or on, ×${FAST} with Shift`, "Plots");
    describeKey(["Home", "End"], "On a plot: the cursor to the first or last moment shown", "Plots");
    describeKey("Enter", "On a plot: the clock to the cursor", "Plots");
    describeKey(["click", "drag"], "On a plot: the clock goes along", "Plots");
  }

  put(canvas, t) {
    const { scale } = this;
    this.t = t;
    this.hover.put(canvas, t);
    const values = this.plotOf(canvas).describe(t).map((row) => row.join(" "));
    sayPlace(canvas, { low: scale.from, high: scale.to, now: t, text: [clockText(t, scale.end, { digits: 2 }), ...values].join(", ") });
  }

  press(event) {
    if (!this.plotOf(event.target) || event.ctrlKey || event.metaKey || event.altKey) return;
    const { from, to, seconds } = this.scale;
    const by = seconds * STEP * (event.shiftKey ? FAST : 1);
    const next = { ArrowLeft: this.t - by, ArrowRight: this.t + by, Home: from, End: to }[event.key];
    if (event.key === "Enter") this.clock.seek(this.t);
    else if (next === undefined) return;
    else this.put(event.target, clamp(next, from, to));
    event.preventDefault();
    event.stopPropagation();
  }
}
