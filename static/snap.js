// What drags and arrow keys move points by: steps of time and of extension, chosen once and remembered.

import { niceStep } from "./timescale.js";

const KEY = "glider-studio.snap";
export const TIME_STEPS = [["off", "↔ free"], ["0.1", "↔ 0.1 s"], ["0.5", "↔ 0.5 s"], ["1", "↔ 1 s"], ["grid", "↔ ticks"]];
export const EXTENSION_STEPS = [["off", "↕ free"], ["fine", "↕ 0.1 mm"], ["medium", "↕ 0.5 mm"], ["coarse", "↕ 1 mm"]];
const LENGTHS = { fine: 1e-4, medium: 5e-4, coarse: 1e-3 };
const ANGLES = { fine: Math.PI / 180, medium: Math.PI / 36, coarse: Math.PI / 18 };
const PRECISE = 1e6; // 0.1 has no exact binary form: 3 * 0.1 must still be written 0.3

const rounded = (value) => Math.round(value * PRECISE) / PRECISE;

export class Snap {
  constructor() {
    Object.assign(this, { time: "0.1", extension: "fine" }, this.read());
  }

  read() {
    try {
      const { time, extension } = JSON.parse(localStorage.getItem(KEY) ?? "{}");
      return { ...(TIME_STEPS.some(([id]) => id === time) && { time }), ...(EXTENSION_STEPS.some(([id]) => id === extension) && { extension }) };
    } catch {
      return {};
    }
  }

  choose(changes) {
    Object.assign(this, changes);
    try {
      localStorage.setItem(KEY, JSON.stringify({ time: this.time, extension: this.extension }));
    } catch {
      // Held by this page alone where the browser keeps nothing.
    }
  }

  // Seconds; 0 is free. Whole ticks are those of the axis as it is shown.
  timeStep(scale) {
    if (this.time === "off") return 0;
    return this.time === "grid" ? niceStep(scale.seconds, scale.span / 75) : Number(this.time);
  }

  extensionStep(unit) {
    return this.extension === "off" ? 0 : (unit.symbol === "°" ? ANGLES : LENGTHS)[this.extension];
  }

  times(t, scale) {
    const step = this.timeStep(scale);
    return step ? rounded(Math.round(t / step) * step) : t;
  }

  extensions(e, unit) {
    const step = this.extensionStep(unit);
    return step ? Math.round(e / step) * step : e;
  }

  // One press of an arrow key: the step, or where it is off (or too small to see) about a pixel.
  nudge(scale, unit) {
    return [Math.max(this.timeStep(scale), niceStep(scale.seconds, 1000)), this.extensionStep(unit) || unit.snap / 10];
  }
}
